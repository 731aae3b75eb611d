"""For how long each place of the true skin was under the jet or the sponge."""

from collections.abc import Iterator

import numpy as np

from bath_drake.notation import BoolArray, FloatArray
from bath_drake.patient.motion import MotionConfig, trunk_bend
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.washed_skin import triangles_around_back
from bath_drake.washing.footprint import JetCone, SpongeDisc
from bath_drake.washing.places import SkinPlaces

# Between looks, s: at 0.1 m/s a tool moves 10 mm, a fraction of its footprint.
LOOK_PERIOD_S = 0.1
# A ray to a place may meet the skin this much before it: facets and single precision.
_SLACK_M = 2e-3


def washed_seconds(
    skin: TrueSkin,
    places: SkinPlaces,
    motion: MotionConfig,
    time: FloatArray,
    tips_M: FloatArray,
    axes_M: FloatArray,
    tool: JetCone | SpongeDisc,
) -> FloatArray:
    """Adds up how long the tool was over each place.

    Args:
        skin: Of the person at rest.
        places: On it.
        motion: How the person moved.
        time: (n,) s, rising, of samples at a steady rate in which the tool worked.
            Gaps, in which it did not, add nothing.
        tips_M: (n, 3) of the tool in the person's frame of that time, m.
        axes_M: (n, 3) unit vectors along the tool, into the skin.
        tool: Jet or sponge.

    Returns:
        (len(places),) s; zero where it never was.
    """
    seconds = np.zeros(len(places))
    if not len(time):
        return seconds
    step = float(np.median(np.diff(time))) if len(time) > 1 else LOOK_PERIOD_S
    stride = max(1, round(LOOK_PERIOD_S / step))
    looks = range(0, len(time), stride)
    shapes = _shapes(skin, motion, time[list(looks)])
    at_rest = places.at(skin.person.vertices)
    for k, shape in zip(looks, shapes, strict=True):
        now = at_rest if shape.bent is None else places.at(shape.bent)
        under = _covered(shape, *now, tips_M[k], axes_M[k], tool)
        seconds[under] += step * min(stride, len(time) - k)
    return seconds


def _shapes(
    skin: TrueSkin, motion: MotionConfig, time: FloatArray
) -> Iterator[TrueSkin]:
    """The skin as it was at each time."""
    if not motion.bends:
        yield from (skin for _ in time)
        return
    bending, around = bending_skin(skin.person), triangles_around_back(skin.person)
    for t in time.tolist():
        yield TrueSkin(skin.person, bending.points(trunk_bend(t, motion)), around)


def _covered(
    skin: TrueSkin,
    points: FloatArray,
    normals: FloatArray,
    tip: FloatArray,
    axis: FloatArray,
    tool: JetCone | SpongeDisc,
) -> BoolArray:
    under = tool.covers(points, normals, tip, axis)
    if not tool.in_line_of_sight or not under.any():
        return under
    away = points[under] - tip
    distance = np.linalg.norm(away, axis=1)
    met, _ = skin.hit(np.tile(tip, (len(away), 1)), away / distance[:, None])
    first = np.linalg.norm(met - tip, axis=1)
    under[under] = first >= distance - _SLACK_M
    return under
