from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.resources import models_folder
from bath_drake.safety.arm_chain import NOZZLE
from bath_drake.safety.limits import GuardLimits
from bath_drake.safety.self_distance import (
    capsule_ends,
    self_distance,
    self_distance_ahead,
)
from bath_drake.scene.arm import base_pose, make_control_plant
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.scene.config import ArmConfig

ARM = ArmConfig()
CHAIN = arm_chain(ARM)
CAPSULES = CHAIN.capsules
LIMIT = GuardLimits().joints.self_distance
PLANT = make_control_plant(ARM)
LOW, HIGH = PLANT.GetPositionLowerLimits(), PLANT.GetPositionUpperLimits()
positions = st.tuples(*[st.floats(a, b) for a, b in zip(LOW, HIGH, strict=True)]).map(
    np.array
)


# Of the nozzle's link along link 7's z, m.
FLANGE = 0.107


def outside(points, capsule):
    """How far the points (n, 3) are outside a capsule, m; negative inside."""
    a, b, radius = capsule[1:4], capsule[4:7], capsule[7]
    share = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(points - a - share[:, None] * (b - a), axis=1) - radius


@pytest.mark.parametrize("link", range(8))
def test_the_collision_mesh_of_each_link_is_inside_its_capsule(link):
    path = models_folder() / "arm" / "meshes" / f"link{link}_col.obj"
    lines = path.read_text(encoding="utf-8").splitlines()
    vertices = [row.split()[1:4] for row in lines if row.startswith("v ")]
    (capsule,) = CAPSULES[CAPSULES[:, 0] == link]
    # A capsule is convex: with the vertices it holds all of their hull.
    assert outside(np.array(vertices, dtype=float), capsule).max() <= 0.0


def test_the_nozzle_is_inside_its_capsules():
    turns = np.linspace(0.0, 2.0 * np.pi, 32)
    around = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    handle, head = CAPSULES[CAPSULES[:, 0] == NOZZLE]
    for radius, ends in ((0.032, (0.0, 0.012)), (0.014, (0.012, 0.156))):
        for z in ends:
            rim = np.column_stack([radius * around, np.full(32, FLANGE + z)])
            assert outside(rim, handle).max() <= 0.0
    for radius, ends in ((0.012, (0.0, 0.122)), (0.022, (0.122, 0.14))):
        for x in ends:
            rim = np.column_stack(
                [np.full(32, x), radius * around + [0.0, FLANGE + 0.15]]
            )
            assert outside(rim, head).max() <= 0.0


@given(positions)
def test_the_capsules_are_where_the_plant_has_the_links(q):
    context = PLANT.CreateDefaultContext()
    PLANT.SetPositions(context, q)
    X_BW = base_pose(ARM).inverse()
    for capsule, ends in zip(CAPSULES, capsule_ends(q, CHAIN), strict=True):
        link = int(capsule[0])
        name = f"fr3_link{7 if link == NOZZLE else link}"
        X_BL = X_BW @ PLANT.GetFrameByName(name).CalcPoseInWorld(context)
        expected = X_BL.multiply(capsule[1:7].reshape(2, 3).T).T
        # The URDF's quarter turns have 16 digits.
        np.testing.assert_allclose(ends, expected, atol=1e-9)


@pytest.mark.parametrize("q", [ARM.home, ARM.posture])
def test_home_and_posture_are_far_from_the_limit(q):
    assert self_distance(np.array(q), CHAIN) > 3.0 * LIMIT


def test_an_arm_that_folds_onto_its_base_is_too_near():
    assert self_distance(np.array([0.0, 1.7, 0.0, -2.9, 0.0, 1.0, 0.0]), CHAIN) < LIMIT


@given(positions, st.lists(st.floats(-2.6, 2.6), min_size=7, max_size=7))
def test_ahead_is_no_farther_than_the_start_and_the_end(q, v):
    v, lookahead = np.array(v), 0.15
    ahead = self_distance_ahead(q, v, CHAIN, lookahead)
    # The compiler may add the products in another order.
    assert ahead <= self_distance(q, CHAIN) + 1e-12
    assert ahead <= self_distance(q + lookahead * v, CHAIN) + 1e-12


@pytest.mark.parametrize("bad", [nan, inf, -inf])
@pytest.mark.parametrize("k", range(7))
def test_what_is_no_number_gives_none(bad, k):
    q, wrong = np.array(ARM.home), np.zeros(7)
    wrong[k] = bad
    assert np.isnan(self_distance(q + wrong, CHAIN))
    assert np.isnan(self_distance_ahead(q, wrong, CHAIN))


def test_wrong_shapes_and_lookaheads_are_refused():
    q = np.array(ARM.home)
    with pytest.raises(ValueError, match="q must have shape"):
        self_distance(q[:6], CHAIN)
    with pytest.raises(ValueError, match="v must have shape"):
        self_distance_ahead(q, q[:6], CHAIN)
    with pytest.raises(ValueError, match="lookahead"):
        self_distance_ahead(q, q, CHAIN, nan)
