"""The parts of a person whose skin bends: what is drawn of each, and how it moves."""

from dataclasses import dataclass

import numpy as np

from bath_drake.notation import FloatArray, IntArray
from bath_drake.patient.bending import BendingSkin
from bath_drake.patient.gltf import read_part
from bath_drake.patient.people import PARTS, Person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.shell import THICKNESS_M, foldable, with_inside
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.wound import WoundPatch


@dataclass(frozen=True, eq=False)
class SkinPart:
    """One coloured part of a bending skin.

    Attributes:
        name: As in `bath_drake.patient.people.PARTS`, or `wound`.
        shell: How its vertices move: the outside's, then those just below.
        triangles: (m, 3) of the outside.
        rgba: (4,) 0 to 1.
    """

    name: str
    shell: BendingSkin
    triangles: IntArray
    rgba: FloatArray


def skin_parts(person: Person, wound: WoundPatch | None) -> tuple[SkinPart, ...]:
    """Returns a person's parts, those for the camera, and a wound if there is one.

    Raises:
        ScenarioError: If the person has no rig, or a part or the rig is damaged.
    """
    skin, bending = TrueSkin(person), bending_skin(person)
    parts = []
    for name in PARTS:
        part = read_part(person.part_path(name, for_camera=True))
        vertices, triangles = foldable(part.vertices, part.triangles)
        shell = follow(bending, skin, with_inside(vertices, triangles))
        parts.append(SkinPart(name, shell, triangles, part.rgba))
    if wound is not None:
        below = wound.vertices - THICKNESS_M * wound.normals
        shell = follow(bending, skin, np.vstack([wound.vertices, below]))
        parts.append(
            SkinPart("wound", shell, wound.triangles, np.append(wound.colour, 1.0))
        )
    return tuple(parts)


def follow(bending: BendingSkin, skin: TrueSkin, p_M: FloatArray) -> BendingSkin:
    """Returns how points (n, 3) on or near a skin at rest move with it."""
    return bending.follower(*skin.bind(p_M)).resting_at(p_M)
