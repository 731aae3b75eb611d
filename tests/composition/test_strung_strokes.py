"""Strokes carried to other ends and strung together."""

import itertools

import numpy as np
import pytest

from bath_drake.composition.certify import certify_chain
from bath_drake.composition.chain import Chain
from bath_drake.composition.rollout import chain_rollout
from bath_drake.composition.strokes import GATE_RADIUS, carried, lanes, strung
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.rollout import RolloutStatus

DISC = Workspace(np.zeros(2), np.array([2.0, 2.0]))
# A stroke that bends round an obstacle.
START, GOAL = np.array([-0.7, 0.05]), np.array([0.7, 0.0])
BENT = Chain(
    (
        NavigationField(
            DISC, GOAL, 8.0, ObstacleSet(np.array([[0.0, 0.02, 0.2, 0.1, 0.3]]))
        ),
    )
)
ENDS = [
    ([-0.5, -0.4], [0.5, -0.4]),
    ([0.5, -0.1], [-0.5, -0.1]),
    ([-0.5, 0.3], [0.1, 0.6]),
]


def test_lanes_go_to_and_fro_up_the_whole_box_no_further_apart_than_asked():
    found = np.array(lanes([-0.6, -0.5], [0.6, 0.5], 0.17))
    assert found.shape == (7, 2, 2)
    assert (np.abs(found[:, :, 0]) == 0.6).all()
    np.testing.assert_array_equal(found[:, 0, 1], found[:, 1, 1])
    np.testing.assert_allclose(np.diff(found[:, 0, 1]), 1.0 / 6.0, rtol=1e-12)
    assert found[0, 0, 1] == -0.5
    assert found[-1, 0, 1] == 0.5
    assert found[0, 0, 0] == 0.6
    # Each begins on the side where the last one ended.
    np.testing.assert_array_equal(found[1:, 0, 0], found[:-1, 1, 0])
    # A spacing that fits is not made smaller by rounding.
    assert len(lanes([-0.6, -0.3], [0.6, 0.3], 0.2)) == 4
    assert len(lanes([-0.6, 0.1], [0.6, 0.1], 0.2)) == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0.6, 0.0], [-0.6, 0.5], 0.2), "high must be above low"),
        (([0.0, 0.1], [0.6, 0.0], 0.2), "high must be above low"),
        (([0.0, 0.0], [0.6, 0.5], 0.0), "spacing must be positive"),
    ],
)
def test_lanes_of_no_box_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        lanes(*arguments)


@pytest.mark.parametrize(("start", "goal"), ENDS)
def test_a_carried_stroke_has_its_shape_and_its_proof_at_other_ends(start, goal):
    moved = carried(BENT, START, start, goal)
    np.testing.assert_array_equal(moved.goal, goal)
    scale = np.linalg.norm(np.subtract(goal, start)) / np.linalg.norm(GOAL - START)
    learned = chain_rollout(START, BENT, step=1e-3)
    found = chain_rollout(start, moved, step=1e-3 * scale, goal_tolerance=1e-3 * scale)
    assert found.status is RolloutStatus.ARRIVED
    # Seen as complex numbers, both are the same curve from 0 to 1.
    shapes = []
    for path, a, b in ((learned.path, START, GOAL), (found.path, start, goal)):
        flat = np.asarray(path) @ [1.0, 1.0j]
        a, b = np.dot(a, [1.0, 1.0j]), np.dot(b, [1.0, 1.0j])
        shapes.append((flat - a) / (b - a))
    count = min(len(shape) for shape in shapes)
    # Rounding grows along the roll-out's guarded steps.
    assert np.abs(shapes[0][:count] - shapes[1][:count]).max() < 1e-6
    assert certify_chain(moved).verdict == certify_chain(BENT).verdict == "proved"


def test_strung_strokes_are_washed_one_after_the_other_and_proved():
    parts = [(np.array(a), carried(BENT, START, a, b)) for a, b in ENDS]
    chain = strung(parts)
    # Two fields lead over.
    assert len(chain) == 5
    found = chain_rollout(parts[0][0], chain)
    assert found.status is RolloutStatus.ARRIVED
    np.testing.assert_allclose(found.path[-1], ENDS[-1][1], atol=2e-3)
    for a, b in ENDS:
        for end in (a, b):
            away = np.hypot(*(found.path - end).T).min()
            assert away <= GATE_RADIUS
    certificate = certify_chain(chain, start=parts[0][0])
    assert certificate.verdict == "proved"


def test_a_stroke_that_begins_where_the_last_one_ended_follows_at_once():
    corners = [[-0.5, -0.4], [0.5, -0.4], [0.5, 0.2]]
    parts = [
        (np.array(a), carried(BENT, START, a, b))
        for a, b in itertools.pairwise(corners)
    ]
    assert len(strung(parts)) == 2
    assert strung(parts[:1]) == parts[0][1]


def test_what_cannot_be_carried_or_strung_is_refused():
    with pytest.raises(ValueError, match="at least one stroke"):
        strung([])
    with pytest.raises(ValueError, match=r"^the stroke must be"):
        carried(BENT, START, [0.1, 0.1], [0.1, 0.1])
    with pytest.raises(ValueError, match="the learned stroke must be"):
        carried(BENT, GOAL, [0.1, 0.1], [0.3, 0.1])
    with pytest.raises(ValueError, match="two finite numbers"):
        carried(BENT, START, [np.nan, 0.1], [0.3, 0.1])
    oval = NavigationField(
        Workspace(np.zeros(2), np.array([1.0, 0.8])), GOAL, 8.0, ObstacleSet()
    )
    with pytest.raises(ValueError, match="round workspace"):
        carried(Chain((oval,)), START, [0.0, 0.0], [0.0, 0.5])
