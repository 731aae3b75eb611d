"""The kinematics of an MMM model file (VirtualRobot XML, as Simox writes it).

Read are RobotNode with Transform (Translation, RollPitchYaw, Matrix4x4, as they follow
one another), revolute and prismatic Joint with Axis or TranslationDirection and offset,
and Child. Lengths are in mm unless a unit is told; the case of tags and attributes does
not matter. MMM's reference model is of a subject of 1 m: lengths, not what joints
slide, are multiplied by the subject's height. Nodes in other files (ChildFromRobot) are
refused.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.demonstrations.importing.xml_file import attribute, read_xml
from bath_drake.errors import DemonstrationError
from bath_drake.notation import FloatArray

_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_ANGLES = {"radian": 1.0, "rad": 1.0, "degree": np.pi / 180.0, "deg": np.pi / 180.0}
_MOST_NODES = 2000
# A model taller than this (root to the farthest node) is of a person, not of 1 m.
_NORMALISED_REACH = 1.2


@dataclass(frozen=True, eq=False)
class _Node:
    """A node: where it is on its parent, and how it turns or slides.

    Attributes:
        parent: Its name; empty for the root.
        X: (4, 4) of the node in its parent, lengths in m.
        joint: 'revolute', 'prismatic' or 'fixed'.
        axis: (3,) of the joint.
        offset: Added to the joint's value, rad or mm.
    """

    parent: str
    X: FloatArray
    joint: str
    axis: FloatArray
    offset: float


@dataclass(frozen=True, eq=False)
class MmmModel:
    """A tree of nodes.

    Attributes:
        nodes: By name, each after its parent.
    """

    nodes: Mapping[str, _Node]

    @property
    def names(self) -> tuple[str, ...]:
        """Of all nodes."""
        return tuple(self.nodes)

    @property
    def is_normalised(self) -> bool:
        """Whether it is of a subject of 1 m height."""
        reach = 0.0
        for name in self.nodes:
            reach = max(reach, sum(self._length(node) for node in self.way_to(name)))
        return reach < _NORMALISED_REACH

    def way_to(self, name: str) -> list[str]:
        """Names of the nodes from the root to one, both included."""
        way = [name]
        while parent := self.nodes[way[-1]].parent:
            way.append(parent)
        return way[::-1]

    def joints_to(self, name: str) -> list[str]:
        """Names of the joints that move a node."""
        return [n for n in self.way_to(name) if self.nodes[n].joint != "fixed"]

    def position(
        self,
        name: str,
        values: Mapping[str, FloatArray],
        count: int,
        scale: float = 1.0,
    ) -> FloatArray:
        """Positions (count, 3) of a node in the root's frame, m.

        Args:
            name: Of the node.
            values: (count,) rad of each joint on the way, mm of sliding ones.
            count: Of frames.
            scale: Of the model's lengths.
        """
        R = np.tile(np.eye(3), (count, 1, 1))
        p = np.zeros((count, 3))
        for step in self.way_to(name):
            node = self.nodes[step]
            p = p + R @ (scale * node.X[:3, 3])
            R = R @ node.X[:3, :3]
            if node.joint == "fixed":
                continue
            value = values[step] + node.offset
            if node.joint == "revolute":
                R = R @ _turned(node.axis, value)
            else:
                p = p + (R @ node.axis) * _LENGTHS["mm"] * value[:, None]
        return p

    def _length(self, name: str) -> float:
        return float(np.linalg.norm(self.nodes[name].X[:3, 3]))


def read_model(path: Path) -> MmmModel:
    """Reads a model file; raises DemonstrationError naming file and node."""
    robot = read_xml(path)
    for element in robot.iter():
        element.tag = element.tag.lower()
        own = {key.lower(): value for key, value in element.attrib.items()}
        element.attrib.clear()
        element.attrib.update(own)
    _refuse_other_files(path, robot)
    found = robot.findall("robotnode")
    elements = {e.get("name", ""): e for e in found}
    if len(elements) < len(found):
        raise DemonstrationError(f"{path}: has two RobotNodes of one name")
    if not 1 <= len(elements) <= _MOST_NODES:
        raise DemonstrationError(
            f"{path}: found {len(elements)} RobotNodes, allowed: 1 to {_MOST_NODES}"
        )
    children = {
        name: [child.get("name", "") for child in element.findall("child")]
        for name, element in elements.items()
    }
    root = robot.get("rootnode") or next(iter(elements))
    if root not in elements:
        raise DemonstrationError(f"{path}: RootNode: found no node {root!r}")
    nodes: dict[str, _Node] = {}
    waiting = [(root, "")]
    while waiting:
        name, parent = waiting.pop()
        if name in nodes:
            raise DemonstrationError(f"{path}: node {name!r} has two parents or a loop")
        if name not in elements:
            raise DemonstrationError(f"{path}: node {parent!r}: no child {name!r}")
        nodes[name] = _node(path, elements[name], parent)
        waiting += [(child, name) for child in children[name]]
    return MmmModel(nodes)


def _refuse_other_files(path: Path, robot: Any) -> None:
    """Where nodes or lengths come from elsewhere, this file alone would mislead."""
    for tag in ("childfromrobot", "prejointtransform", "postjointtransform"):
        if next(robot.iter(tag), None) is not None:
            raise DemonstrationError(f"{path}: found {tag}, which is not supported")


def rotation_rpy(rpy: FloatArray) -> FloatArray:
    """Rotations (n, 3, 3) of roll, pitch, yaw (n, 3), rad: Rz Ry Rx."""
    x, y, z = np.eye(3)
    roll, pitch, yaw = rpy.T
    return np.asarray(_turned(z, yaw) @ _turned(y, pitch) @ _turned(x, roll))


def _node(path: Path, element: Any, parent: str) -> _Node:
    joint, axis, offset = "fixed", np.array([0.0, 0.0, 1.0]), 0.0
    told = element.find("joint")
    if told is not None:
        joint = str(told.get("type", "fixed")).lower()
        if joint not in ("revolute", "prismatic", "fixed"):
            raise DemonstrationError(
                f"{path}: node {element.get('name')!r}: found a joint of type "
                f"{joint!r}, allowed: revolute, prismatic, fixed"
            )
        offset = attribute(path, told, "offset", 0.0)
        where = told.find("translationdirection" if joint == "prismatic" else "axis")
        if where is not None:
            axis = np.array([attribute(path, where, k, 0.0) for k in "xyz"])
            size = float(np.linalg.norm(axis))
            if size == 0.0:
                raise DemonstrationError(
                    f"{path}: node {element.get('name')!r}: the joint's axis is zero"
                )
            axis = axis / size
    X = _transform(path, element.find("transform"))
    return _Node(parent, X, joint, axis, offset)


def _transform(path: Path, element: Any) -> FloatArray:
    X = np.eye(4)
    if element is None:
        return X
    for part in element:
        kind = part.tag.lower()
        if kind == "translation":
            unit = _unit(path, part, ("unitslength", "units", "unit"), _LENGTHS, "mm")
            step = np.eye(4)
            step[:3, 3] = [unit * attribute(path, part, k, 0.0) for k in "xyz"]
        elif kind == "rollpitchyaw":
            unit = _unit(path, part, ("unitsangle", "units", "unit"), _ANGLES, "radian")
            rpy = [
                unit * attribute(path, part, k, 0.0) for k in ("roll", "pitch", "yaw")
            ]
            step = np.eye(4)
            step[:3, :3] = rotation_rpy(np.array([rpy]))[0]
        elif kind == "matrix4x4":
            unit = _unit(path, part, ("unitslength", "units", "unit"), _LENGTHS, "mm")
            step = np.eye(4)
            for i in range(3):
                row = part.find(f"row{i + 1}")
                if row is None:
                    raise DemonstrationError(f"{path}: Matrix4x4: has no row{i + 1}")
                step[i] = [attribute(path, row, f"c{j + 1}", 0.0) for j in range(4)]
            step[:3, 3] *= unit
        else:
            raise DemonstrationError(
                f"{path}: Transform: found {part.tag!r}, allowed: Translation, "
                "RollPitchYaw, Matrix4x4"
            )
        X = X @ step
    return X


def _unit(
    path: Path,
    element: Any,
    names: tuple[str, ...],
    known: Mapping[str, float],
    default: str,
) -> float:
    told = next((element.get(name) for name in names if element.get(name)), default)
    if told not in known:
        raise DemonstrationError(
            f"{path}: {element.tag}: found the unit {told!r}, allowed: "
            f"{', '.join(known)}"
        )
    return known[told]


def _turned(axis: FloatArray, angles: FloatArray) -> FloatArray:
    """Rotations (n, 3, 3) about a unit axis by angles (n,) (Rodrigues)."""
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sin, cos = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.asarray(np.eye(3) + sin * K + (1.0 - cos) * (K @ K))
