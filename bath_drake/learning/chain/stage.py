"""Learning one stage of a chain: a short stroke, from its gate to the next.

A stage is learned like a stroke of its own, that ends at the goal beyond its gate. What
comes in through the gate before comes in a little aside, so the flow must also lead
back: strokes that start beside it, and behind it, are learned along with it.
"""

from dataclasses import dataclass, replace

import numpy as np

from bath_drake.certificate.certify import certify
from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.field.obstacles import Workspace
from bath_drake.learning import genome, shooting
from bath_drake.learning.checkpoint import Arrays
from bath_drake.learning.cost import LearningProblem, ValidityMargins
from bath_drake.learning.failures import FAILURES, costs_of
from bath_drake.learning.seeding import seed_population
from bath_drake.learning.strokes import StrokeSet, headings, resample
from bath_drake.notation import FloatArray

# Steps of a stage's strokes, in N.
STEP = 0.03
# Strokes that start aside come back over this share of the stage.
_RETURN = 0.35
_REPAIRS = 3
# First members for each one that descends.
_SEEDS = 16
# Kappa to begin with where there is no obstacle: 2.
_LN_KAPPA = 0.7


@dataclass(frozen=True, eq=False)
class Stage:
    """What one stage shall do.

    Attributes:
        curve: From where it is entered to its goal, shape (n, 2), in N.
        spread: How far aside it is entered, in N.
        entry: Points where it may be entered, which must be free, shape (n, 2).
    """

    curve: FloatArray
    spread: float
    entry: FloatArray


@dataclass(frozen=True, eq=False)
class LearnedStage:
    """A field for a stage.

    Attributes:
        member: The learner's vector of it (`bath_drake.learning.genome`).
        field: Its navigation field.
        error: What is left of the stage's cost, about a distance in N.
        proved: Whether the field is proved.
        evaluations: Members' roll-outs that learning it took.
    """

    member: FloatArray
    field: NavigationField
    error: float
    proved: bool
    evaluations: int

    @property
    def rank(self) -> tuple[bool, float]:
        """Proved ones first, then the nearer."""
        return not self.proved, self.error

    def pack(self) -> Arrays:
        """As arrays, for a checkpoint."""
        numbers = (self.error, float(self.proved), float(self.evaluations))
        return {"member": self.member, "numbers": np.array(numbers)}

    @classmethod
    def unpack(cls, arrays: Arrays, problem: LearningProblem) -> "LearnedStage":
        """What `pack` gave."""
        member = arrays["member"]
        error, proved, evaluations = arrays["numbers"].tolist()
        field = genome.decode(member, problem.workspace, problem.strokes.goal)
        return cls(member, field, error, bool(proved), int(evaluations))


def stage_problem(
    stage: Stage, workspace: Workspace, margins: ValidityMargins
) -> LearningProblem:
    """The stage as a learning problem: its stroke, and those beside and behind it."""
    length = float(np.linalg.norm(np.diff(stage.curve, axis=0), axis=1).sum())
    count = max(12, round(length / STEP) + 1)
    main = resample(stage.curve, count)
    tangent = main[2] - main[0]
    tangent /= np.hypot(*tangent)
    across = np.array([-tangent[1], tangent[0]])
    fading = np.exp(-np.linspace(0.0, 1.0, count) / _RETURN)[:, None]
    fading *= np.linspace(1.0, 0.0, count)[:, None]
    strokes = [main]
    strokes += [main + side * stage.spread * fading * across for side in (1.0, -1.0)]
    behind = main[0] - 0.08 * tangent
    strokes.append(resample(np.concatenate([behind[None], main]), count))
    goal = main[-1].copy()
    points = np.array(strokes)
    points[:, -1] = goal
    return LearningProblem(
        StrokeSet(
            points=points,
            mean=main,
            goal=goal,
            offsets=np.zeros((len(points), 2)),
            scale=float(np.ptp(points.reshape(-1, 2), axis=0).max()),
            turning=float(np.abs(np.diff(headings(main))).sum()),
        ),
        workspace,
        margins,
        clear=stage.entry,
    )


def learn_stage(
    problem: LearningProblem, count: int, rng: np.random.Generator, tries: int = 4
) -> LearnedStage:
    """Finds a field of ``count`` obstacles for a stage; the best proved one if any is.

    Seeds matched to the wished direction of flow, multiple shooting on short windows
    of ``tries`` of them, then on whole strokes, then, of the better half, nearly the
    Fréchet distance; the proof last.
    """
    short, whole = _windows(problem)
    seeds = np.array([[_LN_KAPPA]])
    if count:
        seeds = seed_population(problem, count, _SEEDS * tries, rng)
        costs = costs_of(
            lambda xs: shooting.shooting_cost(xs, problem, whole, 2.0, 2.0), seeds
        )
        seeds = seeds[np.argsort(costs, kind="stable")[:tries]]
    evaluations = _SEEDS * tries
    fits = []
    for x in seeds:
        for windows, mu in ((short, 20.0), (whole, 100.0)):
            x, cost, more = _fit(x, problem, windows, 2.0, mu)
            evaluations += more
        fits.append((cost, x))
    fits.sort(key=lambda found: found[0])
    finished = [_finish(x, problem, whole) for _, x in fits[: (tries + 1) // 2]]
    evaluations += sum(found.evaluations for found in finished)
    best = min(finished, key=lambda found: found.rank)
    return replace(best, evaluations=evaluations)


def _fit(
    x: FloatArray,
    problem: LearningProblem,
    windows: shooting.Windows,
    power: float,
    mu: float,
) -> tuple[FloatArray, float, int]:
    """As `shooting.fit`; a member that fails stays what it is, at infinite cost."""
    try:
        found, cost, count = shooting.fit(
            x, problem, windows, power=power, mu=mu, iterations=20
        )
    except FAILURES:
        return x, np.inf, 1
    return found, cost if np.isfinite(cost) else np.inf, count


def _windows(problem: LearningProblem) -> tuple[shooting.Windows, shooting.Windows]:
    """Short windows, and whole strokes with some short ones."""
    strokes = problem.strokes.points
    short = shooting.cut_windows(strokes[[0, 3]], 8, 3)
    whole = shooting.whole_strokes(strokes[:1], 0.5)
    whole += shooting.whole_strokes(strokes[1:], 0.3)
    return short, whole + shooting.cut_windows(strokes[[0]], 8, 4, 0.2)


def _finish(
    x: FloatArray, problem: LearningProblem, windows: shooting.Windows
) -> LearnedStage:
    """Nearly the Fréchet distance; mends what is not proved."""
    evaluations = 0
    for attempt in range(_REPAIRS + 1):
        # A mean of sixth powers is ruled by the greatest distance, as Fréchet is.
        x, _, more = _fit(x, problem, windows, 6.0, 400.0)
        evaluations += more
        field = genome.decode(x, problem.workspace, problem.strokes.goal)
        free = bool((min_beta(problem.clear_points, field) > 0.0).all())
        proved = free and certify(field).passed
        if proved or attempt == _REPAIRS:
            break
        m = problem.margins
        # Spurious minima go as kappa grows and slits widen.
        wider = replace(
            m,
            pair=m.pair + 0.02,
            kappa=1.3 * float(np.exp(x[-1])) / max(1, genome.obstacle_count(x)),
            curvature=m.curvature + 0.1,
        )
        problem = replace(problem, margins=wider)
    (error,) = costs_of(
        lambda xs: shooting.shooting_cost(xs, problem, windows, 6.0, 0.0), x[None]
    ).tolist()
    return LearnedStage(x, field, error, proved, evaluations)
