"""Learning a chain: a stroke cut into stages, each learned by itself."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from bath_drake.composition.branch import Branch
from bath_drake.composition.chain import Chain, Gate
from bath_drake.composition.conditioning import Conditioning
from bath_drake.field.obstacles import Workspace
from bath_drake.learning.alignment import Alignment
from bath_drake.learning.chain.cutting import cut, gate_at, stage_count
from bath_drake.learning.chain.responses import fit_conditioning
from bath_drake.learning.chain.stage import (
    LearnedStage,
    Stage,
    learn_stage,
    stage_problem,
)
from bath_drake.learning.checkpoint import Arrays, Steps, Under
from bath_drake.learning.cost import LearningProblem, ValidityMargins
from bath_drake.learning.trace import PlanTrial, StageTrial
from bath_drake.notation import FloatArray
from bath_drake.threads import parallel_map

# Turning of the mean, rad, that a stage may have: what is tried, the likeliest first.
TURNINGS = (1.4, 2.2, 1.0)
# Obstacles a stage may have.
MOST_OBSTACLES = 4
# An obstacle more must lower a stage's error by this, in N, to be kept.
OBSTACLE_PRICE = 0.0015
# A stage this good, in N, needs no further obstacle.
GOOD_ENOUGH = 0.006
# Least and greatest distance, in N, at which a stage is prepared to be entered aside.
_SPREAD = (0.015, 0.08)
# Starts so many times farther out than the demonstrations' are prepared for.
_RING = 1.2


@dataclass(frozen=True, eq=False)
class Plan:
    """A stroke cut into stages.

    Attributes:
        cuts: Indices of the mean, both ends included.
        stages: What each stage shall do.
        gates: Between them.
        conditioning: How the stages follow start and goal.
    """

    cuts: tuple[int, ...]
    stages: tuple[Stage, ...]
    gates: tuple[Gate, ...]
    conditioning: Conditioning


def plans(aligned: Alignment) -> list[Plan]:
    """Ways of cutting aligned demonstrations into stages, the likeliest first."""
    counts = [stage_count(aligned.mean, turning) for turning in TURNINGS]
    found = {p.cuts: p for p in (plan(aligned, n) for n in dict.fromkeys(counts))}
    return list(found.values())


def plan(aligned: Alignment, count: int) -> Plan:
    """Cuts the mean of aligned demonstrations into about ``count`` stages."""
    mean = aligned.mean
    cuts = cut(mean, count)
    conditioning = fit_conditioning(aligned, cuts)
    moves = [conditioning.similarities(start) for start in _starts(aligned)]
    gates: list[Gate] = []
    stages = []
    for k, (first, stop) in enumerate(pairwise(cuts)):
        entry = np.empty((0, 2))
        if k:
            # For other starts the stage before moves otherwise than this one.
            outlines = [
                move[k].back(_edge(gates[-1].moved(move[k - 1]))) for move in moves
            ]
            entry = np.concatenate(outlines)
        curve = mean[first : stop + 1]
        if k < len(cuts) - 2:
            gate, goal = gate_at(mean, stop, first)
            gates.append(gate)
            curve = np.concatenate([curve, goal[None]])
        away = aligned.points[:, first] - mean[first]
        spread = 0.5 * float(np.sqrt((away**2).sum(axis=1).mean()))
        stages.append(Stage(curve, float(np.clip(spread, *_SPREAD)), entry))
    return Plan(cuts, tuple(stages), tuple(gates), conditioning)


def _edge(gate: Gate) -> FloatArray:
    """Points all along a gate's boundary, (n, 2)."""
    arc = gate.outline(7)[:-1]
    side = np.linspace(arc[-1], arc[0], 7)[1:-1]
    return np.concatenate([arc, side])


def _starts(aligned: Alignment) -> FloatArray:
    """The mean's start, the demonstrations', and a ring about all of them."""
    starts, centre = aligned.points[:, 0], aligned.mean[0]
    radius = _RING * float(np.hypot(*(starts - centre).T).max())
    t = np.linspace(0.0, 2.0 * np.pi, 6, endpoint=False)
    ring = centre + radius * np.stack([np.cos(t), np.sin(t)], axis=-1)
    return np.concatenate([centre[None], starts, ring])


def compose(
    aligned: Alignment,
    how: Plan,
    workspace: Workspace,
    margins: ValidityMargins,
    seed: tuple[int, ...],
    tries: int,
    steps: Steps,
    report: Callable[[], None] = lambda: None,
    way: int = 0,
) -> tuple[Branch, PlanTrial]:
    """Learns a chain of aligned demonstrations, stage by stage.

    Args:
        aligned: What is learned.
        how: Into which stages it is cut.
        workspace: Of every field.
        margins: What keeps the fields valid.
        seed: Of the random generators.
        tries: How many members descend for each stage.
        steps: Where finished stages are kept.
        report: Called after each stage, from any thread.
        way: Number of the way of doing the stroke, for the trace.

    Returns:
        The branch, and what was tried for it.
    """

    def learn(k: int) -> tuple[LearnedStage, tuple[LearnedStage, ...]]:
        problem = stage_problem(how.stages[k], workspace, margins)
        # Plans of as many stages may still be cut elsewhere.
        own = Under(steps, f"cuts {' '.join(map(str, how.cuts))}/stage {k}")
        found = _fewest(problem, (*seed, len(how.stages), k), tries, own)
        report()
        return found

    learned = parallel_map(learn, range(len(how.stages)))
    branch = Branch(
        chain=Chain(tuple(best.field for best, _ in learned), how.gates),
        start=aligned.mean[0],
        starts=aligned.points[:, 0],
        mean=aligned.mean,
        conditioning=how.conditioning,
    )
    trial = PlanTrial(
        way=way,
        cuts=how.cuts,
        pieces=tuple(aligned.points[:, a : b + 1] for a, b in pairwise(how.cuts)),
        stages=tuple(tuple(map(_as_trial, tried)) for _, tried in learned),
        evaluations=sum(stage.evaluations for _, tried in learned for stage in tried),
    )
    return branch, trial


def _fewest(
    problem: LearningProblem, seed: tuple[int, ...], tries: int, steps: Steps
) -> tuple[LearnedStage, tuple[LearnedStage, ...]]:
    """The stage whose obstacles all pay for themselves, and what was tried."""
    best: LearnedStage | None = None
    tried = []
    for count in range(MOST_OBSTACLES + 1):
        rng = np.random.default_rng((*seed, count))
        learn = partial(_learned, problem, count, rng, tries)
        arrays = steps.step(f"{count} obstacles", learn)
        found = LearnedStage.unpack(arrays, problem)
        tried.append(found)
        if best is None or _price(found) < _price(best):
            best = found
        if best.proved and best.error <= GOOD_ENOUGH:
            break
    assert best is not None  # zero obstacles are always tried
    return best, tuple(tried)


def _learned(
    problem: LearningProblem, count: int, rng: np.random.Generator, tries: int
) -> Arrays:
    return learn_stage(problem, count, rng, tries).pack()


def _as_trial(stage: LearnedStage) -> StageTrial:
    count, (_, price) = len(stage.field.obstacles), _price(stage)
    return StageTrial(count, stage.error, price, stage.proved)


def _price(stage: LearnedStage) -> tuple[bool, float]:
    count = len(stage.field.obstacles)
    return not stage.proved, stage.error + OBSTACLE_PRICE * count
