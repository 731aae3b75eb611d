"""How far the skin that is touched lies from the true one, under the tool."""

import numpy as np

from bath_drake.notation import FloatArray
from bath_drake.patient.motion import MotionConfig, trunk_bend
from bath_drake.patient.people import Person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.segment_motion import SegmentedSkin
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.washed_skin import triangles_around_back

# m, about where the tool's axis meets the skin: as wide as the sponge.
UNDER_TOOL = 0.03


def touched_skin_error(
    person: Person,
    skin: SegmentedSkin,
    motion: MotionConfig,
    time: FloatArray,
    tips_M: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Returns mean and greatest distance (n,), m, of touched from true skin.

    Over the nodes and the triangles' middles of the slabs that lie within
    `UNDER_TOOL` of the place nearest to the tool's tip.

    Args:
        person: Whose skin.
        skin: The slabs, as they are touched.
        motion: How the trunk bends.
        time: (n,) s.
        tips_M: (n, 3) where the tool is, in M, m.

    Returns:
        Both NaN where there is no slab under the tool.
    """
    bending = bending_skin(person) if motion.bends else None
    around = triangles_around_back(person)
    mean, most = np.full(len(time), np.nan), np.full(len(time), np.nan)
    true = TrueSkin(person)
    for k, t in enumerate(time):
        bend = trunk_bend(float(t), motion)
        if bending is not None:
            true = TrueSkin(person, bending.points(bend), around)
        _, place, _ = true.nearest(tips_M[k : k + 1])
        points = _surface(skin, *skin.poses(bend))
        points = points[np.linalg.norm(points - place, axis=1) < UNDER_TOOL]
        if len(points):
            distance, _, _ = true.nearest(points)
            mean[k], most[k] = distance.mean(), distance.max()
    return mean, most


def _surface(skin: SegmentedSkin, R: FloatArray, p: FloatArray) -> FloatArray:
    """Nodes and triangles' middles (m, 3) of the slabs' skins at poses in M."""
    places = []
    for k, segment in enumerate(skin.segments):
        nodes = segment.nodes[: len(segment.nodes) // 3]
        both = np.concatenate([nodes, nodes[segment.triangles].mean(axis=1)])
        places.append(both @ R[k].T + p[k])
    return np.concatenate(places)
