"""Where a nozzle washed the true skin, which may have bent meanwhile."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.spatial import cKDTree

from bath_drake.notation import BoolArray, FloatArray, IntArray
from bath_drake.patient.motion import MotionConfig, trunk_bend
from bath_drake.patient.people import LABEL_BACK, Person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin import TrueSkin

# Of a bending person only the skin around the back is looked at, for it has to be
# looked at anew at every sample: a nozzle that washes is nowhere near another, m.
_AROUND_BACK_M = 0.15
# And of that, first the skin around the nozzle alone; m.
_AROUND_NOZZLE_M = 0.2

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
        bent = bending.points(trunk_bend(float(time[k]), motion))
        ends = np.stack([tips_M[k], tips_before_M[k]])
        # To look at a skin once costs as much as it has triangles.
        near = TrueSkin(
            person, bent, _triangles_near(bent, around, ends[0], _AROUND_NOZZLE_M)
        )
        look = _look(near, ends, jets_M[k])
        if not look.farthest <= 0.5 * _AROUND_NOZZLE_M:
            look = _look(TrueSkin(person, bent, around), ends, jets_M[k])
        (distance[k], before[k]), normals[k] = look.distances, look.normal
        met[k] = look.met
        resting[k] = look.weights @ person.vertices[look.corners]
    _, _, there = skin.nearest(resting[met])
    receded = _receded(before, distance)
    return WashedSkin(distance, normals, met, resting[met], there, receded)


@dataclass(frozen=True, eq=False)
class _Look:
    """What is found at one time: from the nozzle's tip and where it was before.

    Attributes:
        distances: (2,) of both from the nearest skin, m.
        normal: (3,) of the skin nearest to the tip.
        corners, weights: (3,) of the skin that the jet met.
        met: Whether it met any.
        farthest: How far off all of that is, m; not finite where the jet met nothing.
    """

    distances: FloatArray
    normal: FloatArray
    corners: IntArray
    weights: FloatArray
    met: bool
    farthest: float


def _look(skin: TrueSkin, ends_M: FloatArray, jet_M: FloatArray) -> _Look:
    """Looks from the tip and where it was before (2, 3), and along the jet (3,)."""
    tip, along = ends_M[:1], jet_M[None]
    distances, points, normals = skin.nearest(ends_M)
    corners, weights, met = skin.struck(tip, along)
    hit = weights[0] @ skin.vertices[corners[0]] if met[0] else np.full(3, np.inf)
    away = np.linalg.norm(np.vstack([points, hit]) - tip, axis=1)
    return _Look(
        distances, normals[0], corners[0], weights[0], bool(met[0]), float(away.max())
    )


@njit(cache=True)
def _triangles_near(
    vertices: FloatArray, triangles: IntArray, p_MQ: FloatArray, reach: float
) -> IntArray:
    """Returns the triangles (k, 3) with a corner near a point (3,), or all of them."""
    chosen = np.zeros(len(triangles), dtype=np.bool_)
    for i in range(len(triangles)):
        for corner in range(3):
            squared = 0.0
            for axis in range(3):
                away = vertices[triangles[i, corner], axis] - p_MQ[axis]
                squared += away * away
            if squared <= reach * reach:
                chosen[i] = True
                break
    return triangles[chosen] if chosen.any() else triangles


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
