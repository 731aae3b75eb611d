"""Where a nozzle washed the true skin, which may have bent meanwhile."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from bath_drake.notation import BoolArray, FloatArray, IntArray
from bath_drake.patient.motion import MotionConfig, trunk_bend
from bath_drake.patient.people import LABEL_BACK, Person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin import TrueSkin

# Of a bending person only the skin around the back is looked at, for it has to be
# looked at anew at every sample: a nozzle that washes is nowhere near another, m.
_AROUND_BACK_M = 0.15


@dataclass(frozen=True, eq=False)
class WashedSkin:
    """What the nozzle did to the skin, at n times; metres, frame M.

    Attributes:
        distance: (n,) of the nozzle's tip from the nearest skin.
        normals: (n, 3) outward ones of that skin, as it was then.
        met: (n,) whether the jet met skin at all.
        resting: (m, 3) the skin it met, in the place which that skin has at rest.
        resting_normals: (m, 3) outward ones there.
    """

    distance: FloatArray
    normals: FloatArray
    met: BoolArray
    resting: FloatArray
    resting_normals: FloatArray


def washed_skin(
    skin: TrueSkin,
    motion: MotionConfig,
    time: FloatArray,
    tips_M: FloatArray,
    jets_M: FloatArray,
) -> WashedSkin:
    """Looks at the skin as it was when the nozzle was there.

    Args:
        skin: The person's, at rest.
        motion: How the person moved.
        time: (n,) s.
        tips_M: (n, 3) of the nozzle, m.
        jets_M: (n, 3) unit vectors along the jet.
    """
    if not motion.bends:
        distance, _, normals = skin.nearest(tips_M)
        hits, met = skin.hit(tips_M, jets_M)
        _, _, there = skin.nearest(hits[met])
        return WashedSkin(distance, normals, met, hits[met], there)
    person = skin.person
    bending, around = bending_skin(person), triangles_around_back(person)
    n = len(time)
    distance, normals = np.zeros(n), np.zeros((n, 3))
    met, resting = np.zeros(n, dtype=bool), np.zeros((n, 3))
    for k in range(n):
        now = TrueSkin(
            person, bending.points(trunk_bend(float(time[k]), motion)), around
        )
        one = slice(k, k + 1)
        distance[one], _, normals[one] = now.nearest(tips_M[one])
        corners, weights, met[one] = now.struck(tips_M[one], jets_M[one])
        resting[k] = weights[0] @ person.vertices[corners[0]]
    _, _, there = skin.nearest(resting[met])
    return WashedSkin(distance, normals, met, resting[met], there)


def triangles_around_back(person: Person) -> IntArray:
    """Returns the triangles (m, 3) of a person's mesh near the back."""
    back = cKDTree(person.vertices[person.labels == LABEL_BACK])
    near = back.query(person.vertices, distance_upper_bound=_AROUND_BACK_M)[0]
    chosen = np.isfinite(near)[person.triangles].any(axis=1)
    return np.asarray(person.triangles[chosen])
