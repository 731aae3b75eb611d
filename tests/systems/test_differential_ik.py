"""The differential IK: it tracks, it holds, and nothing bad ever leaves it."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput

from bath_drake.control.pose_tracking import TrackingConfig
from bath_drake.scene.arm import home_position, make_control_plant
from bath_drake.scene.config import ArmConfig
from bath_drake.systems.differential_ik import DifferentialIk

STEP = 0.005


class MovingPose(LeafSystem):
    """A desired pose and a hold as functions of time."""

    def __init__(self, pose, hold):
        super().__init__()
        self._pose, self._hold = pose, hold
        time = {self.time_ticket()}
        self.DeclareAbstractOutputPort(
            "desired_nozzle_pose",
            lambda: Value(RigidTransform()),
            lambda context, out: out.set_value(self._pose(context.get_time())),
            time,
        )
        self.DeclareVectorOutputPort(
            "hold",
            1,
            lambda context, out: out.SetFromVector([self._hold(context.get_time())]),
            time,
        )


@pytest.fixture(scope="module")
def plant():
    return make_control_plant(ArmConfig())


@pytest.fixture
def dut(plant):
    return DifferentialIk(plant=plant, home=home_position(ArmConfig()))


def nozzle(plant, q):
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    return plant.GetFrameByName("nozzle_tip").CalcPoseInWorld(context)


def home_pose(plant):
    return nozzle(plant, home_position(ArmConfig()))


def moved(X_WE, translation, rpy=(0.0, 0.0, 0.0)):
    turn = RollPitchYaw(*rpy).ToRotationMatrix()
    return RigidTransform(
        turn @ X_WE.rotation(), X_WE.translation() + np.asarray(translation)
    )


def run(dut, pose, seconds, hold=lambda t: 0.0):
    """Returns times, commands (n, 14) and statuses (n,) after every step."""
    builder = DiagramBuilder()
    source = builder.AddSystem(MovingPose(pose, hold))
    builder.AddSystem(dut)
    for port in ("desired_nozzle_pose", "hold"):
        builder.Connect(source.GetOutputPort(port), dut.GetInputPort(port))
    commands = LogVectorOutput(dut.GetOutputPort("joint_command"), builder, STEP)
    statuses = LogVectorOutput(dut.GetOutputPort("ik_status"), builder, STEP)
    simulator = Simulator(builder.Build())
    # A step is logged with the time at its end: half a step more, and all are.
    simulator.AdvanceTo(seconds + STEP / 2)
    context = simulator.get_context()
    log = commands.FindLog(context)
    return (
        log.sample_times()[1:],
        log.data().T[1:],
        statuses.FindLog(context).data()[0, 1:],
    )


def test_it_starts_at_home_at_rest(dut):
    context = dut.CreateDefaultContext()
    command = dut.GetOutputPort("joint_command").Eval(context)
    np.testing.assert_array_equal(
        command, np.concatenate([home_position(ArmConfig()), np.zeros(7)])
    )
    assert dut.GetOutputPort("ik_status").Eval(context)[0] == 0.0


def test_it_reaches_a_pose_and_stays_there(dut, plant):
    goal = moved(home_pose(plant), [0.03, 0.08, -0.06], (0.1, -0.1, 0.2))
    _, commands, statuses = run(dut, lambda t: goal, 3.0)
    reached = nozzle(plant, commands[-1, :7])
    assert not statuses.any()
    # Three seconds are 60 time constants of the gain, less the way at full speed.
    np.testing.assert_allclose(reached.translation(), goal.translation(), atol=1e-5)
    # The jet's axis; the roll about it is free.
    np.testing.assert_allclose(
        reached.rotation().col(2), goal.rotation().col(2), atol=1e-4
    )
    assert np.abs(commands[-1, 7:]).max() < 0.02  # only posture centring is left


def test_a_moving_pose_is_followed_without_lag(dut, plant):
    start = home_pose(plant)

    def pose(t):
        washing = 0.08 * np.array([0.0, np.sin(1.0 * t), 1.0 - np.cos(1.0 * t)])
        breathing = np.array([0.016 * np.sin(1.57 * t), 0.0, 0.0])
        return moved(start, 0.5 * washing + breathing)

    times, commands, statuses = run(dut, pose, 6.0)
    assert not statuses.any()
    errors = [
        np.linalg.norm(nozzle(plant, q[:7]).translation() - pose(t).translation())
        for t, q in zip(times, commands, strict=True)
        if t > 1.0
    ]
    assert max(errors) < 0.0015  # m: what is left of 1.5 mm is the surface's


@pytest.mark.parametrize("roll", [0.0, 1.5, np.pi, -2.0])
def test_however_the_jet_is_rolled_its_direction_is_followed_as_well(dut, plant, roll):
    """A turn about the jet that is not followed must not cost the others' speed."""
    start = home_pose(plant)
    about_jet = RollPitchYaw(0.0, 0.0, roll).ToRotationMatrix()

    def pose(t):
        swaying = moved(start, [0.0] * 3, (0.0, 0.2 * np.sin(t), 0.2 - 0.2 * np.cos(t)))
        return RigidTransform(swaying.rotation() @ about_jet, swaying.translation())

    times, commands, statuses = run(dut, pose, 4.0)
    assert not statuses.any()
    angles = [
        np.arccos(
            np.clip(
                nozzle(plant, q[:7]).rotation().col(2) @ pose(t).rotation().col(2),
                -1.0,
                1.0,
            )
        )
        for t, q in zip(times, commands, strict=True)
        if t > 1.0
    ]
    # The feed-forward's filter lags 0.08 s behind a turn of 0.2 rad/s^2.
    assert max(angles) < 0.005


def test_velocity_is_the_commands_own_difference_and_within_bounds(dut, plant):
    goal = moved(home_pose(plant), [0.05, 0.15, -0.1])
    _, commands, _ = run(dut, lambda t: goal, 1.5)
    q, v = commands[:, :7], commands[:, 7:]
    np.testing.assert_allclose(np.diff(q, axis=0) / STEP, v[1:], atol=1e-9)
    assert (np.abs(v) <= 0.5 * plant.GetVelocityUpperLimits() + 1e-6).all()
    accelerations = np.diff(v, axis=0, prepend=np.zeros((1, 7))) / STEP
    assert np.abs(accelerations).max() <= 20.0 * (1.0 + 1e-3)  # solver's tolerance
    tips = [nozzle(plant, row).translation() for row in q]
    speed = np.linalg.norm(np.diff(tips, axis=0), axis=1) / STEP
    assert speed.max() <= TrackingConfig().speed * 1.01


def test_hold_freezes_the_command_and_zeroes_the_velocity(dut, plant):
    goal = moved(home_pose(plant), [0.0, 0.2, 0.0])
    times, commands, statuses = run(
        dut, lambda t: goal, 1.0, hold=lambda t: float(0.4 <= t < 0.7)
    )
    held = (times > 0.4 + STEP / 2) & (times <= 0.7 + STEP / 2)
    before = commands[np.argmax(held) - 1]
    assert np.abs(before[7:]).max() > 0.05  # it was under way
    np.testing.assert_array_equal(commands[held, :7], np.tile(before[:7], (60, 1)))
    np.testing.assert_array_equal(commands[held, 7:], 0.0)
    assert not statuses.any()
    assert np.abs(commands[-1, 7:]).max() > 0.05  # and goes on afterwards


def test_held_it_takes_over_what_the_robot_was_told_meanwhile(dut, plant):
    simulator = Simulator(dut, dut.CreateDefaultContext())
    context = simulator.get_mutable_context()
    told = np.concatenate([home_position(ArmConfig()) + 0.02, np.full(7, 0.3)])
    dut.GetInputPort("desired_nozzle_pose").FixValue(context, Value(home_pose(plant)))
    dut.GetInputPort("emitted_command").FixValue(context, told)
    dut.GetInputPort("hold").FixValue(context, [1.0])
    simulator.AdvanceTo(2.5 * STEP)
    command = dut.GetOutputPort("joint_command").Eval(context)
    np.testing.assert_array_equal(command, np.concatenate([told[:7], np.zeros(7)]))
    # And goes on from there: no further in a step than its acceleration allows.
    dut.GetInputPort("hold").FixValue(context, [0.0])
    simulator.AdvanceTo(3.5 * STEP)
    command = dut.GetOutputPort("joint_command").Eval(context)
    assert 0.0 < np.abs(command[:7] - told[:7]).max() <= 20.0 * STEP**2 + 1e-12


@pytest.mark.parametrize("position", [[np.nan, 0.0, 0.5], [np.inf, 0.0, 0.5]])
def test_a_pose_that_is_not_finite_never_leaves(dut, plant, position):
    good, bad = moved(home_pose(plant), [0.0, 0.1, 0.0]), RigidTransform(position)
    times, commands, statuses = run(dut, lambda t: bad if 0.3 <= t < 0.5 else good, 1.0)
    assert np.isfinite(commands).all()
    lost = (times > 0.3 + STEP / 2) & (times <= 0.5 + STEP / 2)
    assert (statuses[lost] == 1.0).all()
    assert not statuses[~lost].any()
    assert np.ptp(commands[lost, :7], axis=0).max() == 0.0
    np.testing.assert_array_equal(commands[lost, 7:], 0.0)


def test_an_unreachable_pose_ends_within_the_joint_limits(dut, plant):
    far = moved(home_pose(plant), [3.0, 0.0, 1.0])
    _, commands, _ = run(dut, lambda t: far, 8.0)
    assert np.isfinite(commands).all()
    q = commands[:, :7]
    # Of the margin of 0.08 rad, a joint at half its speed (1.3 rad/s) takes 0.042 to
    # come to rest at 20 rad/s^2.
    assert (q >= plant.GetPositionLowerLimits() + 0.038).all()
    assert (q <= plant.GetPositionUpperLimits() - 0.038).all()
    # It leans out towards it, by more than 0.4 of 3.2 m. When, or whether, it gets
    # stuck there is for rounding to decide.
    first, last = (nozzle(plant, row).translation() for row in (q[0], q[-1]))
    away = np.linalg.norm([first, last] - far.translation(), axis=1)
    assert away[1] < away[0] - 0.4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"time_step": 0.0}, "time_step must be positive"),
        ({"speed_fraction": 1.5}, "speed_fraction must be at most 1"),
        ({"joint_acceleration": float("nan")}, "joint_acceleration must be positive"),
        ({"home": np.full(7, 9.0)}, "home must be 7 positions within"),
        ({"home": np.zeros(3)}, "home must be 7 positions"),
    ],
)
def test_bad_parameters_are_refused(plant, arguments, message):
    sound = {"plant": plant, "home": home_position(ArmConfig())}
    with pytest.raises(ValueError, match=message):
        DifferentialIk(**(sound | arguments))


@pytest.mark.parametrize("name", ["gain", "speed", "feed_forward_time"])
def test_tracking_numbers_must_be_positive(name):
    with pytest.raises(ValueError, match=name):
        TrackingConfig(**{name: 0.0})


def test_from_beyond_its_own_range_it_finds_the_way_back(plant):
    """What was taken over while held may be nearer to a limit than it would go."""
    q = home_position(ArmConfig())
    dut = DifferentialIk(plant=plant, home=q, joint_margin=0.12)
    low = plant.GetPositionLowerLimits()
    beyond = q.copy()
    beyond[3] = low[3] + 0.11
    builder = DiagramBuilder()
    source = builder.AddSystem(
        MovingPose(lambda t: home_pose(plant), lambda t: float(t < 0.02))
    )
    builder.AddSystem(dut)
    for port in ("desired_nozzle_pose", "hold"):
        builder.Connect(source.GetOutputPort(port), dut.GetInputPort(port))
    statuses = LogVectorOutput(dut.GetOutputPort("ik_status"), builder, STEP)
    commands = LogVectorOutput(dut.GetOutputPort("joint_command"), builder, STEP)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    context = dut.GetMyMutableContextFromRoot(root)
    emitted = np.concatenate([beyond, np.zeros(7)])
    dut.GetInputPort("emitted_command").FixValue(context, emitted)
    simulator.AdvanceTo(6.0)
    assert not statuses.FindLog(root).data().any()
    joint = commands.FindLog(root).data()[3]
    assert joint[10] >= low[3] + 0.11 - 1e-9
    assert joint[-1] > low[3] + 0.2
