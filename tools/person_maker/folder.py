"""Seats a recipe's person and writes the folder."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from convert_people import decimate
from numpy.typing import NDArray

from bath_drake.patient.gltf import Part, gltf_text
from bath_drake.patient.people import LABEL_BACK, LABEL_HEAD, LABEL_OTHER
from person_maker.makehuman import Body, MakeHuman
from person_maker.parts import labels, split, vertex_normals
from person_maker.recipes import Recipe
from person_maker.seating import joint_pose, seated_turns, skinned

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# So many joints a vertex keep the seated skin within 0.3 mm of that of all.
_JOINTS_KEPT = 8
_SKIN_DENSITY = 1010.0  # kg/m^3 of a whole body
_TRIANGLES_FOR_CAMERA = 4000


@dataclass(frozen=True, eq=False)
class Seated:
    """A person who sits, ready to be written.

    Attributes:
        body: The same person, standing.
        pose: (j, 3, 3) each joint's turn in its own rest frame.
        offset: (3,) from where skinning puts the seated person to frame M, m.
        vertices: (n, 3) in M, m.
        normals: (n, 3) unit.
        labels: (n,) as `bath_drake.patient.people` has them.
        parts: Triangles (m, 3) of each part.
    """

    body: Body
    pose: Floats
    offset: Floats
    vertices: Floats
    normals: Floats
    labels: Ints
    parts: dict[str, Ints]


def seat(human: MakeHuman, recipe: Recipe) -> Seated:
    """Returns a recipe's person, seated: feet at z = 0, the back's crest at y = 0."""
    body = human.body(recipe.phenotype)
    pose = joint_pose(human, body, seated_turns())
    vertices = skinned(human, body, pose)
    normals = vertex_normals(vertices, human.triangles)
    label = labels(human, vertices, normals)
    back = vertices[label == LABEL_BACK]
    offset = -np.array([back[:, 0].mean(), back[:, 1].max(), vertices[:, 2].min()])
    parts = split(human, vertices, normals, label)
    # The label is that of the part: the back ends where the trunks' edge is.
    marks = np.where(label == LABEL_HEAD, LABEL_HEAD, LABEL_OTHER)
    marks[np.unique(parts["back"])] = LABEL_BACK
    return Seated(body, pose, offset, vertices + offset, normals, marks, parts)


def write_folder(human: MakeHuman, recipe: Recipe, folder: Path) -> Seated:
    """Makes a recipe's person and writes all files of its folder."""
    folder.mkdir(parents=True)
    seated = seat(human, recipe)
    for name, triangles in seated.parts.items():
        used, numbered = np.unique(triangles, return_inverse=True)
        colour = {"hair": recipe.hair, "trunks": recipe.trunks}.get(name, recipe.skin)
        part = Part(
            seated.vertices[used],
            numbered.reshape(-1, 3),
            np.array([*colour, 255]) / 255.0,
        )
        text = gltf_text(part, seated.normals[used])
        (folder / f"{name}.gltf").write_text(text + "\n")
    np.savez_compressed(
        folder / "mesh.npz",
        V=seated.vertices.astype(np.float32),
        F=human.triangles.astype(np.int32),
        label=seated.labels.astype(np.uint8),
    )
    np.savez_compressed(folder / "rig.npz", **_rig(human, seated))
    tall, heavy = measures(human, seated.body)
    (folder / "person.yaml").write_text(
        f"name: {recipe.name}\n"
        f"stature: {round(tall, 3)}  # m; body mass index {heavy:.1f}\n"
        "licence: CC0-1.0\n"
    )
    decimate(folder, _TRIANGLES_FOR_CAMERA)
    return seated


def _rig(human: MakeHuman, seated: Seated) -> dict[str, np.ndarray]:
    joints = np.argsort(-human.weights, axis=1, kind="stable")[:, :_JOINTS_KEPT]
    weights = np.take_along_axis(human.weights, joints, axis=1)
    weights /= weights.sum(axis=1, keepdims=True)
    dense = np.zeros_like(human.weights)
    np.put_along_axis(dense, joints, weights, axis=1)
    kept = skinned(human, seated.body, seated.pose, dense)
    return {
        "rest": seated.body.vertices.astype(np.float32),
        "weights": weights.astype(np.float16),
        "joints": joints.astype(np.uint8),
        "joint_rest": seated.body.joints.astype(np.float32),
        "parent": human.parents.astype(np.int16),
        "names": np.array(human.names),
        "pose": seated.pose.astype(np.float32),
        "offset": (seated.vertices - kept).mean(axis=0).astype(np.float32),
    }


def measures(human: MakeHuman, body: Body) -> tuple[float, float]:
    """Stature, m, and body mass index, kg/m^2, of a standing body."""
    a, b, c = np.moveaxis(body.vertices[human.triangles], 1, 0)
    volume = np.einsum("ni,ni->", a, np.cross(b, c)) / 6.0
    stature = float(np.ptp(body.vertices[:, 2]))
    return stature, float(volume * _SKIN_DENSITY / stature**2)
