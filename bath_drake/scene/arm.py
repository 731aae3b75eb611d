"""The arm: its model in a plant, and alone for kinematics and silhouettes."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Mesh,
    Role,
    SceneGraph,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
    Frame,
    JointActuatorIndex,
    ModelInstanceIndex,
    PdControllerGains,
    PrismaticJoint,
    PrismaticSpring,
)
from pydrake.systems.framework import DiagramBuilder

from bath_drake.errors import ScenarioError
from bath_drake.notation import FloatArray
from bath_drake.resources import models_folder
from bath_drake.scene.arm_file import find_arm
from bath_drake.scene.config import ArmConfig
from bath_drake.systems._ports import drake_vector
from bath_drake.systems._poses import at
from bath_drake.systems.nozzle_kinematics import NOZZLE_FRAME

# The link that a model of an arm stands on.
BASE_LINK = "base"
_JOINTS = 7
SPONGE_BODY = "sponge"
# A capsule around it in the nozzle's frame E: two ends and a radius, m.
SPONGE_CAPSULES = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.03, 0.033]])
# How far its face is ahead of the nozzle's tip while nothing presses on it, m.
SPONGE_LENGTH = 0.06
# N/m along its axis, N s/m, and how far it gives, m: a bath sponge of some 20 cm^2 and
# 30 mm that gives 8 mm to 4 N. An assumption of ours, not a measurement.
SPONGE_STIFFNESS, _SPONGE_DAMPING, _SPONGE_GIVES = 500.0, 5.0, 0.025
# A circle's outline as a polygon around it, for the hulls.
_CIRCLE_CORNERS = 16


def base_pose(config: ArmConfig) -> RigidTransform:
    """Returns X_WB, the arm's base in the world."""
    return at(config.base_position, RotationMatrix.MakeZRotation(config.base_yaw))


def add_arm(
    plant: MultibodyPlant, config: ArmConfig, *, soft: bool = False
) -> ModelInstanceIndex:
    """Adds the arm, welded at its base, with its PD gains; instance `arm`.

    A sponge is an instance of its own, `sponge`, at the nozzle's tip.

    Args:
        plant: Gets it.
        config: Its place, gains and tool.
        soft: Whether a sponge gives way along its axis, on a spring; else it is welded.

    Raises:
        ScenarioError: If its model cannot be read, or is no arm of ours: links `base`
            and `nozzle_tip`, seven actuators.
    """
    parser = Parser(plant)
    models = models_folder()
    parser.package_map().Add("bath_models", models)
    urdf, before = find_arm(config.model), plant.num_actuators()
    arm = _parsed(parser, plant, urdf)
    plant.WeldFrames(
        plant.world_frame(), plant.GetFrameByName(BASE_LINK, arm), base_pose(config)
    )
    # The list of an instance's actuators is empty before Finalize.
    actuators = [
        plant.get_joint_actuator(JointActuatorIndex(k))
        for k in range(before, plant.num_actuators())
    ]
    if len(actuators) != _JOINTS:
        raise ScenarioError(
            f"{urdf}: found {len(actuators)} actuators, allowed {_JOINTS}: a"
            " transmission for every joint"
        )
    for actuator, p, d in zip(actuators, config.stiffness, config.damping, strict=True):
        actuator.set_controller_gains(PdControllerGains(p=p, d=d))
    if config.tool == "sponge":
        (sponge,) = parser.AddModels(models / "arm" / "sponge.urdf")
        tip = plant.GetFrameByName(NOZZLE_FRAME, arm)
        body = plant.GetBodyByName(SPONGE_BODY, sponge)
        if soft:
            _add_spring(plant, tip, body.body_frame())
        else:
            plant.WeldFrames(tip, body.body_frame())
    return arm


def _parsed(parser: Parser, plant: MultibodyPlant, urdf: Path) -> ModelInstanceIndex:
    # Links are looked for by name: the model's own name is nobody's business.
    parser.SetAutoRenaming(True)
    try:
        (arm,) = parser.AddModels(urdf)
    except (RuntimeError, ValueError) as error:
        told = (str(error).splitlines() or [type(error).__name__])[0][:200]
        raise ScenarioError(f"{urdf}: found no one arm in it ({told})") from error
    for link in (BASE_LINK, NOZZLE_FRAME):
        if not plant.HasFrameNamed(link, arm):
            raise ScenarioError(f"{urdf}: found no link {link!r}, allowed one")
    return arm


def _add_spring(plant: MultibodyPlant, tip: Frame, sponge: Frame) -> None:
    joint: Any = plant.AddJoint(
        PrismaticJoint(
            "sponge_spring",
            tip,
            sponge,
            drake_vector([0.0, 0.0, 1.0]),
            -_SPONGE_GIVES,
            _SPONGE_GIVES,
            _SPONGE_DAMPING,
        )
    )
    plant.AddForceElement(PrismaticSpring(joint, 0.0, SPONGE_STIFFNESS))


def make_control_plant(config: ArmConfig) -> MultibodyPlant:
    """Returns a finalised plant of the arm alone, seven positions, for control."""
    plant = MultibodyPlant(time_step=0.0)
    add_arm(plant, config)
    plant.Finalize()
    return plant


def home_position(config: ArmConfig) -> FloatArray:
    """Returns the joint positions (7,) where a run begins and ends, rad."""
    return np.array(config.home, dtype=np.float64)


class ArmGeometry:
    """The arm's links as convex hulls, as the camera sees them.

    Each piece of the arm that the simulated camera sees lies inside its hull, so
    the hulls' projection covers the robot in the image.
    """

    def __init__(self, config: ArmConfig) -> None:
        """Loads the arm model once; the joint positions come with each call."""
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
        add_arm(plant, config)
        plant.Finalize()
        self._plant = plant
        self._hulls = _link_hulls(plant, scene_graph)
        # The plant refers to the scene graph, which the diagram owns.
        self._diagram = builder.Build()
        # A scratch pad, written before every use: it remembers nothing.
        self._scratch = plant.CreateDefaultContext()

    def hulls_in_world(self, q: FloatArray) -> Sequence[FloatArray]:
        """Returns hull vertices (n, 3) in W, m, a piece, at positions q (7,)."""
        plant, context = self._plant, self._scratch
        plant.SetPositions(context, q)
        hulls = []
        for index, p_LV in self._hulls:
            X_WL = plant.EvalBodyPoseInWorld(context, plant.get_body(index))
            hulls.append((X_WL.rotation().matrix() @ p_LV.T).T + X_WL.translation())
        return hulls


def _link_hulls(
    plant: MultibodyPlant, scene_graph: SceneGraph
) -> list[tuple[BodyIndex, FloatArray]]:
    inspector = scene_graph.model_inspector()
    hulls = []
    for k in range(plant.num_bodies()):
        frame = plant.GetBodyFrameIdIfExists(BodyIndex(k))
        if frame is None:
            continue
        for geometry in inspector.GetGeometries(frame, Role.kPerception):
            p_GV = hull_vertices(inspector.GetShape(geometry))
            X_LG = inspector.GetPoseInFrame(geometry)
            p_LV = (X_LG.rotation().matrix() @ p_GV.T).T + X_LG.translation()
            hulls.append((BodyIndex(k), p_LV))
    return hulls


def hull_vertices(shape: Shape) -> FloatArray:
    """Vertices (n, 3) in G of a convex hull that holds the shape, m."""
    if isinstance(shape, Mesh | Convex):
        hull = shape.GetConvexHull()
        return np.array([hull.vertex(k) for k in range(hull.num_vertices())])
    if isinstance(shape, Sphere):
        return _capsule_vertices(shape.radius(), 0.0)
    if isinstance(shape, Capsule):
        return _capsule_vertices(shape.radius(), shape.length())
    if isinstance(shape, Box):
        corners = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5]))
        box: FloatArray = corners.reshape(3, -1).T * shape.size()
        return box
    if isinstance(shape, Cylinder):
        turns = np.linspace(0.0, 2.0 * np.pi, _CIRCLE_CORNERS, endpoint=False)
        radius = shape.radius() / np.cos(np.pi / _CIRCLE_CORNERS)
        circle = radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        ends = [-shape.length() / 2.0, shape.length() / 2.0]
        return np.vstack([np.column_stack([circle, np.full(16, z)]) for z in ends])
    raise ScenarioError(f"no hull for a {type(shape).__name__} of the arm")


def _capsule_vertices(radius: float, length: float) -> FloatArray:
    """Around a capsule along z: rings of a polyhedron that holds both its balls."""
    half = np.pi / _CIRCLE_CORNERS
    wide = radius / np.cos(half) ** 2
    rings = []
    for end in (-0.5 * length, 0.5 * length):
        for tilt in np.linspace(-0.5 * np.pi, 0.5 * np.pi, _CIRCLE_CORNERS // 2 + 1):
            turns = np.linspace(0.0, 2.0 * np.pi, _CIRCLE_CORNERS, endpoint=False)
            level = np.cos(tilt) * np.stack([np.cos(turns), np.sin(turns)], axis=1)
            height = np.full(_CIRCLE_CORNERS, np.sin(tilt))
            ring = wide * np.column_stack([level, height])
            ring[:, 2] += end
            rings.append(ring)
    return np.vstack(rings)
