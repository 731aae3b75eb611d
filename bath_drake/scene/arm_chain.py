"""Reads an arm's chain of links out of its model, and fits capsules to their shapes."""

import itertools
from functools import lru_cache
from pathlib import Path

import numpy as np
from pydrake.geometry import Role
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, JointIndex, RevoluteJoint, RigidBody
from pydrake.systems.framework import DiagramBuilder

from bath_drake.errors import ScenarioError
from bath_drake.notation import FloatArray
from bath_drake.safety.arm_chain import NOZZLE, ArmChain
from bath_drake.safety.limits import JOINTS
from bath_drake.scene.arm import BASE_LINK, SPONGE_CAPSULES, add_arm, hull_vertices
from bath_drake.scene.arm_file import find_arm, read_arm_file
from bath_drake.scene.config import ArmConfig
from bath_drake.systems._ports import drake_vector
from bath_drake.systems.nozzle_kinematics import NOZZLE_FRAME

# m. A capsule is a segment: one that is nearly a ball is given such a length.
_SHORTEST = 1e-3


def arm_chain(config: ArmConfig) -> ArmChain:
    """Returns a scenario's arm.

    Raises:
        ScenarioError: If its model is no arm of seven turning joints in a row, from
            `base` to `nozzle_tip`, or its file is damaged.
    """
    urdf = find_arm(config.model)
    told = urdf.with_suffix(".yaml")
    stamps = tuple(p.stat().st_mtime_ns if p.exists() else 0 for p in (urdf, told))
    chain = _read(urdf, config.model, stamps)
    return chain.with_tool(SPONGE_CAPSULES) if config.tool == "sponge" else chain


@lru_cache(maxsize=8)
def _read(urdf: Path, model: str, stamps: tuple[int, ...]) -> ArmChain:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    # At the world's origin: base and world are one frame.
    at_origin = ArmConfig(model=model, base_position=[0.0, 0.0, 0.0], base_yaw=0.0)
    add_arm(plant, at_origin)
    plant.Finalize()
    joints = _joints(plant, urdf)
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, drake_vector(np.zeros(JOINTS)))
    # Each link's frame: its body's, turned until z is the joint's axis.
    X_BL: list[FloatArray] = [np.eye(4)]
    for joint in joints:
        X = np.array(joint.frame_on_child().CalcPoseInWorld(context).GetAsMatrix4())
        X[:3, :3] = X[:3, :3] @ _onto_z(np.array(joint.revolute_axis()))
        X_BL.append(X)
    steps = [np.linalg.solve(a, b) for a, b in itertools.pairwise(X_BL)]
    tip = plant.GetFrameByName(NOZZLE_FRAME).CalcPoseInWorld(context).GetAsMatrix4()
    X_BL.append(X_BL[-1])
    rows = []
    for k, body in _links(plant, joints):
        frame = plant.GetBodyFrameIdOrThrow(body.index())
        inspector = scene_graph.model_inspector()
        X_LB = np.linalg.solve(
            X_BL[k], plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4()
        )
        for geometry in inspector.GetGeometries(frame, Role.kProximity):
            X_LG = X_LB @ inspector.GetPoseInFrame(geometry).GetAsMatrix4()
            p_GV = hull_vertices(inspector.GetShape(geometry))
            rows.append([k, *fitted_capsule(p_GV @ X_LG[:3, :3].T + X_LG[:3, 3])])
    capsules = read_arm_file(urdf).capsules
    try:
        return ArmChain(
            origins=np.array([step[:3, 3] for step in steps]),
            turns=np.array([step[:3, :3] for step in steps]),
            tip=np.linalg.solve(X_BL[-1], tip)[:3],
            low=np.array(plant.GetPositionLowerLimits()),
            high=np.array(plant.GetPositionUpperLimits()),
            speed=np.array(plant.GetVelocityUpperLimits()),
            capsules=np.array(rows if capsules is None else capsules).reshape(-1, 8),
        )
    except ValueError as error:
        raise ScenarioError(f"{urdf}: {error}") from error


def _joints(plant: MultibodyPlant, urdf: Path) -> list[RevoluteJoint]:
    """The seven, in their order from the base on."""
    every = [plant.get_joint(JointIndex(k)) for k in range(plant.num_joints())]
    joints = [joint for joint in every if joint.num_positions() > 0]
    turning = [joint for joint in joints if isinstance(joint, RevoluteJoint)]
    chain = [
        joint
        for joint, after in itertools.pairwise(turning)
        if after.parent_body().index() in _welded(plant, joint.child_body())
    ]
    if len(joints) != JOINTS or len(turning) != JOINTS or len(chain) != JOINTS - 1:
        raise ScenarioError(
            f"{urdf}: found {len(joints)} moving joints, {len(turning)} of them"
            f" revolute, allowed {JOINTS} revolute ones, each on the link of the last"
        )
    return turning


def _welded(plant: MultibodyPlant, body: RigidBody) -> set[BodyIndex]:
    return {b.index() for b in plant.GetBodiesWeldedTo(body)}


def _links(
    plant: MultibodyPlant, joints: list[RevoluteJoint]
) -> list[tuple[int, RigidBody]]:
    """Every body with its link's number: what is on link 7 besides it is the nozzle."""
    links = [(0, b) for b in plant.GetBodiesWeldedTo(plant.GetBodyByName(BASE_LINK))]
    links = [(k, body) for k, body in links if body.name() != "world"]
    for k, joint in enumerate(joints, start=1):
        child = joint.child_body()
        for body in plant.GetBodiesWeldedTo(child):
            beside = k == JOINTS and body.index() != child.index()
            links.append((NOZZLE if beside else k, body))
    return sorted(links, key=lambda link: link[0])


def _onto_z(axis: FloatArray) -> FloatArray:
    """A rotation (3, 3) whose z is the axis; none of an axis that is z."""
    if abs(axis[2] - 1.0) < 1e-12:
        return np.eye(3)
    x = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def fitted_capsule(points: FloatArray) -> FloatArray:
    """Returns a capsule (7,) around points (n, 3): two ends and a radius, m.

    Of those along a principal axis through the middle, the least in volume.
    """
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    _, _, axes = np.linalg.svd(points - points.mean(axis=0))
    best, least = np.zeros(7), np.inf
    for axis in np.vstack([axes, np.eye(3)]):
        along = (points - middle) @ axis
        across = points - middle - np.outer(along, axis)
        radius = float(np.linalg.norm(across, axis=1).max()) + 1e-6
        # As short as the two balls at its ends let it be.
        reach = np.sqrt(np.maximum(radius**2 - (across**2).sum(axis=1), 0.0))
        low, high = float((along + reach).min()), float((along - reach).max())
        if high - low < _SHORTEST:
            low, high = (0.5 * (low + high) + s * 0.5 * _SHORTEST for s in (-1, 1))
        volume = radius**2 * (high - low) + 4.0 / 3.0 * radius**3
        if volume < least:
            least = volume
            ends = middle + np.outer([low, high], axis)
            best = np.concatenate([ends.ravel(), [radius]])
    return best
