"""Gates of a moved chain drawn in where they would reach into an obstacle.

Stages that are moved each in its own way may bring a corner of a gate, which the motion
does not even pass, into an obstacle of the next field. Contracted about its goal, the
gate lies within what it was, and its goal within it: the motion is handed on a little
later, and the chain can be proved.
"""

from dataclasses import replace
from typing import Final

from bath_drake.certificate.certify import RESOLUTION
from bath_drake.certificate.half_disc import FREE, least_beta
from bath_drake.certificate.world import interval_world
from bath_drake.composition.chain import Chain, Gate
from bath_drake.field.navigation import NavigationField
from bath_drake.notation import FloatArray

CLEARANCE: Final = 0.02
"""Least beta_j of the next field that is asked for over a gate that is drawn in."""
_SHRINK: Final = 0.8
_SMALLEST: Final = 0.1  # of the radius: smaller gates are no gates
_BUDGET: Final = 500


def cleared(chain: Chain) -> Chain:
    """The chain with gates contracted about their goals until the next field is free.

    Gates that are free, and those that no contraction down to a tenth frees, stay as
    they are; where all do, it is the very chain.
    """
    gates = tuple(
        _cleared(gate, chain.fields[k].goal, chain.fields[k + 1])
        for k, gate in enumerate(chain.gates)
    )
    if all(a is b for a, b in zip(gates, chain.gates, strict=True)):
        return chain
    return replace(chain, gates=gates)


def _cleared(gate: Gate, goal: FloatArray, following: NavigationField) -> Gate:
    world = interval_world(following, None)
    share, wanted = 1.0, 0.0
    while share >= _SMALLEST:
        smaller = _contracted(gate, goal, share)
        row = smaller.as_array()
        status, clearance, _, _ = least_beta(
            world, row, RESOLUTION * smaller.radius, _BUDGET
        )
        if status == FREE and clearance >= wanted and smaller.holds(goal):
            return smaller
        share, wanted = share * _SHRINK, CLEARANCE
    return gate


def _contracted(gate: Gate, goal: FloatArray, share: float) -> Gate:
    if share == 1.0:
        return gate
    centre = goal + share * (gate.centre - goal)
    return Gate(centre, gate.direction, share * gate.radius)
