"""`bath-drake bench perception`: every part, one after the other."""

from bath_drake.benchmarks.figures import Progress, Report
from bath_drake.benchmarks.perception import areas, back, sensor

# Of the time of all, what sensors and restricted areas take.
_SENSORS, _AREAS = 0.1, 0.2


def run(progress: Progress) -> Report:
    """Measures all parts; the details are those of the people that were filmed."""
    sensors = sensor.run(lambda what, share: progress(what, _SENSORS * share))
    backs = back.run(
        lambda what, share: progress(what, _SENSORS + (1.0 - _SENSORS - _AREAS) * share)
    )
    found = areas.run(lambda what, share: progress(what, 1.0 - _AREAS * (1.0 - share)))
    return Report([*sensors.figures, *backs.figures, *found], backs.rows)
