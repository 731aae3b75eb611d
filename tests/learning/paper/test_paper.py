"""The paper's learner: its roll-outs, its cost, its search, and Section III-B."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bath_drake.demonstrations.processing import canonical_demonstrations
from bath_drake.demonstrations.recording import read_recording
from bath_drake.field.navigation import NavigationField, flow_direction, phi
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.rollout import rollout
from bath_drake.learning.checkpoint import Arrays
from bath_drake.learning.cost import LearningProblem, ValidityMargins
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.paper import cost as paper_cost
from bath_drake.learning.paper import learner as paper
from bath_drake.learning.paper import simple_ga
from bath_drake.learning.paper.learner import PaperSettings
from bath_drake.learning.paper.simple_ga import SimpleGA
from bath_drake.learning.strokes import gather_strokes
from bath_drake.notation import FloatArray

_DISC = Workspace(np.zeros(2), np.array([2.0, 2.0]))
_GOAL = np.array([0.0, -0.8])
_RIGHT = 0.25  # where the disc is that bent the stroke
_WRONG = -0.12  # on the other side of the stroke
MakeStrokes = Callable[..., Any]


def _field(*rows: tuple[float, ...], kappa: float = 8.0) -> NavigationField:
    obstacles = ObstacleSet(np.array(rows)) if rows else ObstacleSet()
    return NavigationField(_DISC, _GOAL, kappa, obstacles)


def _problem(strokes: Any, points: int = 160) -> LearningProblem:
    return LearningProblem(gather_strokes(strokes, points), _DISC, ValidityMargins())


class OneDisc:
    """The paper's Fig. 3 and 4: a disc on the x axis, a stroke along the y axis."""

    kappa, dt = 40.0, 0.01
    low = np.array([-1.5, 0.0, 0.4, 0.4])  # only the disc's x is free
    high = np.array([1.5, 0.0, 0.4, 0.4])

    def __init__(self, make: MakeStrokes) -> None:
        bent = _field((_RIGHT, 0.0, 0.4, 0.4, 0.0), kappa=self.kappa)
        found = paper_cost.euler_rollout([0.0, 0.8], bent, dt=self.dt)
        assert found.arrived
        assert found.entries == 0
        # The least that a stroke is: the fixture's type, with other points.
        stroke = replace(make("line", 0, count=1)[0], points=found.path)
        self.problem = _problem([stroke])
        self.bend = float(np.abs(found.path[:, 0]).max())

    def cost(self, xs: FloatArray) -> FloatArray:
        return paper_cost.evaluate(xs, self.problem, self.kappa, self.dt).total

    def member(self, x: float) -> FloatArray:
        return np.array([x, 0.0, 0.4, 0.4])


@pytest.mark.parametrize("omega", [0.02, 0.1, 0.3])
def test_descent_alone_cannot_carry_an_obstacle_across_the_path(
    make_strokes: MakeStrokes, omega: float
) -> None:
    world = OneDisc(make_strokes)
    first = world.member(_WRONG)[None]
    settings = SimpleGA(descent=100, omega=omega)
    xs, costs, _ = simple_ga.descend(world.cost, first, world.low, world.high, settings)
    assert costs[0] < world.cost(first)[0]
    # Pushed away to the left, the paper's Final: nothing bends the path there, and
    # the cost is the stroke's own bend but for the far obstacle's remaining push.
    assert xs[0, 0] < -0.4
    assert costs[0] > 0.9 * world.bend


@pytest.mark.parametrize("seed", range(3))
def test_the_genetic_algorithm_carries_it_across(
    make_strokes: MakeStrokes, seed: int
) -> None:
    world = OneDisc(make_strokes)
    settings = SimpleGA(population=20, generations=15)
    first = np.tile(world.member(_WRONG), (settings.population, 1))
    found = paper.search(
        world.cost, world.low, world.high, settings, (seed,), first=first
    )
    assert found["best"][0] > 0.0
    # The stroke's points are some 0.01 apart: a cost is told that coarsely.
    assert found["best_cost"][0] < 0.02
    assert found["best"][0] == pytest.approx(_RIGHT, abs=0.02)


@pytest.mark.parametrize("dt", [0.05, 0.01])
def test_a_roll_out_in_free_space_is_eulers(dt: float) -> None:
    field = _field((0.1, 0.2, 0.3, 0.15, 0.4), (-0.5, -0.4, 0.1, 0.2, 0.0))
    found = paper_cost.euler_rollout([0.3, 0.9], field, dt=dt)
    q = np.array([0.3, 0.9])
    for point in found.path[:-3]:  # the last steps are shorter
        np.testing.assert_allclose(point, q, rtol=0.0, atol=1e-9)
        q = q + dt * flow_direction(q, field)
    assert found.arrived
    assert found.entries == 0


def test_small_steps_follow_the_guarded_roll_out() -> None:
    field = _field((0.1, 0.2, 0.3, 0.15, 0.4), (-0.5, -0.4, 0.1, 0.2, 0.0))
    for start in ([0.3, 0.9], [-0.6, 0.7], [1.0, 0.0]):
        guarded = rollout(start, field, step=1e-3).path
        apart = [
            discrete_frechet(
                paper_cost.euler_rollout(start, field, dt=dt, max_steps=5000).path,
                guarded,
            )
            for dt in (0.02, 0.001)
        ]
        # Of first order, and never finer than the points' distance.
        assert apart[1] < 2e-3
        assert apart[1] < 0.2 * apart[0]


def _eq_1(q: FloatArray, field: NavigationField) -> float:
    """The paper's Eq. 1 letter by letter, whatever beta's sign."""
    gamma = float(((q - field.goal) ** 2).sum())
    beta = 1.0 - float(((q / field.workspace.semi_axes) ** 2).sum())
    for x, y, a, b, angle in field.obstacles.theta:
        c, s = np.cos(angle), np.sin(angle)
        u, v = c * (q[0] - x) + s * (q[1] - y), c * (q[1] - y) - s * (q[0] - x)
        beta *= (u / a) ** 2 + (v / b) ** 2 - 1.0
    return float(gamma / (gamma**field.kappa + beta) ** (1.0 / field.kappa))


@pytest.mark.parametrize(
    "start",
    [
        (0.05, 0.5),  # within one obstacle
        (0.42, 0.3),  # within both
        (1.3, 1.6),  # beyond the rim
        (0.9, 0.1),  # free
    ],
)
def test_within_obstacles_a_step_goes_where_eq_1_falls(
    start: tuple[float, ...],
) -> None:
    field = _field((0.2, 0.3, 0.35, 0.25, 0.0), (0.6, 0.3, 0.3, 0.3, 0.0), kappa=2.0)
    q, h = np.array(start), 1e-6
    slope = np.array(
        [(_eq_1(q + e, field) - _eq_1(q - e, field)) / (2.0 * h) for e in h * np.eye(2)]
    )
    step = np.diff(
        paper_cost.euler_rollout(q, field, dt=1e-3, max_steps=1).path, axis=0
    )
    # Central differences of step 1e-6.
    np.testing.assert_allclose(
        step[0] / 1e-3, -slope / np.linalg.norm(slope), rtol=0.0, atol=1e-6
    )
    if (field.workspace.beta(q) > 0.0) and start == (0.9, 0.1):
        assert _eq_1(q, field) == pytest.approx(float(phi(q, field)), rel=1e-12)


def test_entries_are_counted_and_the_guarded_roll_out_has_none() -> None:
    thin = _field((0.1, 0.1, 0.3, 0.03, 0.5), kappa=40.0)
    coarse = paper_cost.euler_rollout([0.01, 0.8], thin, dt=0.1)
    assert coarse.arrived
    assert coarse.entries > 0
    fine = paper_cost.euler_rollout([0.01, 0.8], thin, dt=1e-3, max_steps=5000)
    assert fine.arrived
    assert fine.entries == 0
    assert rollout([0.01, 0.8], thin, step=0.1).min_beta > 0.0
    # A start within an obstacle is an entry too.
    assert paper_cost.euler_rollout([0.1, 0.1], thin, dt=0.01).entries >= 1


def test_c_is_the_mean_frechet_distance_of_the_roll_outs(
    make_strokes: MakeStrokes,
) -> None:
    problem = _problem(make_strokes("one period", 1), 80)
    low, high = PaperSettings().bounds(3)
    xs = np.random.default_rng(0).uniform(low, high, (20, 12))
    costs = paper_cost.evaluate(xs, problem, 8.0, 0.02)
    max_steps = int((1.5 * problem.strokes.length + 1.0) / 0.02)
    for k, x in enumerate(xs):
        field = paper_cost.decode(x, problem, 8.0)
        found = [
            paper_cost.euler_rollout(d[0], field, dt=0.02, max_steps=max_steps)
            for d in problem.strokes.points
        ]
        assert costs.entries[k] == sum(r.entries for r in found)
        assert costs.arrived[k] == pytest.approx(np.mean([r.arrived for r in found]))
        if costs.entries[k] > 0:
            continue  # a path along a boundary amplifies rounding
        for d, curve in enumerate(problem.strokes.points):
            assert costs.distances[k, d] == pytest.approx(
                discrete_frechet(found[d].path, curve), abs=1e-9
            )
    np.testing.assert_allclose(costs.total, costs.distances.mean(axis=1))
    alone = [paper_cost.evaluate(x[None], problem, 8.0, 0.02).total[0] for x in xs]
    np.testing.assert_array_equal(costs.total, alone)


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_c_turns_with_the_world_by_right_angles(
    make_strokes: MakeStrokes, quarters: int
) -> None:
    # Ellipses along the axes stay so, by no other angle.
    strokes = make_strokes("one period", 1)
    turn = np.linalg.matrix_power(np.array([[0.0, -1.0], [1.0, 0.0]]), quarters)
    turned = [replace(s, points=s.points @ turn.T) for s in strokes]
    low, high = PaperSettings().bounds(2)
    xs = np.random.default_rng(3).uniform(low, high, (30, 8))
    rows = xs.reshape(-1, 4).copy()
    rows[:, :2] = rows[:, :2] @ turn.T
    if quarters % 2:
        rows[:, 2:] = rows[:, 3:1:-1]
    here = paper_cost.evaluate(xs, _problem(strokes), 8.0, 0.02)
    there = paper_cost.evaluate(rows.reshape(xs.shape), _problem(turned), 8.0, 0.02)
    smooth = (here.entries == 0) & (here.arrived == 1.0)
    assert smooth.sum() > 5
    # Sums in another order round differently, and 100 steps amplify it.
    np.testing.assert_allclose(here.total[smooth], there.total[smooth], atol=1e-9)


def _small() -> PaperSettings:
    return PaperSettings(SimpleGA(population=12, generations=6))


def _recorded(folder: Path, strokes: Any, scale: float, offset: float) -> Any:
    """Strokes as recordings in other coordinates, and back in canonical space."""
    recordings = []
    for k, stroke in enumerate(strokes):
        lines = [
            f"{0.02 * i!r},{scale * x + offset!r},{scale * y - offset!r}"
            for i, (x, y) in enumerate(stroke.points.tolist())
        ]
        file = folder / f"{scale}_{offset}_{k}.csv"
        file.write_text("\n".join(["t,x,y", *lines, ""]), encoding="utf-8")
        recordings.append(read_recording(file))
    return canonical_demonstrations(recordings)[0]


@pytest.mark.parametrize(("scale", "offset"), [(0.5, 0.0), (4.0, 0.0), (1.0, 3.0)])
def test_where_and_how_large_strokes_were_recorded_does_not_tell(
    make_strokes: MakeStrokes, tmp_path: Path, scale: float, offset: float
) -> None:
    strokes = make_strokes("wide arc", 0, count=2)
    here = _problem(_recorded(tmp_path, strokes, 1.0, 0.0))
    there = _problem(_recorded(tmp_path, strokes, scale, offset))
    # What canonical space does not take out is rounding.
    np.testing.assert_allclose(here.strokes.points, there.strokes.points, atol=1e-9)
    found = [paper.learn(p, 2, _small(), 3) for p in (here, there)]
    # Differences of 1e-4 and six steps of 0.2 grad C make much of that rounding.
    assert found[0].cost == pytest.approx(found[1].cost, abs=1e-5)
    np.testing.assert_allclose(
        found[0].field.obstacles.theta, found[1].field.obstacles.theta, atol=1e-4
    )


def test_the_same_seed_gives_the_same_skill_and_the_best_never_gets_worse(
    make_strokes: MakeStrokes,
) -> None:
    problem = _problem(make_strokes("wide arc", 0))
    curves: list[list[Arrays]] = [[], [], []]
    results = [
        paper.learn(problem, 2, _small(), seed, report=curves[k].append)
        for k, seed in enumerate((3, 3, 4))
    ]
    assert results[0].field == results[1].field
    for one, other in zip(curves[0], curves[1], strict=True):
        for name in one:
            np.testing.assert_array_equal(one[name], other[name])
    assert results[0].field != results[2].field
    for curve, result in zip(curves, results, strict=True):
        costs = [state["best_cost"][0] for state in curve]
        evaluations = [state["evaluations"][0] for state in curve]
        assert len(curve) == 7
        assert (np.diff(costs) <= 0.0).all()
        assert costs[-1] < costs[0]
        assert costs[-1] == result.cost
        assert (np.diff(evaluations) > 0).all()
        assert evaluations[-1] == result.evaluations


def test_generations_that_are_stored_need_not_be_bred_again(
    make_strokes: MakeStrokes,
) -> None:
    problem = _problem(make_strokes("wide arc", 0))
    stored: dict[str, Arrays] = {}
    computed: list[str] = []

    def step(key: str, compute: Callable[[], Arrays]) -> Arrays:
        if key not in stored:
            computed.append(key)
            stored[key] = compute()
        return {name: array.copy() for name, array in stored[key].items()}

    whole = paper.learn(problem, 2, _small(), 3, step=step)
    assert computed == [f"generation {g}" for g in range(7)]
    assert whole.field == paper.learn(problem, 2, _small(), 3).field
    for g in (5, 6):
        del stored[f"generation {g}"]
    computed.clear()
    again = paper.learn(problem, 2, _small(), 3, step=step)
    assert computed == ["generation 5", "generation 6"]
    assert again.field == whole.field
    assert again.evaluations == whole.evaluations


def test_selection_favours_the_fit_and_draws_no_other_members() -> None:
    rng = np.random.default_rng(0)
    members = np.arange(4.0)[:, None]
    costs = np.array([0.1, 0.2, 0.4, 0.4])
    drawn = np.concatenate(
        [simple_ga.select(members, costs, rng)[:, 0] for _ in range(2000)]
    )
    shares = np.bincount(drawn.astype(int), minlength=4) / len(drawn)
    fitness = costs**-2.0
    # Three standard deviations of a share of 8000 draws.
    np.testing.assert_allclose(shares, fitness / fitness.sum(), atol=0.017)


def test_crossing_swaps_genes_of_pairs_and_loses_none() -> None:
    rng = np.random.default_rng(1)
    members = rng.normal(size=(9, 6))
    crossed = simple_ga.cross(members, 0.8, rng)
    np.testing.assert_array_equal(np.sort(crossed, axis=0), np.sort(members, axis=0))
    assert (crossed != members).any()
    np.testing.assert_array_equal(simple_ga.cross(members, 0.0, rng), members)


def test_mutation_stays_within_the_bounds_and_leaves_fixed_genes() -> None:
    rng = np.random.default_rng(2)
    low, high = np.array([-1.0, 0.5, 2.0]), np.array([1.0, 0.6, 2.0])
    members = np.tile((low + high) / 2.0, (400, 1))
    moved = simple_ga.mutate(members, low, high, 0.3, rng)
    assert (moved >= low).all()
    assert (moved <= high).all()
    assert (moved[:, 2] == 2.0).all()
    # As many genes a member as asked for: three standard deviations.
    assert (moved[:, :2] != members[:, :2]).mean() == pytest.approx(0.1, abs=0.032)


def test_descent_takes_no_step_that_raises_the_cost() -> None:
    def bowl(xs: FloatArray) -> FloatArray:
        return np.asarray((xs**2).sum(axis=1))

    first = np.array([[0.4, -0.3], [0.01, 0.0]])
    low, high = np.full(2, -1.0), np.full(2, 1.0)
    for omega, descent in ((0.1, 30), (1.5, 30)):
        settings = SimpleGA(descent=descent, omega=omega)
        xs, costs, evaluations = simple_ga.descend(bowl, first, low, high, settings)
        np.testing.assert_array_equal(costs, bowl(xs))
        assert (costs <= bowl(first)).all()
        assert evaluations >= 2 * (1 + 3)
        if omega == 0.1:
            # 0.8 of the way is left after each step; differences shift the end.
            np.testing.assert_allclose(xs, 0.0, atol=1e-3)
        else:
            np.testing.assert_array_equal(xs, first)


def test_no_obstacle_at_all_is_a_member_too(make_strokes: MakeStrokes) -> None:
    found = paper.learn(_problem(make_strokes("line", 0)), 0, _small(), 0)
    assert len(found.field.obstacles) == 0
    assert found.arrived == 1.0
    assert found.entries == 0
