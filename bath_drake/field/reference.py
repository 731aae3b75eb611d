"""The reference point that a motion along the field aims at."""

import numpy as np

from bath_drake.notation import FloatArray


def next_reference(
    reference: FloatArray,
    position: FloatArray,
    velocity: FloatArray,
    dt: float,
    leash: float,
) -> FloatArray:
    """Returns the reference one step of `dt` seconds later, shape (2,).

    The reference moves with the field's velocity (the paper's Euler step,
    Sec. III-C) but stays within `leash` of the measured position: an arm that
    lags or stands still is waited for instead of being run away from.

    Args:
        reference: The reference now, (2,), canonical.
        position: The measured position, (2,), canonical.
        velocity: The field's velocity at the measured position, (2,), 1/s.
        dt: The step, s.
        leash: Longest distance between reference and position, canonical.
    """
    offset = reference + dt * velocity - position
    length = float(np.hypot(offset[0], offset[1]))
    if length > leash:
        offset = offset * (leash / length)
    return position + offset
