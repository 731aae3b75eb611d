"""How well a method reproduces strokes: one protocol for all methods.

Canonical units, for each shape: every demonstration is moved so that it ends at the
goal (0, 0); then one factor makes the longest side of the joint box 1. A method learns
from a shape's demonstrations and is rolled out from the start of each. The score of a
roll-out is its discrete Fréchet distance to that demonstration, both at 200 points
equally spaced along them; that of a shape is the mean over its demonstrations. Held
out: learned without the demonstration whose start is used.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.strokes import resample
from bath_drake.notation import FloatArray

POINTS: Final = 200
# A roll-out that ends this near to the goal has reached it.
GOAL_TOLERANCE: Final = 0.02
# A roll-out that diverges scores badly, but finitely.
_LIMIT: Final = 10.0
# What lies nearer along the stroke than this share of it is no crossing: recordings
# of a resting hand knot.
_KNOT: Final = 0.05


@dataclass(frozen=True, eq=False)
class Demonstration:
    """One demonstration, in canonical units.

    Attributes:
        times: Shape (n,), s, from 0, not decreasing.
        points: Shape (n, 2), the last at (0, 0).
        path: The points at 200 equal shares of their length, shape (200, 2).
    """

    times: FloatArray
    points: FloatArray
    path: FloatArray


@dataclass(frozen=True, eq=False)
class Shape:
    """A stroke that was demonstrated several times.

    Attributes:
        name: What it is called.
        demonstrations: At least two.
    """

    name: str
    demonstrations: tuple[Demonstration, ...]

    @classmethod
    def of(cls, name: str, takes: Sequence[tuple[FloatArray, FloatArray]]) -> "Shape":
        """A shape in canonical units.

        Args:
            name: What it is called.
            takes: Times (n,), s, and points (n, 2), in any one unit.
        """
        moved = [points - points[-1] for _, points in takes]
        scale = 1.0 / float(np.ptp(np.concatenate(moved), axis=0).max())
        return cls(
            name,
            tuple(
                Demonstration(times - times[0], p * scale, resample(p * scale, POINTS))
                for (times, _), p in zip(takes, moved, strict=True)
            ),
        )

    @property
    def mean(self) -> FloatArray:
        """The mean at equal shares of arc length, shape (200, 2)."""
        paths = np.array([d.path for d in self.demonstrations])
        mean: FloatArray = paths.mean(axis=0)
        return mean

    @property
    def crosses_itself(self) -> bool:
        """Whether any demonstration does."""
        return any(crosses_itself(d.path) for d in self.demonstrations)

    def without(self, index: int) -> "Shape":
        """The shape less one demonstration, in the same units."""
        kept = self.demonstrations[:index] + self.demonstrations[index + 1 :]
        return Shape(self.name, kept)


@dataclass(frozen=True)
class Learned:
    """What a method has learned of a shape.

    Attributes:
        roll_out: From a start, shape (2,), to a path, shape (n, 2).
        proved: Whether it is proved to arrive from everywhere in free space.
        proves: Whether the motion from a start, shape (2,), is proved as well; None
            where `proved` says it of all.
        obstacles: How many virtual obstacles it has; NaN if it has no such thing.
    """

    roll_out: Callable[[FloatArray], FloatArray]
    proved: bool = False
    obstacles: float = float("nan")
    proves: Callable[[FloatArray], bool] | None = None


Method = Callable[[Shape], Learned]


@dataclass(frozen=True)
class Score:
    """How a method does on a shape.

    Attributes:
        shape: Its name.
        method: Its name.
        frechet: Mean over the demonstrations.
        worst: The greatest of these.
        to_mean: From the mean start, to the demonstrations' mean; NaN if held out.
        goal: Share of roll-outs that reach the goal.
        proved: Share of the motions from the demonstrations' starts that are proved.
        obstacles: Mean number of virtual obstacles.
        fit_seconds: To learn it, once.
        roll_out_seconds: Mean of a roll-out.
        crosses: Whether a demonstration crosses itself.
    """

    shape: str
    method: str
    frechet: float
    worst: float
    to_mean: float
    goal: float
    proved: float
    obstacles: float
    fit_seconds: float
    roll_out_seconds: float
    crosses: bool


def evaluate(name: str, method: Method, shape: Shape, held_out: bool = False) -> Score:
    """Scores one method on one shape."""
    count = len(shape.demonstrations)
    begin = time.perf_counter()
    if held_out:
        fits = [method(shape.without(i)) for i in range(count)]
    else:
        fits = [method(shape)]
    fit_seconds = (time.perf_counter() - begin) / len(fits)
    distances, arrived, seconds, proved = [], [], [], []
    for i, demonstration in enumerate(shape.demonstrations):
        learned = fits[i if held_out else 0]
        begin = time.perf_counter()
        path = learned.roll_out(demonstration.path[0].copy())
        seconds.append(time.perf_counter() - begin)
        proof = learned.proves
        proved.append(
            learned.proved and (proof is None or proof(demonstration.path[0]))
        )
        path = _usable(path, demonstration.path[0])
        distances.append(discrete_frechet(resample(path, POINTS), demonstration.path))
        arrived.append(float(np.linalg.norm(path[-1])) < GOAL_TOLERANCE)
    to_mean = float("nan")
    if not held_out:
        mean = shape.mean
        path = _usable(fits[0].roll_out(mean[0].copy()), mean[0])
        to_mean = discrete_frechet(resample(path, POINTS), resample(mean, POINTS))
    return Score(
        shape=shape.name,
        method=name,
        frechet=float(np.mean(distances)),
        worst=max(distances),
        to_mean=to_mean,
        goal=float(np.mean(arrived)),
        proved=float(np.mean(proved)),
        obstacles=float(np.mean([learned.obstacles for learned in fits])),
        fit_seconds=fit_seconds,
        roll_out_seconds=float(np.mean(seconds)),
        crosses=shape.crosses_itself,
    )


def crosses_itself(path: FloatArray) -> bool:
    """Whether a polyline of equal steps, shape (n, 2), crosses itself."""
    start, step = path[:-1], np.diff(path, axis=0)
    between = start[None] - start[:, None]
    turn = _cross(step[:, None], step[None])
    with np.errstate(divide="ignore", invalid="ignore"):
        along = _cross(between, step[None]) / turn
        other = _cross(between, step[:, None]) / turn
    hit = (along >= 0.0) & (along < 1.0) & (other >= 0.0) & (other < 1.0)
    return bool(np.triu(hit, max(2, round(_KNOT * len(path)))).any())


def _cross(u: FloatArray, v: FloatArray) -> FloatArray:
    product: FloatArray = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return product


def _usable(path: FloatArray, start: FloatArray) -> FloatArray:
    """A path up to where it stops being finite, clipped; at least the start."""
    path = np.asarray(path, dtype=np.float64).reshape(-1, 2)
    finite = np.isfinite(path).all(axis=1)
    if not finite.all():
        path = path[: int(np.argmin(finite))]
    if not len(path):
        path = start[None]
    return np.clip(path, -_LIMIT, _LIMIT)
