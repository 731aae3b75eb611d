"""When a made-up area reaches the nozzle, and how often the nozzle goes into one."""

import numpy as np

from bath_drake.faults.effects import area_row
from bath_drake.faults.script import AreaFault
from bath_drake.field.obstacles import ObstacleSet, beta
from bath_drake.notation import BoolArray, FloatArray
from bath_drake.perception.faults import within

# s: what the guard may take, and a period of the camera that shows it.
REACTION_S = 0.1 + 1.0 / 30.0


def _inside(area: FloatArray, points: FloatArray) -> BoolArray:
    """Whether each of points (n, 2) is in an area (5,)."""
    return np.asarray(beta(points, ObstacleSet(area[None, :]))[:, 0] < 0.0)


def area_touches(
    faults: list[AreaFault],
    time: FloatArray,
    points: FloatArray,
    down: BoolArray | None = None,
) -> tuple[float | None, int]:
    """Returns when an area first held the nozzle, s, and how often it went into one.

    Being overtaken by an area is no entry, nor is being in one already: of two samples,
    the later one is in the area, the earlier one was not, and would not be either
    were the area where it is at the later. Nor is going on into what appeared less than
    `REACTION_S` ago, or crossing it high above the skin.

    Args:
        faults: The areas.
        time: (T,) s.
        points: (T, 2) of the washed point in N.
        down: (T,) whether the nozzle is at the skin, or on its way down to it; None for
            always.
    """
    first: float | None = None
    entries = 0
    for fault in faults:
        during = [k for k, t in enumerate(time) if within(fault, float(t))]
        was_in = False
        for k in during:
            tool = points[during[0]]
            area = area_row(fault, float(time[k]), tool)
            now, before = _inside(area, points[np.array([k, max(k - 1, 0)])])
            if now and (first is None or time[k] < first):
                first = float(time[k])
            told = time[k] - fault.begin > REACTION_S
            near = down is None or bool(down[k])
            entries += int(told and near and now and not before and not was_in)
            was_in = bool(now)
    return first, entries
