"""`bench strokes` and `bench lasa`: how well strokes are learned, and by others."""

from collections.abc import Sequence
from dataclasses import asdict, replace

import numpy as np

from bath_drake.benchmarks.figures import Figure, Progress, Report, Settings
from bath_drake.benchmarks.methods import learner
from bath_drake.benchmarks.peers import PAPER, peers
from bath_drake.benchmarks.reproduction import Method, Score, Shape, evaluate
from bath_drake.benchmarks.shape_files import lasa_shapes, stroke_shapes
from bath_drake.learning.config import LearnerConfig
from bath_drake.resources import models_folder

OWN = "bath_drake"
# The same, held to a single field.
ONE = "one_field"
# In-sample; held out there is a target for the median only.
LASA_MEDIAN, LASA_MEAN, LASA_MAX, LASA_HELD_OUT = 0.035, 0.035, 0.060, 0.045
# A single field, where no demonstration crosses itself.
LASA_UNCROSSED = 0.080
OBSTACLES = 12.0
FIT_SECONDS, ONE_FIT_SECONDS = 15.0, 5.0
# The paper's sinusoid and a stroke of five reversals, from the mean start to the mean;
# a figure of eight to each demonstration.
SINE, ZIGZAG, FIGURE_EIGHT = 0.010, 0.040, 0.050
# What the learners cost, in units of another peer's, for the progress bar.
_COST = {OWN: 20.0, ONE: 10.0, PAPER: 20.0}


def run_strokes(settings: Settings, progress: Progress) -> Report:
    """The strokes of models/demonstrations/strokes."""
    methods = _methods(settings)
    folder = models_folder() / "demonstrations" / "strokes"
    scores = score(stroke_shapes(folder, settings.shapes), methods, settings, progress)
    figures = _summary(scores, settings)
    if not settings.held_out:
        own = {s.shape: s for s in scores if s.method == OWN}
        for name, target in (("sine", SINE), ("zigzag_long", ZIGZAG)):
            if name in own:
                figures.append(Figure(f"{name}_to_mean", own[name].to_mean, "", target))
        if "figure_eight" in own:
            value = own["figure_eight"].frechet
            figures.append(Figure("figure_eight_frechet", value, "", FIGURE_EIGHT))
    return _report(figures, scores, settings)


def run_lasa(settings: Settings, progress: Progress) -> Report:
    """The LASA handwriting data set, out of the folder given."""
    methods = _methods(settings)
    shapes = lasa_shapes(settings.data, settings.shapes)
    scores = score(shapes, methods, settings, progress)
    figures = _summary(
        scores,
        settings,
        median=LASA_HELD_OUT if settings.held_out else LASA_MEDIAN,
        mean=None if settings.held_out else LASA_MEAN,
        greatest=None if settings.held_out else LASA_MAX,
    )
    plain = [s.frechet for s in scores if s.method == ONE and not s.crosses]
    if plain:
        value = float(np.median(plain))
        name = f"{ONE}_uncrossed_frechet_median"
        figures.append(Figure(name, value, "", LASA_UNCROSSED))
    return _report(figures, scores, settings)


def score(
    shapes: Sequence[Shape],
    methods: dict[str, Method],
    settings: Settings,
    progress: Progress,
) -> list[Score]:
    """Every method on every shape."""
    # The first call of anything loads or compiles: that is no method's time.
    for name, method in _methods(settings, quick=True).items():
        progress(f"warming up {name}", 0.0)
        evaluate(name, method, _warm_up())
    cost = {name: _COST.get(name, 1.0) for name in methods}
    done, total = 0.0, len(shapes) * sum(cost.values())
    scores = []
    for shape in shapes:
        for name, method in methods.items():
            progress(f"{shape.name}: {name}", done / total)
            scores.append(evaluate(name, method, shape, settings.held_out))
            done += cost[name]
    progress("done", 1.0)
    return scores


def _methods(settings: Settings, quick: bool = False) -> dict[str, Method]:
    quick = quick or settings.quick
    config = LearnerConfig.quick() if quick else LearnerConfig()
    single = {} if settings.held_out else {ONE: learner(replace(config, fields="one"))}
    others = peers(quick) if settings.peers else {}
    return {OWN: learner(config), **single, **others}


def _warm_up() -> Shape:
    share = np.linspace(0.0, 1.0, 60)
    takes = []
    for height in (0.2, 0.25):
        points = np.stack([share, height * np.sin(np.pi * share)], axis=-1)
        takes.append((2.0 * share, points))
    return Shape.of("warm-up", takes)


def _summary(
    scores: Sequence[Score],
    settings: Settings,
    median: float | None = None,
    mean: float | None = None,
    greatest: float | None = None,
) -> list[Figure]:
    """Medians, means and extremes over the shapes, method by method."""
    kind = "held_out_" if settings.held_out else ""
    own = [s for s in scores if s.method == OWN]
    frechet = [s.frechet for s in own]
    figures = [
        Figure("shapes", len(own)),
        Figure(f"{kind}frechet_median", float(np.median(frechet)), "", median),
        Figure(f"{kind}frechet_mean", float(np.mean(frechet)), "", mean),
        Figure(f"{kind}frechet_max", max(frechet), "", greatest),
        Figure("goal_share", _mean(own, "goal"), "", 1.0, "at least"),
        Figure("proved_share", _mean(own, "proved"), "", 1.0, "at least"),
        Figure("obstacles_median", _median(own, "obstacles"), "", OBSTACLES),
        Figure("fit_seconds_median", _median(own, "fit_seconds"), "s", FIT_SECONDS),
        Figure("roll_out_seconds_median", _median(own, "roll_out_seconds"), "s"),
    ]
    for name in dict.fromkeys(s.method for s in scores if s.method != OWN):
        mine = [s for s in scores if s.method == name]
        figures += [
            Figure(f"{name}_{kind}frechet_median", _median(mine, "frechet")),
            Figure(f"{name}_{kind}frechet_mean", _mean(mine, "frechet")),
            Figure(f"{name}_{kind}frechet_max", max(s.frechet for s in mine)),
            _share(f"{name}_goal_share", mine, "goal"),
            _share(f"{name}_proved_share", mine, "proved"),
            Figure(
                f"{name}_fit_seconds_median",
                _median(mine, "fit_seconds"),
                "s",
                ONE_FIT_SECONDS if name == ONE else None,
            ),
            Figure(
                f"{name}_roll_out_seconds_median",
                _median(mine, "roll_out_seconds"),
                "s",
            ),
        ]
    return figures


def _share(name: str, scores: Sequence[Score], key: str) -> Figure:
    """A share that must be whole for what is the project's own."""
    target = 1.0 if scores[0].method in (OWN, ONE) else None
    return Figure(name, _mean(scores, key), "", target, "at least")


def _median(scores: Sequence[Score], key: str) -> float:
    return float(np.median([getattr(score, key) for score in scores]))


def _mean(scores: Sequence[Score], key: str) -> float:
    return float(np.mean([getattr(score, key) for score in scores]))


def _report(
    figures: list[Figure], scores: Sequence[Score], settings: Settings
) -> Report:
    if settings.quick or settings.shapes:
        # Targets are for all shapes at full effort.
        figures = [Figure(f.name, f.value, f.unit) for f in figures]
    return Report(figures, [asdict(score) for score in scores])
