"""What ideal perception says against the true mesh."""

import numpy as np
import pytest

from bath_drake.patient.motion import MotionConfig, trunk_bend
from bath_drake.patient.people import load_person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.true_back import TrueBack
from bath_drake.patient.wound import wound_patch
from bath_drake.perception.ellipses import level
from bath_drake.scene.config import CameraConfig

BENDING = MotionConfig(
    flexion_amplitude=0.14,
    side_bend_amplitude=0.09,
    spine_twist_amplitude=0.2,
    chest_amplitude=0.006,
)
MARGIN = 0.02
SQUARE = [[0.3, 0.3], [0.5, 0.3], [0.5, 0.5], [0.3, 0.5]]
R_WM = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
p_WM = np.array([0.75, 0.1, 0.05])


@pytest.fixture(scope="module")
def person():
    return load_person("m_avg")


def back_of(person, bends=True, wound=None):
    camera = CameraConfig()
    return TrueBack(
        person,
        bends=bends,
        wound=wound,
        given=[SQUARE],
        margin=MARGIN,
        camera=camera.pinhole(),
        R_WC=camera.rotation(),
        p_WC=np.array(camera.eye),
    )


@pytest.mark.parametrize("bends", [False, True])
def test_every_point_is_on_the_skin_as_it_is_then(person, bends):
    bend = trunk_bend(7.0, BENDING)
    observation = back_of(person, bends).observe(R_WM, p_WM, bend, 7.0)
    bent = bending_skin(person).points(bend) if bends else None
    skin = TrueSkin(person, bent)
    distance, _, _ = skin.nearest((observation.points_W - p_WM) @ R_WM)
    # Open3D keeps single precision.
    assert distance.max() < 1e-5
    assert observation.found
    assert observation.stamp == 7.0
    assert len(observation.points_W) > 3000


def test_the_map_of_a_rigid_back_is_the_true_one(person):
    observation = back_of(person, False).observe(R_WM, p_WM, trunk_bend(0, BENDING), 0)
    seen, true = observation.tracked_map, TrueSkin(person).canonical_map
    np.testing.assert_allclose(seen.R_WP, R_WM @ true.R_WP, atol=1e-12)
    np.testing.assert_allclose(seen.p_WP, R_WM @ true.p_WP + p_WM, atol=1e-12)
    np.testing.assert_array_equal(seen.half_extents, true.half_extents)


def test_the_map_of_a_bent_back_keeps_skin_where_it_is_in_canonical_space(person):
    back = back_of(person)
    rest = TrueSkin(person).canonical_map
    for t in (5.0, 12.0, 30.0):
        bend = trunk_bend(t, BENDING)
        observation = back.observe(R_WM, p_WM, bend, t)
        still = back.observe(R_WM, p_WM, trunk_bend(0.0, BENDING), 0.0)
        before = rest.canonical_from_world((still.points_W - p_WM) @ R_WM)
        now = observation.tracked_map.canonical_from_world(observation.points_W)
        inside = np.abs(before).max(axis=1) < 0.8
        error = np.linalg.norm(now - before, axis=1)[inside]
        # A bent back is no rigid body: what is left is its own bend.
        assert np.sqrt(np.mean(error**2)) < 0.03


def test_the_box_is_within_the_rim_and_the_mask_shows_every_pixel(person):
    back = back_of(person)
    observation = back.observe(R_WM, p_WM, trunk_bend(3.0, BENDING), 3.0)
    assert back.rim is not None
    u, v = observation.pixels.T
    assert observation.mask[v, u].all()
    assert not observation.robot_mask.any()


def test_the_areas_cover_the_wound_and_what_was_given_with_the_margin(person):
    wound = wound_patch(person, np.array([-0.2, 0.0]), np.array([0.12, 0.08]), 0.3)
    back = back_of(person, wound=wound)
    true = TrueSkin(person).canonical_map
    turns = np.linspace(0.0, 2.0 * np.pi, 32)
    circle = 0.999 * MARGIN * np.column_stack([np.cos(turns), np.sin(turns)])
    outline = true.plane_from_world(wound.outline)[:, :2]
    given = np.array(SQUARE) * true.half_extents
    assert len(back.areas) == 2
    for points in (outline, given):
        around = (points[:, None] + circle).reshape(-1, 2) / true.half_extents
        covered = [level(area, around).max() <= 1.0 + 1e-6 for area in back.areas.theta]
        assert sum(covered) == 1
