"""The reference point that a motion along the field aims at."""

import numpy as np

from bath_drake.notation import FloatArray


def next_reference(
    reference: FloatArray,
    position: FloatArray,
    velocity: FloatArray,
    *,
    dt: float,
    leash: float,
    pull: float,
) -> FloatArray:
    """Returns the reference one step of `dt` seconds later, shape (2,).

    The reference moves with the field's velocity (the paper's Euler step,
    Sec. III-C). The measured position closes the loop twice: it pulls the reference
    gently to itself, so that a nozzle that was pushed aside goes on from where it
    is, and the reference never runs further than `leash` ahead of it, so that an
    arm that lags or stands still is waited for.

    The velocity is that at the reference, not at the measured position: beside a
    virtual obstacle the direction of the flow may turn within a few hundredths, and
    with the arm's lag in between the loop would swing across such a valley.

    Args:
        reference: The reference now, (2,), canonical.
        position: The measured position, (2,), canonical.
        velocity: The field's velocity at the reference, (2,), 1/s.
        dt: The step, s.
        leash: Longest distance between reference and position, canonical.
        pull: Rate at which the reference moves to the position, 1/s.
    """
    moved = reference + dt * (velocity + pull * (position - reference))
    offset = moved - position
    length = float(np.hypot(offset[0], offset[1]))
    if length > leash:
        offset = offset * (leash / length)
    return np.asarray(position + offset)
