"""In what two folders of one person differ: contents are compared, not bytes."""

from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from bath_drake.patient.arrays import read_arrays
from bath_drake.patient.gltf import Part, read_part
from bath_drake.patient.people import PARTS

# Numbers are rounded to float32 (1e-7 of a metre), the first people's also between.
_SAME_M = 1e-5
# Directions of a bone a centimetre long, from such positions.
_SAME_FRAME = 2e-4
# A ninth joint as heavy as the eighth may be the one that is kept.
_SAME_WEIGHT = 0.02
# Decimation turns on the last bit: so large a share may fall otherwise.
_SAME_COUNT, _SAME_LOW = 0.01, 0.05

Arrays = dict[str, np.ndarray]


def differences(made: Path, shipped: Path) -> list[str]:
    """Returns in words in what two folders differ; nothing if they are alike.

    Raises:
        ScenarioError: If a file is missing or damaged.
    """
    found = []
    if (made / "person.yaml").read_text() != (shipped / "person.yaml").read_text():
        found.append("person.yaml: another text")
    for file in ("mesh.npz", "rig.npz"):
        one, other = read_arrays(made / file), read_arrays(shipped / file)
        if one.keys() != other.keys():
            found.append(f"{file}: {sorted(one)} instead of {sorted(other)}")
            continue
        if file == "rig.npz":
            one, other = _with_dense_weights(one), _with_dense_weights(other)
        for key in one:
            allowed = {"weights": _SAME_WEIGHT, "joint_rest": _SAME_FRAME}
            found += _difference(
                f"{file}: {key}", one[key], other[key], allowed.get(key, _SAME_M)
            )
    for name in PARTS:
        one, other = (read_part(f / f"{name}.gltf") for f in (made, shipped))
        found += _part_difference(f"{name}.gltf", one, other)
    one, other = (read_part(f / "body_low.gltf") for f in (made, shipped))
    return found + _low_difference("body_low.gltf", one, other)


def _with_dense_weights(rig: Arrays) -> Arrays:
    """The rig with weights (n, j): where they are 0 any joint may stand."""
    dense = np.zeros((len(rig["weights"]), len(rig["names"])))
    rows = np.arange(len(dense))[:, None]
    np.add.at(dense, (rows, rig["joints"]), rig["weights"].astype(np.float64))
    others = {k: v for k, v in rig.items() if k not in ("weights", "joints")}
    return others | {"weights": dense}


def _part_difference(name: str, one: Part, other: Part) -> list[str]:
    return [
        *_difference(f"{name}: colour", one.rgba, other.rgba),
        *_difference(f"{name}: triangles", one.triangles, other.triangles),
        *_difference(f"{name}: vertices", one.vertices, other.vertices),
    ]


def _low_difference(name: str, one: Part, other: Part) -> list[str]:
    found = _difference(f"{name}: colour", one.rgba, other.rgba)
    a, b = len(one.triangles), len(other.triangles)
    if abs(a - b) > _SAME_COUNT * b:
        found.append(f"{name}: {a} triangles instead of {b}")
    apart, _ = cKDTree(other.vertices).query(one.vertices)
    alone = float(np.mean(apart > _SAME_M))
    if alone > _SAME_LOW:
        found.append(f"{name}: {100 * alone:.1f} % of the vertices have no twin")
    return found


def _difference(
    name: str, one: np.ndarray, other: np.ndarray, allowed: float = _SAME_M
) -> list[str]:
    if one.shape != other.shape:
        return [f"{name}: shape {one.shape} instead of {other.shape}"]
    if one.dtype.kind != "f":
        different = np.count_nonzero(one != other)
        return [f"{name}: {different} entries differ"] if different else []
    gap = float(np.abs(one.astype(np.float64) - other).max())
    return [f"{name}: {gap:.2g} apart, allowed {allowed:.2g}"] if gap > allowed else []
