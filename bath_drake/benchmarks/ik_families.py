"""Drake's two families of differential inverse kinematics on one and the same task.

The task: the nozzle's desired poses of a wash on a moving, bending back, as the loop
with ideal perception asks for them. `DoDifferentialInverseKinematics` is asked by our
`DifferentialIk` (velocity of the pose fed forward, the turn about the jet free, joint
accelerations bounded); `DifferentialInverseKinematicsController` follows the poses
themselves, bounds no acceleration, has masks of fixed axes that cannot free that turn,
and takes collision constraints.
"""

import contextlib
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsController,
)
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsSystem as Dik,
)
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.tree import JointIndex
from pydrake.planning import (
    DofMask,
    JointLimits,
    RobotDiagramBuilder,
    SceneGraphCollisionChecker,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BusValue

from bath_drake.control.approach import Phase
from bath_drake.control.pose_tracking import TrackingConfig
from bath_drake.diagrams import build_reproduction
from bath_drake.notation import FloatArray
from bath_drake.scenario import Scenario, find_skill
from bath_drake.scene.arm import add_arm, make_control_plant
from bath_drake.skill_file import load_skill
from bath_drake.systems._ports import drake_vector
from bath_drake.systems.differential_ik import DifferentialIk
from bath_drake.systems.nozzle_kinematics import NOZZLE_FRAME

STEP = 0.005  # s
# The first pose is held for so long before the rest is followed, s: one family turns
# the nozzle about the jet as well.
_SETTLED = 3.0
# Kept between links, and from where on it is heeded, m.
_SAFETY, _INFLUENCE = 0.03, 0.06


@dataclass(frozen=True, eq=False)
class Task:
    """What is to be followed.

    Attributes:
        poses: X_WE, one every `STEP`.
        q: (7,) where the arm begins, rad.
    """

    poses: list[RigidTransform]
    q: FloatArray


@dataclass(frozen=True)
class Tracking:
    """How well and how fast a family followed.

    Attributes:
        mean: Of the tip from where it should be, m.
        greatest: m.
        milliseconds: Of a step, the median.
        acceleration: Greatest of a joint, rad/s^2.
        stood: Steps at which nothing moved though something should have.
    """

    mean: float
    greatest: float
    milliseconds: float
    acceleration: float
    stood: int


def washing_task(scenario: Scenario, seconds: float) -> Task:
    """Records a task from the loop of a scenario with ideal perception.

    Args:
        scenario: Perception and fidelity are made ideal and kinematic.
        seconds: Of washing.

    Raises:
        RuntimeError: If nothing is washed within the scenario's duration.
    """
    scenario.perception.source = "ideal"
    scenario.scene.arm.fidelity = "kinematic"
    skill = load_skill(find_skill(scenario.skill))
    diagram = build_reproduction(scenario, skill)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()

    def told(system: str, port: str) -> Any:
        found = diagram.GetSubsystemByName(system)
        return found.GetOutputPort(port).Eval(found.GetMyContextFromRoot(context))

    poses: list[RigidTransform] = []
    q = np.zeros(0)
    step = 0
    while len(poses) * STEP < seconds:
        step += 1
        if step * STEP > scenario.duration:
            raise RuntimeError(f"only {len(poses) * STEP:.1f} s were washed")
        simulator.AdvanceTo(step * STEP)
        if told("approach_sequencer", "phase")[0] != Phase.WASH:
            continue
        if not poses:
            q = np.array(told("joint_guard", "checked_command")[:7])
        poses.append(RigidTransform(told("surface_reference", "desired_nozzle_pose")))
    return Task(poses, q)


def followed_by_velocity(task: Task, scenario: Scenario) -> Tracking:
    """`DifferentialIk`, which asks DoDifferentialInverseKinematics."""
    arm = scenario.scene.arm
    dut = DifferentialIk(
        plant=make_control_plant(arm),
        home=np.array(arm.home),
        posture=np.array(arm.posture),
    )
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.set_command(context, task.q)
    dut.GetInputPort("hold").FixValue(context, [0.0])
    desired = dut.GetInputPort("desired_nozzle_pose")

    def step(k: int, pose: RigidTransform) -> FloatArray:
        desired.FixValue(context, Value(pose))
        simulator.AdvanceTo((k + 0.5) * STEP)
        command: Any = dut.GetOutputPort("joint_command").Eval(context)
        return np.array(command[:7])

    return _tracked(task, scenario, step)


def followed_by_pose(task: Task, scenario: Scenario, *, collisions: bool) -> Tracking:
    """`DifferentialInverseKinematicsController`, with or without collisions."""
    checker, joints = _checker(scenario)
    plant = checker.plant()
    recipe = _recipe(checker, joints, collisions)
    dut: Any = DifferentialInverseKinematicsController(recipe, [])
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.set_initial_position(context, drake_vector(task.q))
    posture = drake_vector(scenario.scene.arm.posture)
    dut.GetInputPort("nominal_posture").FixValue(context, posture)
    still = np.concatenate([task.q, np.zeros(7)])
    dut.GetInputPort("estimated_state").FixValue(context, drake_vector(still))
    name = plant.GetFrameByName(NOZZLE_FRAME).scoped_name().get_full()

    def step(k: int, pose: RigidTransform) -> FloatArray:
        bus = BusValue()
        bus.Set(name, Value(pose))
        dut.GetInputPort("desired_poses").FixValue(context, Value(bus))
        simulator.AdvanceTo((k + 0.5) * STEP)
        q: FloatArray = dut.GetOutputPort("commanded_position").Eval(context)
        return q

    with _silence():
        return _tracked(task, scenario, step)


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Keeps what the solver's library prints at every step off standard output."""
    sys.stdout.flush()
    kept = os.dup(1)
    try:
        with open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), 1)
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def _tracked(task: Task, scenario: Scenario, step: Any) -> Tracking:
    plant = make_control_plant(scenario.scene.arm)
    context = plant.CreateDefaultContext()
    frame = plant.GetFrameByName(NOZZLE_FRAME)
    away, seconds, stood = [], [], 0
    path = [task.q]
    first = round(_SETTLED / STEP)
    poses = [task.poses[0]] * first + task.poses
    for k, pose in enumerate(poses):
        begin = time.perf_counter()
        q = np.array(step(k, pose))
        seconds.append(time.perf_counter() - begin)
        plant.SetPositions(context, drake_vector(q))
        tip = np.array(frame.CalcPoseInWorld(context).translation())
        away.append(float(np.linalg.norm(tip - np.array(pose.translation()))))
        stood += int(np.array_equal(q, path[-1]) and away[-1] > 1e-3)
        path.append(q)
    settled = np.array(away[first:])
    followed: Any = np.stack(path[first:])
    bends = (followed[2:] - 2.0 * followed[1:-1] + followed[:-2]) / STEP**2
    return Tracking(
        mean=float(settled.mean()),
        greatest=float(settled.max()),
        milliseconds=1e3 * float(np.median(seconds)),
        acceleration=float(np.abs(bends).max()),
        stood=stood,
    )


def _checker(scenario: Scenario) -> tuple[Any, list[Any]]:
    builder = RobotDiagramBuilder(time_step=1e-3)
    instance = add_arm(builder.plant(), scenario.scene.arm)
    model: Any = builder.Build()
    plant = model.plant()
    joints = [plant.get_joint(JointIndex(k)) for k in range(plant.num_joints())]
    make: Any = SceneGraphCollisionChecker  # its stub takes nothing
    checker = make(
        model=model,
        robot_model_instances=[instance],
        edge_step_size=0.1,
        configuration_distance_function=lambda a, b: float(np.linalg.norm(a - b)),
    )
    return checker, [joint for joint in joints if joint.num_velocities() > 0]


def _recipe(checker: Any, joints: list[Any], collisions: bool) -> Dik:
    plant = checker.plant()
    tracking = TrackingConfig()
    turn, shift = tracking.angular_speed, tracking.speed
    fastest = [turn] * 3 + [shift] * 3
    limits = JointLimits(plant)
    starts = [joint.velocity_start() for joint in joints]
    active = [k in starts for k in range(plant.num_velocities())]
    recipe = Dik.Recipe()
    least = Dik.LeastSquaresCost.Config(cartesian_qp_weight=100.0)
    recipe.AddIngredient(Dik.LeastSquaresCost(least))
    centre = Dik.JointCenteringCost.Config(posture_gain=0.5)
    recipe.AddIngredient(Dik.JointCenteringCost(centre))
    slow = Dik.CartesianVelocityLimitConstraint.Config(V_next_TG_limit=fastest)
    recipe.AddIngredient(Dik.CartesianVelocityLimitConstraint(slow))
    margin = Dik.JointVelocityLimitConstraint.Config(
        min_margin=0.01, influence_margin=0.1
    )
    recipe.AddIngredient(Dik.JointVelocityLimitConstraint(margin, limits))
    if collisions:
        apart = Dik.CollisionConstraint.Config(
            safety_distance=_SAFETY, influence_distance=_INFLUENCE
        )
        recipe.AddIngredient(Dik.CollisionConstraint(apart))
    return Dik(
        recipe=recipe,
        task_frame="world",
        collision_checker=checker,
        active_dof=DofMask(active),
        time_step=STEP,
        K_VX=1.0,
        Vd_TG_limit=SpatialVelocity(
            w=drake_vector([turn] * 3), v=drake_vector([shift] * 3)
        ),
    )
