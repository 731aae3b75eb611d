"""How a skill does from ends that nobody demonstrated.

The paper evaluates its controller from "random initial and destination positions in the
canonical space" and calls the paths "very smooth" (Sec. V). Here that is measured, in
three rings about what was demonstrated: how many motions arrive, of how many that is
proved, how smooth they are beside the demonstrations, and how far they stray from the
corridor that the demonstrations make up.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bath_drake.certificate.result import Verdict
from bath_drake.composition.branch import Branch, nearest_branch
from bath_drake.composition.certify import certify_chain
from bath_drake.composition.rollout import chain_rollout
from bath_drake.field.navigation import min_beta
from bath_drake.field.rollout import RolloutStatus
from bath_drake.learning.cost import GOAL_TOLERANCE
from bath_drake.learning.strokes import headings, resample
from bath_drake.notation import BoolArray, FloatArray
from bath_drake.threads import parallel_map

RINGS = ("near", "far", "anywhere")
"""Ends as demonstrated; up to three times as far out; in all of the canonical box."""
LEAST_SPREAD = 0.05
"""Radius, in N, of the nearest ring where the demonstrations start at one point."""
# Points at which a path is measured: coarse, for its steps' corners are no jerk.
_POINTS = 48
# Steps of a path: longer than the learner's, so that many trials take little time.
_STEP = 0.02


@dataclass(frozen=True, eq=False)
class Ring:
    """Trials whose ends were drawn in one ring.

    Attributes:
        name: One of `RINGS`.
        starts: Shape (n, 2), in N.
        goals: Shape (n, 2).
        free: Whether start and goal lie in the free space of the moved chain's first
            and last field, shape (n,). If not, there is no path.
        arrived: Whether the roll-out arrives, shape (n,).
        verdicts: Of the certificate of each moved chain; None without a path.
        paths: The roll-outs, shape (T, 2) each; of one point where there is none.
        turning: Angle that each path's direction sweeps, rad, over that of the
            demonstrations; NaN where the path did not arrive, as are the next three.
        smoothness: `smoothness` of each path.
        distances: Greatest distance of each path to the nearest demonstration, in N.
        forced: What of that its ends alone impose: the greater of theirs.
    """

    name: str
    starts: FloatArray
    goals: FloatArray
    free: BoolArray
    arrived: BoolArray
    verdicts: tuple[Verdict | None, ...]
    paths: tuple[FloatArray, ...]
    turning: FloatArray
    smoothness: FloatArray
    distances: FloatArray
    forced: FloatArray

    @property
    def proved(self) -> BoolArray:
        """Whether each trial's chain is proved, shape (n,)."""
        return np.array([verdict == "proved" for verdict in self.verdicts])

    @property
    def strays(self) -> FloatArray:
        """How much farther than its ends each path gets from the corridor, (n,)."""
        return self.distances - self.forced

    def median(self, values: FloatArray) -> float:
        """Of an attribute, over the paths that arrived; NaN if none did."""
        return float(np.median(values[self.arrived])) if self.arrived.any() else np.nan


@dataclass(frozen=True, eq=False)
class Generalisation:
    """A skill's trials.

    Attributes:
        rings: In the order of `RINGS`.
        corridor: The demonstrated paths that distances are to, (T, 2) each.
        turning: Median turning of these, rad.
        smoothness: Their median smoothness.
        radius: Of the nearest ring of each branch, in N.
        spread: How many times as far out the second ring goes.
    """

    rings: tuple[Ring, ...]
    corridor: tuple[FloatArray, ...]
    turning: float
    smoothness: float
    radius: tuple[float, ...]
    spread: float


def evaluate_generalisation(
    branches: Sequence[Branch],
    corridor: Sequence[FloatArray] = (),
    *,
    count: int = 20,
    spread: float = 3.0,
    seed: int = 0,
) -> Generalisation:
    """Moves a skill's ends at random and follows it.

    The nearest ring holds starts no farther from the mean start than the
    demonstrations' own, and goals as far from the learned goal (where the
    demonstrations ended before they were laid onto one goal, a skill does not know);
    the second what lies beyond, up to ``spread`` times as far; the third the box
    [-1, 1]^2. Each start takes its nearest branch, as at run time.

    Args:
        branches: A skill's.
        corridor: Demonstrated paths (T, 2) in N; the branches' means if none are given.
        count: Trials in each ring, > 0.
        spread: How far out the second ring goes, > 1.
        seed: Of what is drawn; the same seed draws the same ends for the same skill.

    Raises:
        ValueError: An argument is out of its range.
    """
    if not branches or count < 1 or not spread > 1.0:
        raise ValueError(
            "need branches, count > 0 and spread > 1, got "
            f"{len(branches)} branches, {count}, {spread}"
        )
    paths = tuple(np.asarray(p, dtype=np.float64) for p in corridor)
    paths = paths or tuple(branch.mean for branch in branches)
    demonstrated = float(np.median([turning(path) for path in paths]))
    rng = np.random.default_rng(seed)
    rings = []
    for name in RINGS:
        ends = np.array([_draw(name, branches, spread, rng) for _ in range(count)])
        found = parallel_map(lambda e: _trial(branches, paths, *e), ends)
        rings.append(_ring(name, ends, found, demonstrated))
    return Generalisation(
        tuple(rings),
        paths,
        demonstrated,
        float(np.median([smoothness(path) for path in paths])),
        tuple(_radius(branch) for branch in branches),
        spread,
    )


def turning(path: FloatArray) -> float:
    """Angle that the direction of a path (T, 2) sweeps, without sign, rad."""
    return float(np.abs(np.diff(headings(resample(path, _POINTS)))).sum())


def smoothness(path: FloatArray) -> float:
    """Log dimensionless jerk of a path (T, 2) travelled at one speed; 0 if straight.

    -ln(L^3 times the integral of |d^3 q / ds^3|^2 over the arc length s in [0, L]):
    Hogan and Sternad, *Sensitivity of smoothness measures to movement duration,
    amplitude, and arrests*, 2009, with the logarithm of Balasubramanian et al., *On the
    analysis of movement smoothness*, 2015. Less is rougher; a circle has -7.35.
    """
    thirds = np.diff(resample(path, _POINTS), n=3, axis=0)
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    mean = float((thirds**2).sum(axis=1).mean()) * (_POINTS - 1) ** 6
    # Beyond this no path bends visibly; and a line's logarithm would be infinite.
    return -float(np.log(max(mean / float(steps.sum()) ** 2, 1.0)))


def corridor_distances(
    points: FloatArray, corridor: Sequence[FloatArray]
) -> FloatArray:
    """Distances of points (n, 2) to the nearest of polylines (T, 2), shape (n,)."""
    first = np.concatenate([path[:-1] for path in corridor])
    way = np.concatenate([np.diff(path, axis=0) for path in corridor])
    square = np.maximum((way**2).sum(axis=1), 1e-300)
    away = points[:, None] - first
    share = np.clip((away * way).sum(axis=2) / square, 0.0, 1.0)
    nearest = ((away - share[..., None] * way) ** 2).sum(axis=2).min(axis=1)
    return np.asarray(np.sqrt(nearest))


@dataclass(frozen=True, eq=False)
class _Trial:
    free: bool
    arrived: bool
    verdict: Verdict | None
    path: FloatArray
    distance: float
    forced: float


def _trial(
    branches: Sequence[Branch],
    corridor: Sequence[FloatArray],
    start: FloatArray,
    goal: FloatArray,
) -> _Trial:
    chain = nearest_branch(branches, start).chain_for(start, goal)
    first, last = chain.fields[0], chain.fields[-1]
    if not (min_beta(start, first) > 0.0 and min_beta(goal, last) > 0.0):
        return _Trial(False, False, None, start[None], np.nan, np.nan)
    found = chain_rollout(start, chain, step=_STEP, goal_tolerance=GOAL_TOLERANCE)
    # A chain could arrive elsewhere than it was asked to.
    missed = float(np.hypot(*(found.path[-1] - goal)))
    arrived = found.status is RolloutStatus.ARRIVED and missed <= 2.0 * GOAL_TOLERANCE
    verdict = certify_chain(chain).verdict
    if not arrived:
        return _Trial(True, False, verdict, found.path, np.nan, np.nan)
    away = corridor_distances(resample(found.path, _POINTS), corridor)
    forced = float(max(away[0], away[-1]))
    return _Trial(True, True, verdict, found.path, float(away.max()), forced)


def _ring(
    name: str, ends: FloatArray, trials: Sequence[_Trial], demonstrated: float
) -> Ring:
    arrived = np.array([trial.arrived for trial in trials])
    turned = np.full(len(trials), np.nan)
    smooth = np.full(len(trials), np.nan)
    for i, trial in enumerate(trials):
        if trial.arrived and len(trial.path) > 1:
            turned[i] = turning(trial.path) / max(demonstrated, 1e-3)
            smooth[i] = smoothness(trial.path)
    return Ring(
        name=name,
        starts=ends[:, 0],
        goals=ends[:, 1],
        free=np.array([trial.free for trial in trials]),
        arrived=arrived,
        verdicts=tuple(trial.verdict for trial in trials),
        paths=tuple(trial.path for trial in trials),
        turning=turned,
        smoothness=smooth,
        distances=np.array([trial.distance for trial in trials]),
        forced=np.array([trial.forced for trial in trials]),
    )


def _draw(
    name: str, branches: Sequence[Branch], spread: float, rng: np.random.Generator
) -> FloatArray:
    """A start and a goal, shape (2, 2)."""
    if name == "anywhere":
        return rng.uniform(-1.0, 1.0, (2, 2))
    branch = branches[int(rng.integers(len(branches)))]
    low, high = {"near": (0.0, 1.0), "far": (1.0, spread)}[name]
    # Even over the ring's area.
    radius = np.sqrt(rng.uniform(low**2, high**2, 2)) * _radius(branch)
    angle = rng.uniform(0.0, 2.0 * np.pi, 2)
    offsets = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return np.asarray(np.stack([branch.start, branch.chain.goal]) + offsets)


def _radius(branch: Branch) -> float:
    away = np.hypot(*(branch.starts - branch.start).T)
    return max(LEAST_SPREAD, float(away.max()))
