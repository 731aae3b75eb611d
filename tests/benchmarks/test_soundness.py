import numpy as np
import pytest

from bath_drake.benchmarks.evidence import Evidence
from bath_drake.benchmarks.random_worlds import disjoint_world, overlapping_world
from bath_drake.benchmarks.soundness import (
    judge,
    points_of,
    random_boxes,
    realisation,
    varied_world,
    wrong_boxes,
)
from bath_drake.certificate import box_test, isolation
from bath_drake.certificate.world import Uncertainty
from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.field.obstacles import ObstacleSet, Workspace

COUNT = 4000


def trapping_world():
    """A wide obstacle broadside to the goal: a minimum at (-0.97537, 0)."""
    return NavigationField(
        Workspace(np.zeros(2), np.full(2, 5.0)),
        np.array([3.0, 0.0]),
        10.0,
        ObstacleSet(np.array([[-0.5, 0.0, 0.2, 1.6, 0.0]])),
    )


@pytest.fixture(scope="module")
def case():
    """Evidence on a world, boxes about it, points in them, and what is said of them."""
    rng = np.random.default_rng(7)
    field = trapping_world()
    evidence = Evidence.of(field)
    boxes = random_boxes(rng, field, evidence.roots, COUNT)
    q = points_of(rng, boxes)
    levels = np.full(COUNT, np.inf)
    verdicts, kinds = judge(field, boxes, levels)
    return evidence, boxes, q, levels, verdicts, kinds


def test_the_evidence_holds_the_minimum_and_the_saddles():
    evidence = Evidence.of(trapping_world())
    ((x, y),) = evidence.roots[evidence.minima]
    # The figure is given to five digits.
    np.testing.assert_allclose([x, y], [-0.97537, 0.0], atol=1e-5)
    saddles = evidence.roots[~evidence.minima]
    np.testing.assert_allclose(
        saddles, [[-0.55205, -1.97946], [-0.55205, 1.97946]], atol=1e-5
    )


@pytest.mark.parametrize("make", [disjoint_world, overlapping_world])
def test_no_box_is_judged_wrongly(make, rng):
    for kappa in (3.0, 100.0):
        assert wrong_boxes(rng, make(rng, 8, kappa), COUNT) == 0


@pytest.mark.parametrize("kind", range(8))
def test_no_box_of_any_kind_of_world_is_judged_wrongly(kind, rng):
    field, uncertainty = varied_world(rng, kind)
    assert wrong_boxes(rng, field, 1000, uncertainty) == 0


def test_worlds_vary_in_everything_the_proof_allows(rng):
    worlds = [varied_world(rng, kind) for kind in range(8)]
    assert {len(field.obstacles) for field, _ in worlds} == {12, 20}
    assert {field.workspace.power for field, _ in worlds} == {2, 4}
    assert sum((field.obstacles.powers != 1.0).any() for field, _ in worlds) == 2
    assert sum(uncertainty is not None for _, uncertainty in worlds) == 2


def test_a_realisation_keeps_within_the_uncertainty(rng):
    field = disjoint_world(rng, 12, 5.0)
    uncertainty = Uncertainty(centres=1e-2, semi_axes=np.full(12, 1e-3))
    moved = realisation(rng, field, uncertainty)
    change = np.abs(moved.obstacles.theta - field.obstacles.theta)
    assert (change[:, :2] <= 1e-2).all()
    assert (change[:, 2:4] <= 1e-3).all()
    assert (change[:, :4] > 0.0).all()
    assert (change[:, 4] == 0.0).all()


def test_more_uncertainty_than_is_told_of_is_found_out(rng):
    field = disjoint_world(rng, 12, 5.0)
    moved = realisation(rng, field, Uncertainty(centres=0.05))
    evidence = Evidence.of(moved)
    boxes = random_boxes(rng, moved, evidence.roots, COUNT)
    levels = np.full(COUNT, np.inf)
    verdicts, _ = judge(field, boxes, levels, Uncertainty(centres=0.001))
    q = points_of(rng, boxes)
    assert evidence.against_verdicts(boxes, verdicts, levels, q).any()


def test_a_world_without_obstacles_has_boxes_too(rng):
    assert wrong_boxes(rng, disjoint_world(rng, 0, 2.0), 500) == 0


def test_boxes_are_of_all_sizes_and_many_hold_a_critical_point(case):
    evidence, boxes, *_ = case
    sides = boxes[:, 1::2] - boxes[:, ::2]
    assert (sides > 0.0).all()
    assert sides.min() < 1e-5
    assert sides.max() > 1.0
    share = evidence.roots_in(boxes).any(axis=1).mean()
    # Six in ten lie about one, of which four in nine hold it.
    assert share > 0.2


def test_all_verdicts_come_up_and_none_is_contradicted(case):
    evidence, boxes, q, levels, verdicts, kinds = case
    said = {
        box_test.OUTSIDE,
        box_test.RADIAL,
        box_test.ONE_WAY,
        box_test.SADDLE,
        box_test.OPEN,
    }
    assert said <= set(verdicts.tolist())
    assert {isolation.MINIMUM, isolation.SADDLE_POINT} <= set(kinds.tolist())
    assert not evidence.against_verdicts(boxes, verdicts, levels, q).any()
    assert not evidence.against_enclosures(boxes, kinds, q).any()


@pytest.mark.parametrize(
    "lie",
    [
        box_test.OUTSIDE,
        box_test.RADIAL,
        box_test.ONE_WAY,
        box_test.NO_ROOT,
        box_test.SADDLE,
    ],
)
def test_a_lie_about_a_box_with_the_trap_is_found_out(case, lie):
    evidence, boxes, q, levels, verdicts, _ = case
    trap = evidence.roots_in(boxes)[:, evidence.minima].any(axis=1)
    assert trap.sum() > 100
    told = np.where(trap, lie, verdicts)
    wrong = evidence.against_verdicts(boxes, told, levels, q)
    np.testing.assert_array_equal(wrong, trap)


def test_the_field_itself_gives_away_a_direction_that_turns(case):
    evidence, boxes, q, levels, _, _ = case
    blind = Evidence(evidence.field, np.empty((0, 2)), np.empty(0, dtype=bool))
    holding = evidence.roots_in(boxes).any(axis=1)
    told = np.full(COUNT, box_test.ONE_WAY)
    wrong = blind.against_verdicts(boxes, told, levels, q)
    # About a root F turns all the way round; in boxes too small for floats to see
    # it, or with obstacles in them, the points do not show it.
    assert wrong[holding].mean() > 0.6
    told = np.full(COUNT, box_test.RADIAL)
    assert blind.against_verdicts(boxes, told, levels, q)[holding].mean() > 0.2


def test_free_points_give_away_a_box_said_to_be_outside(case):
    evidence, boxes, q, levels, verdicts, _ = case
    told = np.full(COUNT, box_test.OUTSIDE)
    wrong = evidence.against_verdicts(boxes, told, levels, q)
    clearly_free = (min_beta(q, evidence.field) > 1e-3).any(axis=1)
    assert wrong[clearly_free].all()
    assert not wrong[verdicts == box_test.OUTSIDE].any()


def test_points_under_the_level_give_away_a_box_said_to_be_above(case):
    evidence, boxes, q, _, _, _ = case
    told = np.full(COUNT, box_test.ABOVE)
    high, low = np.full(COUNT, 1e6), np.full(COUNT, -1e6)
    free = (min_beta(q, evidence.field) > 1e-3).any(axis=1)
    assert evidence.against_verdicts(boxes, told, high, q)[free].all()
    goal = evidence.field.goal
    apart = ((boxes[:, ::2] > goal) | (boxes[:, 1::2] < goal)).any(axis=1)
    assert not evidence.against_verdicts(boxes, told, low, q)[apart].any()


def test_only_the_radial_test_may_settle_the_goal(case):
    evidence, boxes, q, levels, _, _ = case
    x, y = evidence.field.goal
    at_goal = (boxes[:, 0] < x - 1e-8) & (x + 1e-8 < boxes[:, 1])
    at_goal &= (boxes[:, 2] < y - 1e-8) & (y + 1e-8 < boxes[:, 3])
    assert at_goal.sum() > 100
    told = np.full(COUNT, box_test.SADDLE)
    assert evidence.against_verdicts(boxes, told, levels, q)[at_goal].all()


def test_an_enclosure_of_another_kind_or_of_nothing_is_found_out(case):
    evidence, boxes, q, _, _, kinds = case
    swapped = np.where(
        kinds == isolation.MINIMUM, isolation.SADDLE_POINT, isolation.MINIMUM
    )
    swapped = np.where(kinds == isolation.NONE, isolation.NONE, swapped)
    claimed = kinds != isolation.NONE
    # Roots nearer to an edge than they are known to be cannot contradict.
    seen = claimed & evidence.roots_in(boxes).any(axis=1)
    assert evidence.against_enclosures(boxes, swapped, q)[seen].all()
    empty = (min_beta(q, evidence.field) > 0.1).all(axis=1)
    empty &= ~evidence.roots_in(boxes).any(axis=1) & ~claimed
    narrow = empty & (np.ptp(boxes[:, :2], axis=1) < 1e-3)
    told = np.where(narrow, isolation.MINIMUM, isolation.NONE)
    wrong = evidence.against_enclosures(boxes, told, q)
    # A root just beside an edge is taken for one in the box.
    assert wrong[narrow].mean() > 0.95


def test_points_of_a_box_are_its_corners_and_points_within(rng):
    box = np.array([[1.0, 2.0, -1.0, 3.0]])
    (q,) = points_of(rng, box)
    assert {tuple(c) for c in q[:4].tolist()} == {(1, -1), (1, 3), (2, -1), (2, 3)}
    assert (q >= [1.0, -1.0]).all()
    assert (q <= [2.0, 3.0]).all()
