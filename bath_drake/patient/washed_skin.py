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

# Skin slower than this (rms, m/s) is no measure of how it is followed.
_TELLING_SPEED = 2e-3


@dataclass(frozen=True, eq=False)
class WashedSkin:
    """What the nozzle did to the skin, at n times; metres, frame M.

    Attributes:
        distance: (n,) of the nozzle's tip from the nearest skin.
        normals: (n, 3) outward ones of that skin, as it was then.
        met: (n,) whether the jet met skin at all.
        resting: (m, 3) the skin it met, in the place which that skin has at rest.
        resting_normals: (m, 3) outward ones there.
        receded: (n,) how far the skin has gone away from where the nozzle was at the
            time before, since then; zero at the first.
    """

    distance: FloatArray
    normals: FloatArray
    met: BoolArray
    resting: FloatArray
    resting_normals: FloatArray
    receded: FloatArray


def washed_skin(
    skin: TrueSkin,
    motion: MotionConfig,
    time: FloatArray,
    tips_M: FloatArray,
    jets_M: FloatArray,
    tips_before_M: FloatArray | None = None,
) -> WashedSkin:
    """Looks at the skin as it was when the nozzle was there.

    Args:
        skin: The person's, at rest.
        motion: How the person moved.
        time: (n,) s.
        tips_M: (n, 3) of the nozzle, m.
        jets_M: (n, 3) unit vectors along the jet.
        tips_before_M: (n, 3) where in M of each time the nozzle's place of the time
            before is, m, the first of no meaning; None if M stood still.
    """
    if tips_before_M is None:
        tips_before_M = np.concatenate([tips_M[:1], tips_M[:-1]])
    if not motion.bends:
        distance, _, normals = skin.nearest(tips_M)
        hits, met = skin.hit(tips_M, jets_M)
        _, _, there = skin.nearest(hits[met])
        receded = _receded(skin.nearest(tips_before_M)[0], distance)
        return WashedSkin(distance, normals, met, hits[met], there, receded)
    person = skin.person
    bending, around = bending_skin(person), triangles_around_back(person)
    n = len(time)
    distance, normals, before = np.zeros(n), np.zeros((n, 3)), np.zeros(n)
    met, resting = np.zeros(n, dtype=bool), np.zeros((n, 3))
    for k in range(n):
        now = TrueSkin(
            person, bending.points(trunk_bend(float(time[k]), motion)), around
        )
        one = slice(k, k + 1)
        distance[one], _, normals[one] = now.nearest(tips_M[one])
        before[one] = now.nearest(tips_before_M[one])[0]
        corners, weights, met[one] = now.struck(tips_M[one], jets_M[one])
        resting[k] = weights[0] @ person.vertices[corners[0]]
    _, _, there = skin.nearest(resting[met])
    receded = _receded(before, distance)
    return WashedSkin(distance, normals, met, resting[met], there, receded)


def _receded(before: FloatArray, distance: FloatArray) -> FloatArray:
    return np.append(np.zeros(min(len(distance), 1)), before[1:] - distance[:-1])


def tracking_lag(
    error: FloatArray, receded: FloatArray, time: FloatArray
) -> float | None:
    """Returns how late a nozzle follows skin that comes and goes, s.

    Skin that recedes is left behind by its speed times the lag: the lag is the slope of
    the one over the other.

    Args:
        error: (n,) distance from the skin, less what was asked for, m.
        receded: (n,) of `WashedSkin`, m.
        time: (n,) s, rising.

    Returns:
        The lag; None where the skin moved too little to tell, less than 2 mm/s.
    """
    if len(time) < 3:
        return None
    speed = receded[1:] / np.diff(time)
    speed = speed - speed.mean()
    if not np.sqrt(np.mean(speed**2)) > _TELLING_SPEED:
        return None
    return float(speed @ (error[1:] - error[1:].mean()) / (speed @ speed))


def triangles_around_back(person: Person) -> IntArray:
    """Returns the triangles (m, 3) of a person's mesh near the back."""
    back = cKDTree(person.vertices[person.labels == LABEL_BACK])
    near = back.query(person.vertices, distance_upper_bound=_AROUND_BACK_M)[0]
    chosen = np.isfinite(near)[person.triangles].any(axis=1)
    return np.asarray(person.triangles[chosen])
