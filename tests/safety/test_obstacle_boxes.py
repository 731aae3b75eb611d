"""Boxes of what the arm keeps off: a person, laid out from the back's, and things."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bath_drake.patient.people import load_person
from bath_drake.patient.skin import TrueSkin
from bath_drake.safety.obstacles import Boxes, person_boxes, upright_box

PEOPLE = "f_avg f_heavy f_old f_thin m_avg m_heavy m_tall m_thin".split()


def depth(points, boxes):
    """How deep points (n, 3) are in the deepest box that holds them, m, (n,)."""
    every = [
        (half - np.abs((points - centre) @ axes)).min(axis=1)
        for axes, centre, half in zip(
            boxes.axes, boxes.centres, boxes.halves, strict=True
        )
    ]
    return np.max(every, axis=0)


@pytest.mark.parametrize("name", PEOPLE)
def test_all_of_every_shipped_person_at_rest_is_in_the_boxes(name):
    person = load_person(name)
    back = TrueSkin(person).canonical_map
    boxes = person_boxes(back.R_WP, back.p_WP, back.half_extents)
    assert depth(person.vertices, boxes).min() > 0.0


@pytest.mark.parametrize("name", ["m_heavy", "f_thin"])
def test_behind_the_back_they_leave_room_for_the_wrist(name):
    """The nozzle is 0.15 m long and 0.06 m off the skin."""
    person = load_person(name)
    back = TrueSkin(person).canonical_map
    boxes = person_boxes(back.R_WP, back.p_WP, back.half_extents)
    behind = back.p_WP + 0.1 * back.normal_W
    assert depth(behind[None], boxes).max() < -0.04


def test_seen_from_another_frame_they_hold_the_same_points():
    rng = np.random.default_rng(4)
    boxes = person_boxes(np.eye(3), np.array([0.1, 0.2, 0.3]), np.array([0.15, 0.25]))
    X = np.eye(4)
    X[:3, :3] = Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix()
    X[:3, 3] = [0.5, -0.2, 0.9]
    points = rng.uniform(-1.0, 1.0, (200, 3))
    there = (points - X[:3, 3]) @ X[:3, :3]
    # Rounding of two rotations of numbers near 1.
    np.testing.assert_allclose(
        depth(there, boxes.seen_from(X)), depth(points, boxes), atol=1e-12
    )


def test_a_sum_holds_both():
    both = upright_box([0, 0, 0], [1, 1, 1]) + upright_box([2, 0, 0], [3, 1, 1], (1, 8))
    inside = depth(np.array([[0.5, 0.5, 0.5], [2.5, 0.5, 0.5], [1.5, 0.5, 0.5]]), both)
    np.testing.assert_allclose(inside, [0.5, 0.5, -0.5])
    np.testing.assert_array_equal(both.minded, [[0, 7], [1, 8]])


@pytest.mark.parametrize("name", ["axes", "centres", "halves", "minded"])
def test_shapes_are_checked(name):
    good = vars(upright_box([0, 0, 0], [1, 1, 1]))
    with pytest.raises(ValueError, match="must be finite"):
        Boxes(**{**good, name: np.zeros((2, 2))})


def test_what_is_not_finite_is_no_box():
    with pytest.raises(ValueError, match="centres must be finite"):
        upright_box([0.0, 0.0, np.nan], [1.0, 1.0, 1.0])
