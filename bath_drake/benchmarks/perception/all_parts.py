"""`bath-drake bench perception`: every part, one after the other."""

from collections.abc import Sequence

from bath_drake.benchmarks.figures import Figure, Progress, Report, Row
from bath_drake.benchmarks.perception import areas, back, backgrounds, sensor

# The parts, and which share of the time each takes.
_PARTS = (
    (sensor.run, 0.1),
    (back.run, 0.6),
    (backgrounds.run, 0.15),
    (areas.run, 0.15),
)


def run(progress: Progress) -> Report:
    """Measures all parts; the details are those of the people that were filmed."""
    figures: list[Figure] = []
    rows: Sequence[Row] = ()
    begun = 0.0
    for part, takes in _PARTS:
        report = part(_within(progress, begun, takes))
        begun += takes
        if isinstance(report, Report):
            figures += report.figures
            # Of the other parts the figures tell all.
            rows = report.rows if part is back.run else rows
        else:
            figures += report
    return Report(figures, rows)


def _within(progress: Progress, begun: float, takes: float) -> Progress:
    return lambda what, share: progress(what, begun + takes * share)
