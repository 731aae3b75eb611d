"""Both guards as Systems: their ports against the pure functions."""

import dataclasses
from math import nan

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.safety.canonical_command import guarded_world
from bath_drake.safety.facts import GuardFacts
from bath_drake.safety.guard_ticks import (
    CanonicalTick,
    JointTick,
    canonical_tick,
    joint_tick,
)
from bath_drake.safety.joint_command import Emitted, JointRange
from bath_drake.safety.limits import GuardLimits
from bath_drake.safety.reasons import Mode, Reason
from bath_drake.scene.arm import home_position, make_control_plant
from bath_drake.scene.config import ArmConfig
from bath_drake.systems._guard_facts import OPTIONAL_PORTS
from bath_drake.systems.canonical_guard import CanonicalGuard
from bath_drake.systems.joint_guard import JointGuard

LIMITS = GuardLimits()
PERIOD = 0.01
P_NQ, V_NQ = np.array([-0.5, 0.1]), np.array([0.2, 0.05])
FIELD = NavigationField(
    workspace=Workspace(np.zeros(2), np.full(2, 2.0)),
    goal=np.array([0.6, 0.0]),
    kappa=5.0,
    obstacles=ObstacleSet(np.array([[0.0, 0.1, 0.15, 0.1, 0.3]])),
)
AREAS = ObstacleSet(np.array([[-0.5, 0.1, 0.1, 0.1, 0.0]]))
MAP = CanonicalMap(np.eye(3), np.array([0.7, 0.0, 0.9]), np.array([0.18, 0.24]))
SEEN = dataclasses.replace(BodyObservation(), stamp=0.0, found=True)
HOME = home_position(ArmConfig())
COMMAND = np.concatenate([HOME + 1e-4, np.full(7, 0.02)])
NORMAL = (0.0, -1.0, 0.0)
# What every optional port says where all is well, but for what is only passed on.
WELL = {
    "frame_status": [0.1, 0.0, 0.0],
    "camera_status": [0.004],
    "map_status": [1.0],
    "body_status": [0.01, 1.0],
    "surface_status": [1.0],
    "surface_normal": NORMAL,
    "world_status": [1.0],
    "ik_status": [0.0],
    "self_distance": [0.2],
    "obstacle_distance": [0.15],
    "nozzle_clearance": [0.06],
    "command_stamp": [0.0],
    "wrench": [0.0, 0.1, 0.2, 0.3, 1.0, 2.0, 3.0],
    "loop_seconds": [0.004],
    "robot_stamp": [0.0],
    "following_error": [0.005],
    "reset": [0.0],
    "other_reason": [float(Reason.NONE)],
}
# One port that says what is wrong, and the reason it is.
WRONG = [
    ("frame_status", [0.4, 0.0, 0.0], Reason.FRAME_INVALID),
    ("frame_status", [0.0, 1.0, 0.0], Reason.FRAME_FROZEN),
    ("frame_status", [nan, 0.0, 0.0], Reason.FACT_NOT_FINITE),
    ("frame_status", [0.0, nan, 0.0], Reason.FRAME_FROZEN),
    ("frame_status", [0.0, 0.0, 1.0], Reason.FRAME_STAMP),
    ("frame_status", [0.0, 0.0, nan], Reason.FRAME_STAMP),
    ("camera_status", [0.03], Reason.CAMERA_ASTRAY),
    ("camera_status", [nan], Reason.CAMERA_ASTRAY),
    ("map_status", [0.0], Reason.BODY_JUMPED),
    ("map_status", [nan], Reason.BODY_JUMPED),
    ("body_status", [0.2, 1.0], Reason.BODY_FAST),
    ("body_status", [0.0, 2.0], Reason.BODY_AMBIGUOUS),
    ("body_status", [0.0, nan], Reason.BODY_AMBIGUOUS),
    ("surface_status", [0.0], Reason.SURFACE_UNSEEN),
    ("world_status", [nan], Reason.WORLD_UNSOUND),
    ("ik_status", [1.0], Reason.NO_JOINT_SOLUTION),
    ("ik_status", [nan], Reason.NO_JOINT_SOLUTION),
    ("self_distance", [0.0], Reason.SELF_COLLISION),
    ("obstacle_distance", [0.0], Reason.LINK_NEAR),
    ("nozzle_clearance", [0.03], Reason.SKIN_NEAR),
    ("command_stamp", [-1.0], Reason.COMMAND_STALE),
    ("command_stamp", [nan], Reason.FACT_NOT_FINITE),
    ("wrench", [0.0, 0.0, 0.0, 0.0, 20.0, 0.0, 0.0], Reason.FORCE_HIGH),
    ("wrench", [0.0, 0.0, 0.0, 0.0, 26.0, 0.0, 0.0], Reason.FORCE_STOP),
    ("wrench", [nan, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0], Reason.FORCE_SENSOR),
    ("loop_seconds", [0.02], Reason.OVERRUN),
    ("robot_stamp", [-1.0], Reason.LINK_LOST),
    ("following_error", [0.03], Reason.ARM_ASTRAY),
    ("following_error", [nan], Reason.ARM_ASTRAY),
    ("other_reason", [float(Reason.AREA_ENTERED)], Reason.AREA_ENTERED),
    ("other_reason", [0.5], Reason.FACT_NOT_FINITE),
    ("other_reason", [nan], Reason.FACT_NOT_FINITE),
]


@pytest.fixture(scope="module")
def plant():
    return make_control_plant(ArmConfig())


@pytest.fixture
def canonical():
    return CanonicalGuard(limits=LIMITS, period=PERIOD)


@pytest.fixture
def joint(plant):
    return JointGuard(plant=plant, home=HOME, limits=LIMITS)


@pytest.fixture(params=["canonical", "joint"])
def guard(request):
    return request.getfixturevalue(request.param)


def fixed(guard, context, **ports):
    """Fixes what a guard needs, and the ports given."""
    needed = {"body_observation": SEEN}
    if isinstance(guard, CanonicalGuard):
        needed |= {
            "canonical_velocity": V_NQ,
            "canonical_position": P_NQ,
            "navigation_field": FIELD,
            "canonical_map": MAP,
        }
    else:
        needed |= {"joint_command": COMMAND}
    for name, value in {**needed, **ports}.items():
        guard.GetInputPort(name).FixValue(context, value)


def out(guard, context, port):
    return guard.GetOutputPort(port).Eval(context)


def run(guard, end, **ports):
    """A simulator whose camera gives a frame at every instant looked at."""
    simulator = Simulator(guard, guard.CreateDefaultContext())
    context = simulator.get_mutable_context()
    fixed(guard, context, **ports)
    simulator.Initialize()
    advance(guard, simulator, end)
    return simulator


def advance(guard, simulator, end, **ports):
    context = simulator.get_mutable_context()
    while context.get_time() < end - 1e-9:
        seen = dataclasses.replace(SEEN, stamp=context.get_time())
        for name, value in {"body_observation": seen, **ports}.items():
            guard.GetInputPort(name).FixValue(context, value)
        simulator.AdvanceTo(min(context.get_time() + 0.05, end))
    return context


def test_before_the_first_update_both_hold(guard):
    context = guard.CreateDefaultContext()
    assert out(guard, context, "guard_mode")[0] == Mode.HOLD
    assert out(guard, context, "guard_reason")[0] == Reason.NO_FRAME


def test_the_canonical_port_is_that_of_the_pure_function(canonical):
    simulator = run(canonical, 0.5)
    context = simulator.get_context()
    tick = CanonicalTick()
    world = guarded_world(FIELD, ObstacleSet(), LIMITS.canonical.margin)
    for k in range(50):
        facts = GuardFacts(now=PERIOD * k, frame_stamp=PERIOD * k)
        tick = canonical_tick(
            tick,
            V_NQ,
            P_NQ,
            facts,
            world=world,
            half_extents=MAP.half_extents,
            dt=PERIOD,
            limits=LIMITS,
        )
    assert tick.state.mode is Mode.PASS
    np.testing.assert_array_equal(
        out(canonical, context, "checked_velocity"), tick.velocity
    )
    np.testing.assert_array_equal(tick.velocity, V_NQ)
    assert out(canonical, context, "limited_count")[0] == tick.limited > 0


def test_the_joint_port_is_that_of_the_pure_function(joint, plant):
    context = run(joint, 0.5).get_context()
    joints = JointRange(
        np.array(plant.GetPositionLowerLimits()) + LIMITS.joints.margin,
        np.array(plant.GetPositionUpperLimits()) - LIMITS.joints.margin,
    )
    tick = JointTick(emitted=Emitted.at_rest(HOME))
    # The command is slow, and so the tip, wherever the arm is: any such one will do.
    J = 0.1 * np.eye(6, 7)
    for k in range(100):
        facts = GuardFacts(now=0.005 * k, frame_stamp=0.005 * k)
        tick = joint_tick(
            tick, COMMAND, J, facts, joints=joints, dt=0.005, limits=LIMITS
        )
    assert tick.state.mode is Mode.PASS
    np.testing.assert_array_equal(
        out(joint, context, "checked_command"), tick.emitted.vector()
    )


def test_all_ports_together_pass_where_all_is_well(guard):
    simulator = run(guard, 0.3)
    # Stamps are of this instant: fresh enough for the next two ticks.
    now = simulator.get_context().get_time()
    stamps = {"command_stamp": [now], "robot_stamp": [now]}
    wrench = [now, *WELL["wrench"][1:]]
    ports = {**WELL, **stamps, "wrench": wrench}
    assert set(ports) == set(OPTIONAL_PORTS)
    context = advance(guard, simulator, now + PERIOD, **ports)
    assert out(guard, context, "guard_mode")[0] == Mode.PASS


@pytest.mark.parametrize(("port", "value", "reason"), WRONG)
def test_each_port_leads_to_its_reason_at_the_next_tick(guard, port, value, reason):
    simulator = run(guard, 0.4, surface_normal=NORMAL)
    context = simulator.get_mutable_context()
    assert out(guard, context, "guard_mode")[0] == Mode.PASS
    began = context.get_time()
    ports = {port: value, "body_observation": dataclasses.replace(SEEN, stamp=began)}
    if port == "wrench" and np.isfinite(value[0]):
        ports[port] = [began, *value[1:]]
    fixed(guard, context, **ports)
    simulator.AdvanceTo(began + PERIOD)
    assert out(guard, context, "guard_reason")[0] == reason
    assert out(guard, context, "guard_counts")[reason] == 1.0
    assert out(guard, context, "guard_mode")[0] > Mode.PASS


def test_an_old_frame_holds_then_retreats(joint):
    simulator = run(joint, 0.4, surface_normal=NORMAL)
    context = simulator.get_mutable_context()
    simulator.AdvanceTo(0.4 + LIMITS.frames.hold_age)
    assert out(joint, context, "guard_reason")[0] == Reason.FRAME_STALE
    simulator.AdvanceTo(0.4 + LIMITS.frames.retreat_age)
    assert out(joint, context, "guard_reason")[0] == Reason.FRAME_LOST
    assert out(joint, context, "guard_mode")[0] == Mode.RETREAT


def nozzle(plant, q):
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    return plant.GetFrameByName("nozzle_tip").CalcPoseInWorld(context)


def test_a_retreat_moves_the_nozzle_along_the_normal_and_holds_there(joint, plant):
    simulator = run(joint, 0.4, surface_normal=NORMAL)
    context = simulator.get_mutable_context()
    before = nozzle(plant, out(joint, context, "checked_command")[:7])
    advance(joint, simulator, 3.0, body_status=[1.0, 1.0])
    assert out(joint, context, "guard_mode")[0] == Mode.HOLD
    assert out(joint, context, "guard_reason")[0] == Reason.BODY_FAST
    after = nozzle(plant, out(joint, context, "checked_command")[:7])
    moved = after.translation() - before.translation()
    # The damped inverse goes up to a sixth slower; the way is along the normal to a
    # tenth or so, for the damping turns it a little.
    way = LIMITS.nozzle.retreat_distance
    assert 0.82 * way < moved @ np.array(NORMAL) < 1.01 * way
    assert np.linalg.norm(np.delete(moved, 1)) < 0.11 * way
    turned = before.rotation().inverse().multiply(after.rotation())
    assert turned.ToAngleAxis().angle() < 0.1
    np.testing.assert_array_equal(out(joint, context, "checked_command")[7:], 0.0)


def test_a_restricted_area_over_the_point_makes_the_point_stand(canonical):
    simulator = run(canonical, 0.4)
    context = simulator.get_mutable_context()
    assert out(canonical, context, "checked_velocity").any()
    advance(canonical, simulator, 0.42, sensed_obstacles=AREAS)
    np.testing.assert_array_equal(out(canonical, context, "checked_velocity"), [0, 0])
    assert out(canonical, context, "guard_reason")[0] == Reason.AREA_ENTERED


def test_near_a_singularity_the_point_slows(canonical):
    context = run(canonical, 0.5, condition_number=[23.5]).get_context()
    np.testing.assert_allclose(
        out(canonical, context, "checked_velocity"), 0.5 * V_NQ, rtol=1e-12
    )


def test_nothing_that_is_not_a_number_leaves(canonical, joint):
    context = run(canonical, 0.4, canonical_velocity=[nan, 0.0]).get_context()
    np.testing.assert_array_equal(out(canonical, context, "checked_velocity"), [0, 0])
    assert out(canonical, context, "guard_reason")[0] == Reason.COMMAND_NOT_FINITE
    context = run(joint, 0.4, joint_command=np.full(14, nan)).get_context()
    expected = np.concatenate([HOME, np.zeros(7)])
    np.testing.assert_array_equal(out(joint, context, "checked_command"), expected)


def test_a_stop_is_left_by_the_reset_port_alone(joint):
    simulator = run(joint, 0.4)
    advance(joint, simulator, 0.42, robot_stamp=[-1.0])
    context = simulator.get_mutable_context()
    assert out(joint, context, "guard_mode")[0] == Mode.STOP
    advance(joint, simulator, 1.0, robot_stamp=[0.42], reset=[0.0])
    assert out(joint, context, "guard_mode")[0] == Mode.STOP
    advance(joint, simulator, 1.02, robot_stamp=[1.0], reset=[1.0])
    assert out(joint, context, "guard_mode")[0] == Mode.HOLD


def test_the_hold_is_off_while_it_passes_alone(joint):
    simulator = run(joint, 0.1)
    context = simulator.get_mutable_context()
    assert out(joint, context, "hold")[0] == 1.0
    advance(joint, simulator, 0.4)
    assert out(joint, context, "hold")[0] == 0.0
    advance(joint, simulator, 0.42, body_status=[1.0, 1.0])
    assert out(joint, context, "hold")[0] == 1.0


def test_what_is_emitted_can_be_put_into_a_context_and_is_checked(joint):
    context = joint.CreateDefaultContext()
    q = HOME + 0.01
    joint.set_command(context, q)
    np.testing.assert_array_equal(out(joint, context, "checked_command")[:7], q)
    with pytest.raises(ValueError, match="home must be 7 positions"):
        joint.set_command(context, np.full(7, 9.0))


def test_the_condition_number_is_finite_at_home(joint):
    context = joint.CreateDefaultContext()
    number = out(joint, context, "condition_number")[0]
    assert 1.0 < number < LIMITS.joints.condition_stop


def test_a_wrong_value_is_refused_by_the_name_of_its_port(guard):
    context = guard.CreateDefaultContext()
    fixed(guard, context)
    guard.GetInputPort("body_observation").FixValue(context, "frame")
    with pytest.raises(TypeError, match="body_observation"):
        Simulator(guard, context).AdvanceTo(PERIOD)


def test_limits_out_of_their_range_are_refused(plant):
    limits = GuardLimits()
    limits.force.stop = 100.0
    for make in (
        lambda: CanonicalGuard(limits=limits),
        lambda: JointGuard(plant=plant, home=HOME, limits=limits),
    ):
        with pytest.raises(ValueError, match=r"force\.stop: found 100"):
            make()
    with pytest.raises(ValueError, match="period must be positive"):
        CanonicalGuard(limits=LIMITS, period=0.0)
    with pytest.raises(ValueError, match="home must be 7 positions"):
        JointGuard(plant=plant, home=np.full(7, 9.0), limits=LIMITS)
