"""The arm in the image: where it is believed to be, something behind it, or before."""

import copy

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bath_drake.perception.arm_sight import (
    LEAST_PIXELS,
    LEAST_RIM,
    RIM,
    ArmSight,
    arm_core,
    rim_width,
    seen_through,
)
from bath_drake.perception.camera import PinholeCamera

CAMERA = PinholeCamera(width=160, height=100, fx=180.0, fy=180.0, cx=80.0, cy=50.0)
# A camera somewhere, and before it a forearm 0.4 m long, 1.2 m away, a wall 2 m away.
TURN, EYE = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix(), np.array([1, -2, 0.5])
PIXELS = 5.0
RADIUS, AWAY, WALL = 0.07, 1.2, 2.0
ENDS_C = np.array([[-0.2, 0.05, AWAY], [0.2, -0.05, AWAY + 0.1]])
CAPSULE_W = np.concatenate([(ENDS_C @ TURN.T + EYE).ravel(), [RADIUS]])[None]


def image(shift=0, radius=RADIUS, first=WALL):
    """Depth of an arm before a wall by marching along rays, and its silhouette."""
    steps = np.arange(1.0, 1.5, 0.005)
    points = CAMERA.rays[:, :, None] * steps[:, None]
    axis = ENDS_C[1] - ENDS_C[0]
    along = np.clip((points - ENDS_C[0]) @ axis / (axis @ axis), 0.0, 1.0)
    away = np.linalg.norm(points - ENDS_C[0] - along[..., None] * axis, axis=-1)
    inside = away <= radius
    hit = inside.any(axis=-1)
    depth = np.where(hit, steps[inside.argmax(axis=-1)], first)
    return np.roll(depth, shift, axis=0), hit


def looked(depth, mask):
    return seen_through(
        depth, CAMERA.rays, arm_core(mask, PIXELS), TURN, EYE, CAPSULE_W
    )


def test_an_arm_where_it_is_believed_to_be_hides_what_is_behind_it():
    depth, mask = image()
    assert looked(depth, mask) == 0.0
    # A link is thinner than its capsule, and its silhouette thinner with it.
    assert looked(*image(radius=0.6 * RADIUS)) == 0.0


@pytest.mark.parametrize("shift", [-8, 8, 15])
def test_a_camera_that_was_knocked_sees_through_it(shift):
    _, mask = image()
    depth, _ = image(shift)
    core = arm_core(mask, PIXELS)
    expected = (depth[core] == WALL).mean()
    assert expected > 0.05
    # A slanted arm that is shifted is in places a little before where it should be.
    assert looked(depth, mask) == pytest.approx(expected, rel=0.1)


def test_what_is_before_the_arm_or_has_no_depth_says_nothing():
    depth, mask = image()
    for nothing in (0.0, np.nan, np.inf, 0.6):
        half = depth.copy()
        half[:, :60] = nothing
        assert looked(half, mask) == 0.0
        # And is no excuse for the rest of it: half of that is seen through then.
        rest = np.flatnonzero(
            arm_core(mask, PIXELS).any(axis=0) & (np.arange(160) >= 60)
        )
        half[:, int(np.median(rest)) :] = WALL
        assert looked(half, mask) == pytest.approx(0.5, abs=0.1)


def test_a_wall_right_behind_the_arm_is_not_told_from_it():
    _, mask = image()
    depth = np.full(mask.shape, AWAY + RADIUS)
    assert looked(depth, mask) < 0.5


def test_too_little_of_the_arm_says_nothing():
    _, mask = image()
    mask[:, 52:] = False
    assert 0 < arm_core(mask, PIXELS).sum() < LEAST_PIXELS
    assert looked(np.full(mask.shape, WALL), mask) == 0.0
    assert looked(np.full(mask.shape, WALL), np.zeros_like(mask)) == 0.0


def test_an_arm_behind_the_camera_is_not_looked_for():
    depth, mask = image()
    back = CAPSULE_W.copy()
    back[0, :6] = 2.0 * np.tile(EYE, 2) - back[0, :6]
    core = arm_core(mask, PIXELS)
    assert seen_through(depth, CAMERA.rays, core, TURN, EYE, back) == 0.0


def test_the_core_leaves_the_rim_of_the_silhouette_out():
    mask = np.zeros((60, 80), dtype=bool)
    mask[20:40, 10:70] = True
    core = arm_core(mask, PIXELS)
    assert not (core & ~mask).any()
    inner = int(PIXELS) + 1
    assert core[20 + inner : 40 - inner, 10 + inner : 70 - inner].all()
    # So many pixels are the rim's, and the next is further off than that.
    assert not core[20 : 20 + int(PIXELS)].any()
    # The image's own edge cuts the arm, which goes on beyond it.
    mask[:, :] = True
    assert arm_core(mask, PIXELS).all()


def test_frames_in_a_row_must_agree_and_what_they_say_stands_for_a_second():
    sight = ArmSight()
    assert sight.share == 0.0
    shares = [0.0, 0.3, 0.2, 0.0, 0.4, 0.5, 0.3, 0.0, 0.0]
    told = []
    for k, share in enumerate(shares):
        sight = sight.next(k / 30.0, share)
        told.append(sight.share)
    assert told == [0.0] * 6 + [0.3] * 3
    # The last of the three is a second old.
    assert sight.next(6 / 30.0 + 0.99, 0.0).share == 0.0
    steady = sight
    for k in range(9, 60):
        steady = steady.next(k / 30.0, 0.0)
    assert steady.share == 0.0
    assert copy.deepcopy(sight) is sight


def test_the_rim_is_as_wide_as_the_arm_is_near():
    depth, mask = image()
    rim = rim_width(depth, mask, 500.0)
    # The arm's near side: a radius before its axis, and it is slanted by 0.1 m.
    assert rim == pytest.approx(RIM * 500.0 / AWAY, abs=0.3)
    assert rim_width(2.0 * depth, mask, 1000.0) == pytest.approx(rim)
    assert rim_width(0.5 * depth, mask, 500.0) == pytest.approx(2.0 * rim)
    assert rim_width(9.0 * depth, mask, 500.0) == LEAST_RIM
    assert rim_width(np.full(mask.shape, np.nan), mask, 500.0) == 0.0
