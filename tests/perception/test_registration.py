"""A back's pose and bend are found from its surface, and another back is told apart."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bath_drake.perception.height_field import CELL, CELLS, HeightField, look_up
from bath_drake.perception.registration import (
    TOLERANCE,
    BodyPose,
    _normal_equations,
    register,
)

SIZE = np.array([0.17, 0.24])


def skin_points(count=20000, seed=0, hump=0.02):
    """A back with a furrow, shoulder blades and a hump, over B's plane, m."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-1.0, 1.0, (2, count)) * SIZE[:, None]
    z = -1.2 * x**2 - 0.3 * y**2 - 0.008 * np.exp(-((x / 0.02) ** 2))
    z += hump * np.exp(-((x - 0.08) ** 2 + (y - 0.1) ** 2) / 0.05**2)
    z += hump * np.exp(-((x + 0.08) ** 2 + (y - 0.1) ** 2) / 0.05**2)
    return np.column_stack([x, y, z])


def known_skin(hump=0.02):
    return HeightField().with_points(skin_points(200000, seed=1, hump=hump))


KNOWN = known_skin()


def bent(p_B, curvature):
    """Points that `BodyPose.unbent` takes back to p_B, by fixed-point iteration."""
    points, pose = p_B.copy(), BodyPose(np.eye(3), np.zeros(3), curvature)
    for _ in range(30):
        points += p_B - pose.unbent(points)
    return points


NUMBER = st.floats(-1.0, 1.0)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER).map(np.array)


@given(turn=VECTOR, shift=VECTOR, curvature=VECTOR)
@settings(max_examples=20, deadline=None)
def test_pose_and_bend_are_found_where_they_were(turn, shift, curvature):
    R_WB = Rotation.from_rotvec(0.1 * turn).as_matrix()
    p_WB, curvature = 0.02 * shift, 0.3 * curvature
    points = bent(skin_points(), curvature) @ R_WB.T + p_WB
    # The outline says where it is, but not how it is turned nor bent.
    outline = BodyPose(R_WB, p_WB)
    start = BodyPose(np.eye(3), np.zeros(3))
    pose, agreement = register(points, np.ones(len(points)), KNOWN, start, outline)
    # Cells of a centimetre, smoothed, cost half a millimetre of curved skin.
    assert np.abs(pose.p_WB - p_WB).max() < 1e-3
    assert Rotation.from_matrix(pose.R_WB.T @ R_WB).magnitude() < 8e-3
    assert np.abs(pose.curvature - curvature).max() < 0.06
    assert agreement > 0.97


def test_noise_of_two_millimetres_averages_out():
    rng = np.random.default_rng(2)
    places = []
    for k in range(20):
        points = skin_points(seed=10 + k)
        points[:, 2] += 0.002 * rng.standard_normal(len(points))
        here = BodyPose(np.eye(3), np.zeros(3))
        pose, _ = register(points, np.ones(len(points)), KNOWN, here, here)
        places.append(pose.p_WB)
    # 2500 points: 0.04 mm along the normal; only slopes of some tenths tell of the
    # place along the skin, and the bend is found with it.
    assert np.std(places, axis=0).max() < 7e-4


def test_half_a_back_is_enough():
    points = skin_points()
    points = points[points[:, 0] > 0.0] + np.array([0.01, 0.0, 0.005])
    here = BodyPose(np.eye(3), np.zeros(3))
    pose, agreement = register(points, np.ones(len(points)), KNOWN, here, here)
    # The outline is 10 mm off, and believed a little where the skin is smooth.
    assert np.abs(pose.p_WB - [0.01, 0.0, 0.005]).max() < 5e-3
    assert agreement > 0.97


@pytest.mark.parametrize("off", [0.03, 0.05, 0.1])
def test_an_outline_that_lost_skin_to_the_robot_drags_nothing_along(off):
    points = skin_points(hump=0.008)
    points = points[(points[:, 0] < 0.06) & (points[:, 1] < 0.12)]
    here = BodyPose(np.eye(3), np.zeros(3))
    outline = BodyPose(np.eye(3), np.array([-off, -off, 0.0]))
    smooth = known_skin(hump=0.008)
    pose, _ = register(points, np.ones(len(points)), smooth, here, outline)
    # A quarter of the nozzle's spot.
    assert np.abs(pose.p_WB).max() < 7e-3
    # A tenth of how far a back bends.
    assert np.abs(pose.curvature).max() < 0.15


def test_a_back_of_another_shape_agrees_less():
    points = skin_points(hump=-0.02)
    here = BodyPose(np.eye(3), np.zeros(3))
    _, agreement = register(points, np.ones(len(points)), KNOWN, here, here)
    assert agreement < 0.8


def test_points_away_from_the_known_skin_tell_nothing():
    here = BodyPose(np.eye(3), np.zeros(3))
    away = skin_points() + np.array([1.0, 0.0, 0.0])
    pose, agreement = register(away, np.ones(len(away)), KNOWN, here, here)
    assert agreement == 0.0
    assert pose is here


def test_the_step_is_the_gradient_of_the_distances():
    """The rows of the normal equations against differences of the residual."""
    curvature = np.array([0.2, -0.3, 0.15])
    R_WB = Rotation.from_rotvec([0.05, -0.1, 0.08]).as_matrix()
    p_WB = np.array([0.01, -0.02, 0.005])
    # A plane: its slopes are exact, and so is the linearisation.
    grid = (np.arange(CELLS) - CELLS // 2 + 0.5) * CELL
    x, y = np.meshgrid(grid, grid, indexing="ij")
    surface = np.stack(
        [0.3 * x - 0.2 * y, np.full_like(x, 0.3), np.full_like(x, -0.2)], axis=-1
    )
    known = np.ones_like(x, dtype=bool)
    normal_W = np.array([-0.3, 0.2, 1.0]) / np.sqrt(1.13)
    point = np.array([[0.05, 0.12, 0.02]])

    def off(step):
        turned = R_WB @ Rotation.from_rotvec(step[:3]).as_matrix()
        pose = BodyPose(turned, p_WB + turned @ step[3:6], curvature + step[6:])
        return (pose.unbent(point) @ normal_W).item()

    _, slope, *_ = _normal_equations(
        point, np.ones(1), R_WB, p_WB, curvature, surface, known, TOLERANCE
    )
    here = off(np.zeros(9))
    weight = 1.0 / (1.0 + (here / TOLERANCE) ** 2) ** 2
    rows = slope / (weight * here)
    steps = 1e-6 * np.eye(9)
    differences = np.array([(off(s) - off(-s)) / 2e-6 for s in steps])
    # The bend is of first order: its own turn by another step is left out, some
    # curvature times distance, 0.3 * 0.15, of the change.
    assert rows == pytest.approx(differences, abs=0.05)
    assert rows[6:] == pytest.approx(differences[6:], abs=1e-8)


@given(x=NUMBER, y=NUMBER)
def test_a_plane_is_looked_up_exactly(x, y):
    points = skin_points(200000)
    points[:, 2] = 0.1 * points[:, 0] - 0.2 * points[:, 1] + 0.03
    out = np.empty(3)
    assert look_up(PLANE.surface, PLANE.known, 0.1 * x, 0.15 * y, out)
    # Points are spread over each cell by chance: their mean height is not its middle's.
    assert out == pytest.approx([0.01 * x - 0.03 * y + 0.03, 0.1, -0.2], abs=0.02)


def _plane():
    points = skin_points(200000)
    points[:, 2] = 0.1 * points[:, 0] - 0.2 * points[:, 1] + 0.03
    return HeightField().with_points(points)


PLANE = _plane()


@pytest.mark.parametrize("place", [(0.3, 0.0), (0.0, -0.3), (5.0, 0.0), (0.16, 0.0)])
def test_beside_the_skin_and_at_its_rim_nothing_is_known(place):
    assert not look_up(PLANE.surface, PLANE.known, *place, np.empty(3))


def test_gathering_in_pieces_is_gathering_at_once():
    points = skin_points()
    once = HeightField().with_points(points)
    twice = HeightField().with_points(points[:7000]).with_points(points[7000:])
    np.testing.assert_array_equal(once.counts, twice.counts)
    # Sums in another order.
    np.testing.assert_allclose(once.surface, twice.surface, atol=1e-12)
