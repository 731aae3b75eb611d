"""When a made-up area reaches the nozzle, and how often the nozzle goes into one."""

import numpy as np

from bath_drake.faults.effects import area_row
from bath_drake.faults.script import AreaFault
from bath_drake.field.obstacles import ObstacleSet, beta
from bath_drake.notation import BoolArray, FloatArray
from bath_drake.perception.faults import within


def _inside(area: FloatArray, points: FloatArray) -> BoolArray:
    """Whether each of points (n, 2) is in an area (5,)."""
    return np.asarray(beta(points, ObstacleSet(area[None, :]))[:, 0] < 0.0)


def area_touches(
    faults: list[AreaFault], time: FloatArray, points: FloatArray
) -> tuple[float | None, int]:
    """Returns when an area first held the nozzle, s, and how often it went into one.

    Being overtaken by an area is no entry, nor is being in one already: of two samples,
    the later one is in the area, the earlier one was not, and would not be either
    were the area where it is at the later.

    Args:
        faults: The areas.
        time: (T,) s.
        points: (T, 2) of the washed point in N.
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
            entries += int(now and not before and not was_in)
            was_in = bool(now)
    return first, entries
