"""Which vertices are the back and the head, and the coloured parts of a person."""

import numpy as np
from numpy.typing import NDArray

from bath_drake.patient.people import LABEL_BACK, LABEL_HEAD, LABEL_OTHER, PARTS
from person_maker.makehuman import MakeHuman

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_TORSO = ("root", "spine", "clavicle", "breast", "shoulder", "pelvis")
_HIPS = ("pelvis.", "upperleg")
_UNDER_TRUNKS = ("root", "pelvis", "upperleg01")


def vertex_normals(vertices: Floats, triangles: Ints) -> Floats:
    """Unit normals (n, 3): those of the triangles around, by their angle there."""
    corners = vertices[triangles]
    edges = np.roll(corners, -1, axis=1) - corners
    faces = np.cross(edges[:, 0], edges[:, 1])
    faces /= np.maximum(np.linalg.norm(faces, axis=1, keepdims=True), 1e-30)
    out, back = edges, -np.roll(edges, 1, axis=1)
    lengths = np.linalg.norm(out, axis=2) * np.linalg.norm(back, axis=2)
    cosines = np.einsum("mki,mki->mk", out, back) / np.maximum(lengths, 1e-30)
    angles = np.arccos(np.clip(cosines, -1.0, 1.0))
    normals = np.zeros_like(vertices)
    np.add.at(normals, triangles, angles[..., None] * faces[:, None])
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)


def labels(human: MakeHuman, vertices: Floats, normals: Floats) -> Ints:
    """Labels (n,) by what a vertex follows: the back is the torso that faces +y."""
    # The rig lists the face after the jaw.
    face = human.names[human.names.index("jaw") :]
    head = _share(human, ("neck", "head", *face))
    back = (
        (_share(human, _TORSO) > 0.55)
        & (normals[:, 1] > 0.15)
        & (_share(human, _HIPS) < 0.35)
    )
    found = np.full(len(vertices), LABEL_OTHER)
    found[back] = LABEL_BACK
    found[head > 0.5] = LABEL_HEAD
    return found


def split(
    human: MakeHuman, vertices: Floats, normals: Floats, label: Ints
) -> dict[str, Ints]:
    """Triangles (m, 3) of each part: what is no back, hair or trunks is body."""
    triangles = human.triangles
    head = label == LABEL_HEAD
    low = np.percentile(vertices[head, 2], 35.0)
    hair = head & (normals[:, 1] > -0.15) & (vertices[:, 2] > low)
    trunks = _share(human, _UNDER_TRUNKS) > 0.45
    part = np.full(len(triangles), "body", dtype="U6")
    part[hair[triangles].all(axis=1)] = "hair"
    part[trunks[triangles].any(axis=1)] = "trunks"
    part[(label == LABEL_BACK)[triangles].all(axis=1)] = "back"
    return {name: triangles[part == name] for name in PARTS}


def _share(human: MakeHuman, prefixes: tuple[str, ...]) -> Floats:
    """How much of each vertex (n,) follows joints of such names."""
    chosen = [j for j, name in enumerate(human.names) if name.startswith(prefixes)]
    return human.weights[:, chosen].sum(axis=1)
