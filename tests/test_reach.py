"""From home the arm reaches every side of every shipped person's back."""

import itertools

import numpy as np
import pytest
from pose_source import PoseSource
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from bath_drake.diagrams.control import PLANNED_MARGIN
from bath_drake.patient.people import load_person, shipped_people
from bath_drake.patient.skin import TrueSkin
from bath_drake.reach.kinematics import condition_number
from bath_drake.safety.limits import GuardLimits
from bath_drake.safety.self_distance import self_distance
from bath_drake.scene.arm import home_position, make_control_plant
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.scene.config import ArmConfig, SceneConfig
from bath_drake.scene.studio import true_person_pose
from bath_drake.systems.differential_ik import DifferentialIk
from bath_drake.systems.nozzle_kinematics import NOZZLE_FRAME

CHAIN = arm_chain(ArmConfig())
STEP, SPEED = 0.005, 0.1
FAR, NEAR = 0.14, 0.06
# In canonical space: where a stroke begins, and where it leads.
STROKES = {
    "from the left": [[-0.68, 0.0], [-0.35, 0.25], [0.1, 0.33], [0.68, 0.0]],
    "from the right": [[0.68, 0.0], [0.3, 0.3], [-0.4, 0.35], [-0.68, 0.0]],
    "from above": [[0.0, 0.8], [0.7, -0.3], [-0.5, -0.4], [-0.6, 0.8]],
    "from below": [[0.0, -0.8], [-0.7, 0.3], [0.7, 0.8], [0.75, -0.8]],
    "along the top": [[-0.3, 0.6], [-0.7, 0.8], [0.75, 0.8], [0.3, 0.55]],
}
# s, when the person is twisted and leans.
TIME = 5.0
TIGHT = ("m_heavy", "from the right")


def between(ends, speed=SPEED):
    """Points of a polygon, as far apart as one step of the speed takes."""
    rows = []
    for a, b in itertools.pairwise(ends):
        count = max(2, int(np.linalg.norm(b - a) / speed / STEP))
        rows.append(a + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (b - a))
    return np.concatenate(rows)


def poses(person, stroke, t, home):
    """From home to the far stand-off, down, and along the stroke."""
    skin, scene = TrueSkin(person), SceneConfig(person=person.name)
    half = skin.canonical_map.half_extents
    canonical = between(np.array(stroke) * half) / half
    points, met = skin.under(canonical)
    assert met.all()
    _, points, normals = skin.nearest(points)
    # The mesh's facets turn by some degrees at once; skin does not.
    width = 60
    kernel = np.hanning(2 * width + 1) / width
    padded = np.pad(normals, ((width, width), (0, 0)), mode="edge")
    normals = np.column_stack(
        [np.convolve(padded[:, k], kernel, mode="valid") for k in range(3)]
    )
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    X_WM = true_person_pose(scene, person, t)
    points = X_WM.multiply(points.T).T
    normals = normals @ X_WM.rotation().matrix().T
    down = np.concatenate([np.linspace(FAR, NEAR, 300), np.full(len(points), NEAR)])
    start, first = np.repeat(points[:1], 300, 0), np.repeat(normals[:1], 300, 0)
    points, normals = np.vstack([start, points]), np.vstack([first, normals])
    tips = points + down[:, None] * normals
    way = between(np.stack([home.translation(), tips[0]]))
    share = np.linspace(0.0, 1.0, len(way))[:, None]
    turned = (1.0 - share) * -home.rotation().matrix()[:, 2] + share * normals[0]
    turned /= np.linalg.norm(turned, axis=1)[:, None]
    tips, normals = np.vstack([way, tips]), np.vstack([turned, normals])
    return [
        RigidTransform(RotationMatrix.MakeFromOneVector(-n, 2), p)
        for n, p in zip(normals, tips, strict=True)
    ]


def check(name, stroke):
    plant, person = make_control_plant(ArmConfig()), load_person(name)
    q_home, context = home_position(ArmConfig()), plant.CreateDefaultContext()
    plant.SetPositions(context, q_home)
    home = plant.GetFrameByName(NOZZLE_FRAME).CalcPoseInWorld(context)
    wanted = poses(person, STROKES[stroke], TIME, home)
    builder = DiagramBuilder()
    source = builder.AddSystem(PoseSource(wanted, STEP))
    ik = builder.AddSystem(
        DifferentialIk(
            plant=plant,
            home=q_home,
            posture=ArmConfig().posture,
            # As in the loop (bath_drake.diagrams.control).
            joint_margin=GuardLimits().joints.margin + PLANNED_MARGIN,
        )
    )
    for port in ("desired_nozzle_pose", "hold"):
        builder.Connect(source.GetOutputPort(port), ik.GetInputPort(port))
    commands = LogVectorOutput(ik.GetOutputPort("joint_command"), builder, STEP)
    statuses = LogVectorOutput(ik.GetOutputPort("ik_status"), builder, STEP)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(STEP * len(wanted))
    root = simulator.get_context()
    assert not statuses.FindLog(root).data().any()
    q = commands.FindLog(root).data()[:7].T
    low, high = plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()
    # The guard keeps 0.1. On one of the forty strokes joint 6 comes to where the
    # inverse kinematics stops it; on all others 0.25 rad are left.
    margin = np.minimum(q - low, high - q).min()
    assert margin > (0.1 if (name, stroke) == TIGHT else 0.25), margin
    limits = GuardLimits().joints
    assert max(condition_number(row, CHAIN) for row in q[::4]) < limits.condition_slow
    nearest = min(self_distance(row, CHAIN) for row in q)
    assert nearest > limits.self_distance, nearest


@pytest.mark.slow
@pytest.mark.parametrize("name", shipped_people())
@pytest.mark.parametrize("stroke", ["from the left", "from below"])
def test_a_stroke_is_followed_well_within_the_joint_limits(name, stroke):
    check(name, stroke)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", shipped_people())
@pytest.mark.parametrize("stroke", ["from the right", "from above", "along the top"])
def test_every_stroke_is_followed_well_within_the_joint_limits(name, stroke):
    check(name, stroke)
