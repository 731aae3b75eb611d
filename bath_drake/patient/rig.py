"""The rig of a person's folder: joints and weights, read strictly, made a bending skin.

Linear blend skinning (Magnenat-Thalmann et al., 1988): a vertex is the weighted mean
of where each of its joints takes it.
"""

from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.errors import ScenarioError
from bath_drake.notation import FloatArray, IntArray
from bath_drake.patient.arrays import read_arrays, take_array
from bath_drake.patient.bending import BendingSkin
from bath_drake.patient.people import Person
from bath_drake.patient.skin import TrueSkin

# The joints that bend, from the pelvis up.
SPINE = ("spine05", "spine04", "spine03", "spine02", "spine01")
# The chest: what swells with the breath. Weights fade where arms and neck begin.
CHEST = ("spine03", "spine02", "spine01", "breast.L", "breast.R")

# What the rig makes of the seated pose may differ from the mesh by this much, m.
_TOLERANCE_M = 1e-3

Arrays = dict[str, np.ndarray[Any, Any]]


def bending_skin(person: Person) -> BendingSkin:
    """Returns how the vertices of a person's mesh follow the spine.

    Raises:
        ScenarioError: If the person has no rig, or it is damaged or another's.
    """
    path = person.folder / "rig.npz"
    if not person.rigged:
        raise ScenarioError(f"{path}: missing; without a rig a person cannot bend")
    rig = read_arrays(path)
    weights, joints, names, parent = _checked(path, rig, len(person.vertices))
    seated = _seated_transforms(rig, parent)
    pivots = np.array([seated[0][names.index(joint)] for joint in SPINE])
    pivots += rig["offset"].astype(np.float64)
    bodies = np.array([_body_of(j, names, parent) for j in range(len(names))])
    transforms = seated[1][joints]
    rest = rig["rest"].astype(np.float64)
    placed = np.einsum("nkij,nj->nki", transforms[..., :3], rest) + transforms[..., 3]
    placed += rig["offset"].astype(np.float64)
    shares = np.zeros((len(rest), len(SPINE) + 1))
    moments = np.zeros((*shares.shape, 3))
    rows = np.broadcast_to(np.arange(len(rest))[:, None], joints.shape)
    np.add.at(shares, (rows, bodies[joints]), weights)
    np.add.at(moments, (rows, bodies[joints]), weights[..., None] * placed)
    error = np.linalg.norm(moments.sum(axis=1) - person.vertices, axis=1).max()
    if not error <= _TOLERANCE_M:
        raise ScenarioError(
            f"{path}: the seated pose is {1e3 * error:.1f} mm off mesh.npz, allowed "
            f"{1e3 * _TOLERANCE_M:.0f} mm; is it of another person?"
        )
    chest = np.isin(joints, [names.index(n) for n in CHEST if n in names])
    lifted = (weights * chest).sum(axis=1, keepdims=True)
    _, _, normals = TrueSkin(person).nearest(person.vertices)
    skin = BendingSkin(pivots, shares, moments, lifted * normals)
    # The rig is stored in half precision: at rest the mesh is the truth.
    return skin.resting_at(person.vertices)


def _checked(
    path: Path, rig: Arrays, count: int
) -> tuple[FloatArray, IntArray, list[str], IntArray]:
    """Weights (n, k), joints (n, k), names and parents (j,) of a sound rig."""
    names = [str(name) for name in take_array(path, rig, "names")]
    for joint in SPINE:
        if joint not in names:
            raise ScenarioError(f"{path}: names: joint {joint} is missing")
    j = len(names)
    per_vertex = take_array(path, rig, "weights").shape[1:]
    for key, shape, kinds in (
        ("rest", (count, 3), "f"),
        ("weights", (count, *per_vertex), "f"),
        ("joints", (count, *per_vertex), "iu"),
        ("joint_rest", (j, 4, 4), "f"),
        ("parent", (j,), "iu"),
        ("pose", (j, 3, 3), "f"),
        ("offset", (3,), "f"),
    ):
        array = take_array(path, rig, key)
        if array.shape != shape or array.dtype.kind not in kinds:
            raise ScenarioError(
                f"{path}: {key}: found {array.dtype} {array.shape}, expected {shape}"
            )
        if not np.isfinite(array).all():
            raise ScenarioError(f"{path}: {key}: is not finite everywhere")
    joints, parent = rig["joints"].astype(np.int64), rig["parent"].astype(np.int64)
    if joints.ndim != 2 or joints.min() < 0 or joints.max() >= j:
        raise ScenarioError(f"{path}: joints: allowed indices 0 to {j - 1}")
    if (parent >= np.arange(j)).any() or (parent < -1).any():
        raise ScenarioError(f"{path}: parent: a joint must come after its parent")
    weights = rig["weights"].astype(np.float64)
    sums = weights.sum(axis=1, keepdims=True)
    if weights.min() < 0.0 or sums.min() < 0.5:
        raise ScenarioError(f"{path}: weights: allowed >= 0, of sum 1 a vertex")
    return weights / sums, joints, names, parent


def _seated_transforms(rig: Arrays, parent: IntArray) -> tuple[FloatArray, FloatArray]:
    """Joints (j, 3) of the seated pose, and what takes rest there, (j, 3, 4)."""
    rest = rig["joint_rest"].astype(np.float64)
    pose = rig["pose"].astype(np.float64)
    placed = np.empty_like(rest)
    for j, above in enumerate(parent):
        local = rest[j] if above < 0 else np.linalg.solve(rest[above], rest[j])
        local[:3, :3] = local[:3, :3] @ pose[j]
        placed[j] = local if above < 0 else placed[above] @ local
    return placed[:, :3, 3], (placed @ np.linalg.inv(rest))[:, :3]


def _body_of(joint: int, names: list[str], parent: IntArray) -> int:
    """Which body a joint moves with: 0 the pelvis, then the spine from below."""
    while joint >= 0:
        if names[joint] in SPINE:
            return SPINE.index(names[joint]) + 1
        joint = int(parent[joint])
    return 0
