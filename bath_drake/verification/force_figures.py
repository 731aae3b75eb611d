"""How hard the tool pressed: figures of a run in contact."""

from typing import Any

import numpy as np

from bath_drake.control.approach import Phase
from bath_drake.notation import BoolArray, FloatArray
from bath_drake.simulation_log import SimulationLog
from bath_drake.verification.log_figures import most

# N: so near to what is asked for the force is to be, nearly always.
BAND = 2.0
# N: less is no contact.
_TOUCHING = 0.05


def normal_force(log: SimulationLog) -> FloatArray:
    """Returns the true force (T,) along the tool's axis into the skin, N."""
    return -log.contact_wrench[:, 5]


def stroke_samples(log: SimulationLog) -> BoolArray:
    """Whether a sample (T,) is of the stroke: first wash to last, breaks included."""
    washing = np.flatnonzero(log.phase == Phase.WASH)
    stroke = np.zeros(len(log.time), dtype=bool)
    if len(washing):
        stroke[washing[0] : washing[-1] + 1] = True
    return stroke


def force_figures(log: SimulationLog, force: float) -> dict[str, Any]:
    """Returns what metrics.json says of the force, all of it the true one.

    Args:
        log: Of a run in which skin can be touched.
        force: What was to be pressed with, N.

    Returns:
        `set`; over the stroke `mean` and `mean_error`, N, along the tool's axis, the
        share `within_2_n` and the `contact_share`; over the whole run `peak`, N, of the
        force's size in any direction, and `approach_speed_m_per_s`, the fastest that
        the stand-off was made to shrink; a figure is None where there was no stroke.
    """
    pressed = normal_force(log)[stroke_samples(log)]
    error = np.abs(pressed - force)
    some = len(pressed) > 0
    return {
        "set": force,
        "mean": float(pressed.mean()) if some else None,
        "mean_error": float(error.mean()) if some else None,
        "within_2_n": float((error <= BAND).mean()) if some else None,
        "contact_share": float((pressed > _TOUCHING).mean()) if some else None,
        "peak": most(np.linalg.norm(log.contact_wrench[:, 3:], axis=1)),
        "approach_speed_m_per_s": most(-np.diff(log.standoff) / np.diff(log.time)),
    }
