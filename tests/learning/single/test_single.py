"""The search for one field: branches, the criterion, generations, proofs."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from bath_drake.certificate.certify import certify
from bath_drake.field.obstacles import Workspace
from bath_drake.learning import genome, shooting
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.cost import LearningProblem, ValidityMargins
from bath_drake.learning.journal import Journal
from bath_drake.learning.seeding import bends
from bath_drake.learning.single.population import Population
from bath_drake.learning.single.search import _Search, finished, single_fields
from bath_drake.learning.single.sides import Tree
from bath_drake.learning.strokes import gather_strokes

_DISC = Workspace(np.zeros(2), np.array([2.0, 2.0]))
MakeStrokes = Callable[..., Any]


def _problem(make: MakeStrokes, shape: str) -> LearningProblem:
    return LearningProblem(
        gather_strokes(make(shape, 1), 100), _DISC, ValidityMargins()
    )


def _journal(problem: LearningProblem) -> Journal:
    return Journal(1, problem.strokes.scale, None)


def test_branches_offer_both_sides_of_every_bend(make_strokes: MakeStrokes) -> None:
    problem = _problem(make_strokes, "one and a half periods")
    tree = Tree(problem, 300)
    turns = bends(problem.strokes.mean)
    grown = tree.grow([tree.root()], 100, np.random.default_rng(0))
    assert {b.places for b in grown} == {(k,) for k in range(2 * len(turns))}
    for branch in grown:
        # Where it stands is where it is found to stand.
        assert tree.root(branch.member).places == branch.places


def test_the_best_place_for_one_obstacle_is_within_the_bend(
    make_strokes: MakeStrokes,
) -> None:
    problem = _problem(make_strokes, "wide arc")
    ((_, turning),) = bends(problem.strokes.mean)
    tree = Tree(problem, 300)
    (best,) = tree.grow([tree.root()], 1, np.random.default_rng(0))
    assert best.places == ((0,) if turning > 0.0 else (1,))


def test_branches_grow_by_one_and_differ(make_strokes: MakeStrokes) -> None:
    problem = _problem(make_strokes, "S")
    tree = Tree(problem, 60)
    rng = np.random.default_rng(1)
    branches = [tree.root()]
    for depth in range(1, 4):
        before = branches
        branches = tree.grow(branches, 5, rng)
        assert len(branches) == 5
        assert {len(b.rows) for b in branches} == {depth}
        assert len({b.places for b in branches}) == 5
        mismatches = [b.mismatch for b in branches]
        assert mismatches == sorted(mismatches)
        assert all(any((b.rows[:-1] == a.rows).all() for a in before) for b in branches)


@given(st.lists(st.tuples(st.integers(0, 4), st.floats(0.0, 1.0)), max_size=12))
def test_populations_sort_pack_and_drop_copies(pairs: list[tuple[int, float]]) -> None:
    members = [np.full(5 * q + 1, cost) for q, cost in pairs]
    costs = np.array([cost for _, cost in pairs])
    whole = Population.of(members, costs)
    assert (np.diff(whole.costs) >= 0.0).all()
    again = Population.unpack(whole.pack())
    np.testing.assert_array_equal(again.costs, whole.costs)
    for x, y in zip(again.members, whole.members, strict=True):
        np.testing.assert_array_equal(x, y)
    few = whole.distinct(5)
    assert len(few.members) <= 5
    if members:
        assert few.costs[0] == whole.costs[0]
        assert len((whole + whole).distinct(100).members) == len(
            whole.distinct(100).members
        )


def test_what_has_no_finite_cost_is_no_member() -> None:
    found = Population.of([np.zeros(1), np.ones(1)], np.array([np.inf, 2.0]))
    np.testing.assert_array_equal(found.costs, [2.0])
    np.testing.assert_array_equal(found.members[0], [1.0])


def test_no_generation_is_worse_than_the_last(make_strokes: MakeStrokes) -> None:
    problem = _problem(make_strokes, "zigzag")
    config = replace(LearnerConfig.quick(), target=0.0)
    search = _Search(problem, config, _journal(problem))
    found = search.by_direction()
    for number in range(3):
        before, found = found, search.next(found, number)
        assert found.costs[0] <= before.costs[0]
        again = search.next(before, number)
        np.testing.assert_array_equal(again.costs, found.costs)


def test_finishing_keeps_what_is_proved_and_gets_no_worse(
    make_strokes: MakeStrokes,
) -> None:
    problem = _problem(make_strokes, "J")
    search = _Search(problem, LearnerConfig.quick(), _journal(problem))
    x = search.by_direction().members[0]
    y, cost, _ = finished(x, problem)
    before, after = (
        float(problem.evaluate(z[None], grid=False).total[0]) for z in (x, y)
    )
    assert cost == after
    proofs = [certify(genome.decode(z, _DISC, problem.strokes.goal)) for z in (x, y)]
    if proofs[0].passed:
        assert after <= before
        assert proofs[1].passed


@pytest.mark.parametrize("count", [0, 3])
def test_a_number_of_obstacles_that_is_asked_for_is_kept(
    make_strokes: MakeStrokes, count: int
) -> None:
    problem = _problem(make_strokes, "wide arc")
    config = replace(LearnerConfig.quick(), obstacles=count, generations=1, target=0.0)
    fields = single_fields(problem, config, _journal(problem))
    assert {len(field.obstacles) for field in fields} == {count}


def test_a_descent_never_raises_the_cost(make_strokes: MakeStrokes) -> None:
    problem = _problem(make_strokes, "C")
    windows = shooting.whole_strokes(problem.strokes.points)
    tree = Tree(problem, 60)
    branches = tree.grow([tree.root()], 3, np.random.default_rng(2))
    for x in (b.member for b in branches):
        costs = [
            shooting.fit(x, problem, windows, iterations=n)[1] for n in range(0, 12, 2)
        ]
        assert (np.diff(costs) <= 0.0).all()
