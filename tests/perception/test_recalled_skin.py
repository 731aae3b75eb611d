"""Skin behind the robot is where it was last seen, moved and bent with the body."""

import copy
import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bath_drake.perception import morphology
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.completion import pixel_indices
from bath_drake.perception.recalled_skin import RecalledSkin, recall
from bath_drake.perception.registration import BodyPose
from bath_drake.perception.surface import fit_surface
from bath_drake.perception.tracked_map import MapTracker

HIDDEN = np.array([0.03, -0.05])


def height(x, y):
    return -1.2 * x**2 - 0.3 * y**2


def skin(rng, count=40000):
    x, y = rng.uniform(-1.0, 1.0, (2, count)) * np.array([[0.17], [0.24]])
    return np.column_stack([x, y, height(x, y)])


def around(points, place, radius):
    return np.hypot(*(points[:, :2] - place).T) < radius


CAMERA = PinholeCamera()
# Looks down from 1.2 m over the back, its rows along -y.
LOOK_DOWN, EYE = np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 1.2])


def frame(points_W, robot_W=None):
    """A frame that shows some points, a robot before those of others."""
    hides = np.zeros(CAMERA.shape, dtype=bool)
    if robot_W is not None:
        hides[tuple(pixel_indices(robot_W, CAMERA, LOOK_DOWN, EYE).T)] = True
        hides = morphology.closed(hides, 4.0)
    return dataclasses.replace(
        BodyObservation(),
        points_W=points_W,
        robot_mask=hides,
        R_WC=LOOK_DOWN,
        p_WC=EYE,
        camera=CAMERA,
    )


@pytest.fixture
def points(rng):
    return skin(rng)


@pytest.fixture
def hidden(points):
    return around(points, HIDDEN, 0.04)


@pytest.fixture
def body(rng):
    start = CanonicalMap(np.eye(3), np.zeros(3), np.array([0.17, 0.24]))
    return MapTracker().start(start, skin(rng), 0.0)


def test_nothing_is_recalled_of_skin_that_is_all_seen(body, points, hidden):
    assert len(recall(body, frame(points, points[hidden])).points_W) == 0


def test_what_is_recalled_fills_the_hole_and_lies_on_the_skin(body, points, hidden):
    recalled = recall(body, frame(points[~hidden], points[hidden])).points_W
    assert around(recalled, HIDDEN, 0.04).all()
    # Of 50 cells those at the rim have points.
    assert len(recalled) >= 30
    # Smoothed over a centimetre, of curvature 2.4 / m: 0.12 mm; sampled at random.
    off = recalled[:, 2] - height(*recalled[:, :2].T)
    assert np.abs(off).max() < 1e-3


def test_it_goes_on_to_a_cell_before_the_rim(body, points):
    # The skin ends at 0.17 m: the last whole cell but one is at 0.155 m.
    edge = around(points, np.array([0.16, 0.0]), 0.04)
    recalled = recall(body, frame(points[~edge], points[edge])).points_W
    assert recalled[:, 0].max() == pytest.approx(0.155)
    off = recalled[:, 2] - height(*recalled[:, :2].T)
    # Of a slope of 0.4, the mean of some 25 points anywhere in a cell: 0.23 mm, rms.
    assert np.abs(off).max() < 1.2e-3


def test_what_something_else_hides_is_not_recalled(body, points, hidden):
    elsewhere = around(points, np.array([-0.08, 0.1]), 0.03)
    shown = points[~hidden & ~elsewhere]
    recalled = recall(body, frame(shown, points[elsewhere])).points_W
    assert len(recalled) > 0
    assert not around(recalled, HIDDEN, 0.04).any()
    assert len(recall(body, frame(points[~hidden])).points_W) == 0


def test_without_a_camera_nobody_knows_what_the_robot_hides(body, points, hidden):
    blind = dataclasses.replace(frame(points[~hidden], points[hidden]), camera=None)
    assert len(recall(body, blind).points_W) == 0


def test_it_goes_with_the_body(body, points, hidden):
    turn = Rotation.from_rotvec([0.1, -0.2, 0.05])
    shift = np.array([0.02, 0.01, -0.03])
    moved = body.__class__(
        body.canonical_map,
        BodyPose(turn.as_matrix(), shift, np.array([0.2, 0.1, -0.1])),
        body.skin,
        body.box,
        body.frames,
        body.first,
    )
    still = recall(body, frame(points[~hidden], points[hidden])).points_W
    bent = moved.pose.bent(points)
    there = recall(moved, frame(bent[~hidden], bent[hidden])).points_W
    # A cell at the rim may have its only point beside it, once it is bent.
    expected = moved.pose.bent(still)
    distances = np.linalg.norm(there[:, None] - expected, axis=2).min(axis=1)
    # Both bends are of first order: cells are the same to a fraction of a millimetre.
    assert np.quantile(distances, 0.8) < 1e-3
    assert abs(len(there) - len(still)) <= 8


def test_a_patch_over_a_hole_is_better_with_what_is_recalled(body, points, hidden):
    canonical_map = CanonicalMap(np.eye(3), np.zeros(3), np.array([0.17, 0.24]))
    p_NQ = HIDDEN / canonical_map.half_extents
    recalled = recall(body, frame(points[~hidden], points[hidden]))
    patch = fit_surface(
        points[~hidden], canonical_map, p_NQ, recalled_W=recalled.points_W
    )
    assert patch.valid
    assert patch.p_WS[2] == pytest.approx(height(*HIDDEN), abs=5e-4)
    slopes = np.array([2.4 * HIDDEN[0], 0.6 * HIDDEN[1], 1.0])
    cosine = patch.normal_W @ slopes / np.linalg.norm(slopes)
    assert np.degrees(np.arccos(min(cosine, 1.0))) < 2.0


def test_recalled_skin_is_shared_not_copied():
    one = RecalledSkin()
    assert copy.deepcopy(one) is one
