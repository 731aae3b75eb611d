"""Every arm's chain is its model's, and its capsules hold its links."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.errors import ScenarioError
from bath_drake.safety.arm_chain import NOZZLE, ArmChain
from bath_drake.safety.limits import GuardLimits
from bath_drake.safety.self_distance import capsule_ends, self_distance
from bath_drake.scene.arm import ArmGeometry, home_position, make_control_plant
from bath_drake.scene.arm_chain import arm_chain, fitted_capsule
from bath_drake.scene.arm_file import completed, find_arm, shipped_arms
from bath_drake.scene.config import ArmConfig

MARGIN = GuardLimits().joints.margin


def shipped(name):
    return ArmConfig(**completed({"model": name}))


@pytest.mark.parametrize("name", shipped_arms())
def test_the_links_are_where_the_plant_has_them(name, rng):
    config = shipped(name)
    plant, chain = make_control_plant(config), arm_chain(config)
    context = plant.CreateDefaultContext()
    X_BW = plant.GetFrameByName("base").CalcPoseInWorld(context).inverse()
    for q in rng.uniform(chain.low, chain.high, (10, 7)):
        plant.SetPositions(context, q)
        tip = X_BW @ plant.GetFrameByName("nozzle_tip").CalcPoseInWorld(context)
        # A ball of no size at the tip is where the tip is.
        here = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 1e-3, 0.0]])
        ends = capsule_ends(q, chain.with_tool(here))[-1]
        np.testing.assert_allclose(ends[0], tip.translation(), atol=1e-9)
        z = tip.rotation().matrix()[:, 2]
        np.testing.assert_allclose((ends[1] - ends[0]) / 1e-3, z, atol=1e-6)


@pytest.mark.parametrize("name", shipped_arms())
def test_home_and_posture_are_within_the_limits_and_far_from_touching(name):
    config = shipped(name)
    chain = arm_chain(config)
    for q in (home_position(config), np.array(config.posture)):
        assert (q >= chain.low + MARGIN).all()
        assert (q <= chain.high - MARGIN).all()
        assert self_distance(q, chain) > 2.0 * GuardLimits().joints.self_distance


def test_fitted_capsules_hold_what_the_camera_sees_of_the_arm():
    # The shapes of this one are the same for the camera and for contact.
    config = shipped("iiwa14_nozzle")
    config.base_position, config.base_yaw = [0.0, 0.0, 0.0], 0.0
    chain, q = arm_chain(config), home_position(config)
    ends, radii = capsule_ends(q, chain), chain.capsules[:, 7]
    outside = []
    for hull in ArmGeometry(config).hulls_in_world(q):
        a, b = ends[:, 0], ends[:, 1]
        share = np.einsum("nci,ci->nc", hull[:, None] - a, b - a)
        share = np.clip(share / ((b - a) ** 2).sum(axis=1), 0.0, 1.0)
        gap = np.linalg.norm(hull[:, None] - a - share[..., None] * (b - a), axis=2)
        outside.append((gap - radii).min(axis=1).max())
    # All but the nozzle's four parts, of which two are not for contact. A ball's hull
    # for the camera stands out of the one for contact by rounding alone.
    assert np.sort(outside)[:-4].max() < 1e-6


points = st.lists(st.tuples(*[st.floats(-1.0, 1.0)] * 3), min_size=4, max_size=30).map(
    np.array
)


@given(points)
def test_a_fitted_capsule_holds_its_points(cloud):
    row = fitted_capsule(cloud)
    a, b, radius = row[:3], row[3:6], row[6]
    share = np.clip((cloud - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    gap = np.linalg.norm(cloud - a - share[:, None] * (b - a), axis=1)
    # Rounding of lengths up to one.
    assert (gap <= radius + 1e-9).all()


def test_the_nozzle_counts_as_a_link_of_its_own():
    chain = arm_chain(ArmConfig())
    links = chain.capsules[:, 0]
    pairs = {(links[i], links[j]) for i, j in chain.pairs}
    assert (4.0, NOZZLE) in pairs
    assert (5.0, NOZZLE) not in pairs
    assert (0.0, 3.0) in pairs
    assert (0.0, 2.0) not in pairs


def test_a_chain_of_another_shape_is_refused():
    chain = arm_chain(ArmConfig())
    with pytest.raises(ValueError, match="origins must be finite"):
        ArmChain(**{**vars(chain), "origins": chain.origins[:6]})
    with pytest.raises(ValueError, match="links 0 to 8 in turn"):
        ArmChain(**{**vars(chain), "capsules": chain.capsules[::-1]})


@pytest.mark.parametrize("model", ["", "panda", "/no/such/arm.urdf", "a\0.urdf"])
def test_an_unknown_arm_is_refused_with_those_that_ship(model):
    with pytest.raises(ValueError, match="allowed fr3_nozzle, iiwa14_nozzle"):
        find_arm(model)


def own_arm(folder, change=lambda text: text):
    path = folder / "mine.urdf"
    source = find_arm("iiwa14_nozzle")
    path.write_text(change(source.read_text("utf-8")), "utf-8")
    return str(path)


def test_an_arm_of_ones_own_needs_a_home(tmp_path):
    model = own_arm(tmp_path)
    with pytest.raises(ValueError, match=r"home: found none, .* has no mine\.yaml"):
        completed({"model": model})
    given = {"home": [0.1] * 7, "posture": [0.2] * 7}
    assert completed({"model": model, **given})["home"] == given["home"]
    (tmp_path / "mine.yaml").write_text("home: [1, 1, 1, 1, 1, 1, 1]\n", "utf-8")
    found = completed({"model": model, "posture": [0.2] * 7})
    assert found["home"] == [1.0] * 7


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("home: [1, 2]\n", "home: found"),
        ("legs: 2\n", "legs: unknown key"),
        ("capsules: [[0, 1, 2]]\n", r"capsules\[0\]: found"),
    ],
)
def test_a_damaged_arm_file_is_refused_by_key(tmp_path, text, message):
    model = own_arm(tmp_path)
    (tmp_path / "mine.yaml").write_text(text, "utf-8")
    with pytest.raises(ScenarioError, match=rf"mine\.yaml: {message}"):
        completed({"model": model})


FOURTH, LAST = 'iiwa_joint4" type="', 'iiwa_joint7" type="'


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("</robot>", "", "found no one arm in it"),
        ('"base"', '"foot"', "found no link 'base'"),
        ("nozzle_tip", "spout", "found no link 'nozzle_tip'"),
        (FOURTH + "revolute", FOURTH + "prismatic", "7 moving joints, 6 of them rev"),
        (LAST + "revolute", LAST + "fixed", "found"),
    ],
)
def test_what_is_no_arm_of_seven_turning_joints_is_refused(tmp_path, old, new, message):
    model = own_arm(tmp_path, lambda text: text.replace(old, new))
    with pytest.raises(ScenarioError, match=message):
        arm_chain(ArmConfig(model=model))
