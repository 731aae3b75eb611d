"""What a fault makes of a signal, and where a made-up area is."""

import numpy as np

from bath_drake.faults.script import AreaFault, SignalFault
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.notation import FloatArray
from bath_drake.perception.faults import within


def faulty_signal(
    value: FloatArray, held: FloatArray, fault: SignalFault, t: float
) -> FloatArray:
    """Returns what the readers of a signal get.

    Args:
        value: (n,) as it is.
        held: (n,) as it was when the fault began.
        fault: What is wrong with it.
        t: Time, s.
    """
    if not within(fault, t):
        return value
    wrong = np.array(value, dtype=np.float64)
    which = fault.elements or slice(None)
    if fault.kind == "nan":
        wrong[which] = np.nan
    elif fault.kind == "constant":
        wrong[which] = fault.value
    elif fault.kind == "offset":
        wrong[which] += fault.value
    elif fault.kind == "ramp":
        wrong[which] += fault.value * (t - fault.begin)
    elif fault.kind == "frozen":
        wrong[which] = held[which]
    else:
        wrong[:] = held
        wrong[which] += fault.value * (t - fault.begin)
    return wrong


def area_row(fault: AreaFault, t: float, tool: FloatArray) -> FloatArray:
    """Returns an area as a row (5,) of `ObstacleSet.theta` at a time within it.

    Args:
        fault: The area.
        t: Time, s.
        tool: p_NQ (2,) of the nozzle as the area began.
    """
    centre = np.array(fault.centre) + (t - fault.begin) * np.array(fault.velocity)
    if fault.from_tool:
        centre = centre + tool
    return np.array([*centre, *fault.semi_axes, fault.angle])


def areas_at(
    faults: list[AreaFault], t: float, tools: dict[int, FloatArray]
) -> ObstacleSet:
    """Returns the areas there are at a time.

    Args:
        faults: All of them.
        t: Time, s.
        tools: By index, p_NQ (2,) of the nozzle as each that has begun did so.
    """
    rows = [
        area_row(fault, t, tools[k])
        for k, fault in enumerate(faults)
        if within(fault, t) and k in tools
    ]
    return ObstacleSet(np.array(rows).reshape(-1, 5))
