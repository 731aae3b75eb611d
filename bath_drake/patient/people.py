"""A person's folder, read strictly: parts to show, the true mesh, who it is."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.errors import ScenarioError
from bath_drake.notation import FloatArray, IntArray
from bath_drake.patient.arrays import read_arrays, take_array
from bath_drake.patient.gltf import FURTHEST_M
from bath_drake.resources import models_folder
from bath_drake.yaml_block import Block
from bath_drake.yaml_io import read_yaml

PARTS = ("body", "back", "hair", "trunks")
LABEL_OTHER, LABEL_BACK, LABEL_HEAD = 0, 1, 2

_STATURES_M = (0.4, 2.8)
# The sitting area: how far in front of the back it may lie and how wide it is.
_SEAT_DEPTH_M, _SEAT_HALF_WIDTH_M = 0.25, 0.2
# Ischial tuberosities to hip joint centres, seated adults: the lean's axis.
_HIPS_ABOVE_SEAT_M = 0.09


@dataclass(frozen=True, eq=False)
class Person:
    """A seated person in frame M: metres, z up, the back faces +y.

    Attributes:
        folder: Where it was read from.
        name: Who it is.
        stature: Height when standing, m.
        licence: Licence of the model.
        vertices: (n, 3) vertices of the true mesh in M, m, read-only.
        triangles: (m, 3) vertex indices, counter-clockwise from outside.
        labels: (n,) LABEL_OTHER, LABEL_BACK or LABEL_HEAD a vertex.
        rigged: Whether rig.npz lies there, so that the person could bend.
    """

    folder: Path
    name: str
    stature: float
    licence: str
    vertices: FloatArray
    triangles: IntArray
    labels: IntArray
    rigged: bool

    def part_path(self, part: str, *, for_camera: bool = False) -> Path:
        """Returns a part's glTF; the camera's, decimated one where it exists."""
        low = self.folder / f"{part}_low.gltf"
        if for_camera and low.is_file():
            return low
        return self.folder / f"{part}.gltf"

    @cached_property
    def back_extents(self) -> tuple[FloatArray, FloatArray]:
        """1 % and 99 % quantiles (3,) in M of the back's vertices, m."""
        low, high = np.percentile(
            self.vertices[self.labels == LABEL_BACK], [1.0, 99.0], axis=0
        )
        return low, high

    @cached_property
    def seat(self) -> FloatArray:
        """The point (3,) in M where the person touches the stool, m."""
        v = self.vertices
        back = v[self.labels == LABEL_BACK]
        under = (
            (self.labels != LABEL_BACK)
            & (v[:, 1] > back[:, 1].max() - _SEAT_DEPTH_M)
            & (np.abs(v[:, 0] - back[:, 0].mean()) < _SEAT_HALF_WIDTH_M)
        )
        if not under.any():
            under = self.labels != LABEL_BACK
        lowest = v[under][np.argmin(v[under][:, 2])]
        return np.array([back[:, 0].mean(), lowest[1], lowest[2]])

    @cached_property
    def hips(self) -> FloatArray:
        """Middle (3,) in M of the line through both hip joints, m."""
        hips: FloatArray = self.seat + np.array([0.0, 0.0, _HIPS_ABOVE_SEAT_M])
        return hips

    @cached_property
    def back_normal(self) -> FloatArray:
        """Unit normal (3,) in M of the back's plane, out of the body."""
        back = self.vertices[self.labels == LABEL_BACK]
        _, _, axes = np.linalg.svd(back - back.mean(axis=0), full_matrices=False)
        normal: FloatArray = axes[2] * (1.0 if axes[2][1] > 0.0 else -1.0)
        return normal


def shipped_people() -> tuple[str, ...]:
    """Returns the names of the people in models/people, in alphabetical order."""
    folders = (models_folder() / "people").iterdir()
    return tuple(sorted(p.name for p in folders if (p / "person.yaml").is_file()))


def find_person(name: str | Path) -> Path:
    """Returns a person's folder: a path, or the name of a shipped one.

    Raises:
        ScenarioError: If there is neither such a folder nor such a name.
    """
    path = Path(name)
    if path.is_dir():
        return path
    if str(name) in shipped_people():
        return models_folder() / "people" / path
    raise ScenarioError(
        f"person {str(name)!r}: no such folder; shipped ones: "
        f"{', '.join(shipped_people())}"
    )


def load_person(folder: str | Path) -> Person:
    """Reads a person's folder.

    Args:
        folder: Holds body.gltf, back.gltf, hair.gltf, trunks.gltf, mesh.npz and
            person.yaml; body_low.gltf (for the camera) and rig.npz are optional.

    Raises:
        ScenarioError: If a file is missing or damaged; names file and key.
    """
    folder = find_person(folder)
    for part in PARTS:
        path = folder / f"{part}.gltf"
        if not path.is_file():
            raise ScenarioError(f"{path}: missing; a person needs this part")
    path = folder / "person.yaml"
    block = Block(read_yaml(path, error=ScenarioError), str(path), error=ScenarioError)
    name, licence = block.take("name", str), block.take("licence", str)
    stature = block.take("stature", float)
    if not _STATURES_M[0] <= stature <= _STATURES_M[1]:
        low, high = _STATURES_M
        block.fail("stature", f"found {stature}, allowed {low} to {high} m")
    block.finish()
    mesh = folder / "mesh.npz"
    arrays = read_arrays(mesh)
    vertices, triangles, labels = (
        take_array(mesh, arrays, k) for k in ("V", "F", "label")
    )
    _check_mesh(mesh, vertices, triangles, labels)
    arrays_of_person = (
        vertices.astype(np.float64),
        triangles.astype(np.int64),
        labels.astype(np.int64),
    )
    for array in arrays_of_person:
        array.setflags(write=False)
    rigged = (folder / "rig.npz").is_file()
    return Person(folder, name, stature, licence, *arrays_of_person, rigged)


def _check_mesh(
    path: Path,
    vertices: np.ndarray[Any, Any],
    triangles: np.ndarray[Any, Any],
    labels: np.ndarray[Any, Any],
) -> None:
    n = len(vertices) if vertices.ndim else 0
    if vertices.ndim != 2 or vertices.shape[1] != 3 or vertices.dtype.kind != "f":
        raise ScenarioError(
            f"{path}: V: found {vertices.dtype} {vertices.shape}, expected float (n, 3)"
        )
    if not np.isfinite(vertices).all():
        row = int(np.argmax(~np.isfinite(vertices).all(axis=1)))
        raise ScenarioError(f"{path}: V: row {row} is not finite")
    if np.abs(vertices).max(initial=0.0) > FURTHEST_M:
        row = int(np.argmax(np.abs(vertices).max(axis=1)))
        raise ScenarioError(
            f"{path}: V: row {row}: found {vertices[row].tolist()}, allowed within "
            f"{FURTHEST_M:g} m of the origin"
        )
    if (
        triangles.ndim != 2
        or triangles.shape[1] != 3
        or triangles.dtype.kind not in "iu"
    ):
        raise ScenarioError(
            f"{path}: F: found {triangles.dtype} {triangles.shape},"
            " expected integer (m, 3)"
        )
    if len(triangles) == 0 or triangles.min() < 0 or triangles.max() >= n:
        bad = (triangles < 0) | (triangles >= n)
        row = int(np.argmax(bad.any(axis=1))) if len(triangles) else 0
        found = triangles[row].tolist() if len(triangles) else "no triangle"
        raise ScenarioError(
            f"{path}: F: row {row}: found {found}, allowed indices 0 to {n - 1}"
        )
    if labels.shape != (n,) or labels.dtype.kind not in "iu":
        raise ScenarioError(
            f"{path}: label: found {labels.dtype} {labels.shape},"
            f" expected integer ({n},)"
        )
    if not np.isin(labels, (LABEL_OTHER, LABEL_BACK, LABEL_HEAD)).all():
        raise ScenarioError(f"{path}: label: allowed are 0 other, 1 back, 2 head")
    if np.count_nonzero(labels == LABEL_BACK) < 100:
        raise ScenarioError(
            f"{path}: label: found {np.count_nonzero(labels == LABEL_BACK)} vertices"
            " of the back (1), expected 100 or more"
        )
