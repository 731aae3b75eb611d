"""`bath-drake bench perception`: every part, one after the other."""

from bath_drake.benchmarks.figures import Progress, Report
from bath_drake.benchmarks.perception import back, sensor

# Of the time of all, what the sensors take.
_SENSORS = 0.1


def run(progress: Progress) -> Report:
    """Measures all parts; the details are those of the people that were filmed."""
    sensors = sensor.run(lambda what, share: progress(what, _SENSORS * share))
    backs = back.run(
        lambda what, share: progress(what, _SENSORS + (1.0 - _SENSORS) * share)
    )
    return Report([*sensors.figures, *backs.figures], backs.rows)
