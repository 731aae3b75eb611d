"""`bath-drake bench demonstrations`: processing, on recordings of known truth.

Composites of a slow stroke and cycles are taken apart, and noisy recordings are
denoised by three methods. The seeds are fixed, and no constant was chosen on them.
"""

import time

import numpy as np

from bath_drake.benchmarks.composites import random_composite
from bath_drake.benchmarks.denoising import Errors, compare
from bath_drake.benchmarks.figures import Figure, Progress, Report, Row
from bath_drake.demonstrations.processing import resample_by_arc_length
from bath_drake.demonstrations.separation import separate
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.notation import FloatArray

# From the issue that asks for it: shares of the longest side, and of the period.
FRECHET, PERIOD = 0.02, 0.03
COMPOSITES = 100
_SEED = 4096


def run(progress: Progress) -> Report:
    """Measures all; the rows are the methods of denoising."""
    progress("taking strokes apart", 0.0)
    figures = separation_figures()
    progress("denoising", 0.5)
    rows = [_row(name, *found) for name, found in compare().items()]
    ours, *others = rows
    best = min(float(row["frechet_max"]) for row in others)
    ratio = float(ours["frechet_max"]) / best
    figures.append(Figure("denoise_worst_to_best_other", ratio, "x", 1.0))
    progress("done", 1.0)
    return Report(figures, rows)


def separation_figures(count: int = COMPOSITES) -> list[Figure]:
    """Takes random composites apart, `count` of each kind; compares with the truth."""
    frechet, periods, took = _taken_apart(count, hard=False)
    hard_frechet, hard_periods, _ = _taken_apart(count, hard=True)
    beyond = (hard_frechet > FRECHET) | (hard_periods > PERIOD)
    missing = float(np.isinf(frechet).sum())
    return [
        Figure("separation_composites", count),
        Figure("separation_not_found", missing, "", 0.0),
        Figure("separation_frechet_median", float(np.median(frechet))),
        Figure("separation_frechet_max", float(frechet.max()), "", FRECHET),
        Figure("separation_period_error_max", float(periods.max()), "", PERIOD),
        Figure("separation_time_median", 1e3 * float(np.median(took)), "ms"),
        Figure("separation_hard_share_beyond", float(beyond.mean())),
    ]


def _taken_apart(count: int, hard: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Distance of the discrete part, error of the period, s; infinite if not found."""
    figures = np.full((count, 3), np.inf)
    for k in range(count):
        made = random_composite(np.random.default_rng([_SEED, hard, k]), hard)
        begin = time.perf_counter()
        part = separate(made.t, made.points)
        figures[k, 2] = time.perf_counter() - begin
        if part.period is None:
            continue
        ways = [
            resample_by_arc_length(made.t, points, 200)[1]
            for points in (part.discrete, made.discrete)
        ]
        side = float(np.ptp(made.discrete, axis=0).max())
        figures[k, 0] = discrete_frechet(*ways) / side
        figures[k, 1] = abs(part.period / made.period - 1.0)
    frechet, periods, took = figures.T
    return frechet, periods, took


def _row(name: str, parameter: float, found: list[Errors]) -> Row:
    row: dict[str, str | float | bool] = {
        "method": name,
        "parameter": parameter if parameter else float("nan"),
    }
    for key in ("rms", "frechet", "corner"):
        values = [getattr(errors, key) for errors in found]
        row[f"{key}_median"] = float(np.median(values))
        row[f"{key}_max"] = float(max(values))
    return row
