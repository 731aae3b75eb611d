"""Proves that a chain of fields brings almost every start to its last goal.

The theorem (docs/certificate.md, Compositions). Let every field be proved; let each
field's goal but the last lie in the interior of its gate, each closed gate in the free
space of the next field, and let no stable curve of a later field run along a gate's
boundary. Then almost every start in the first field's free space reaches the last goal,
and none touches a boundary of the field it is in. Each of these is shown here with
interval arithmetic. After Burridge, Rizzi and Koditschek, *Sequential composition of
dynamically dexterous robot behaviors*, IJRR 18 (1999).
"""

import time
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.certificate.certify import BUDGET, RESOLUTION, certify, certify_from
from bath_drake.certificate.crossing import (
    APART,
    NOT_SHOWN,
    boundary_is_crossed,
    goal_is_alone,
)
from bath_drake.certificate.half_disc import (
    FREE,
    NOT_FREE,
    inside,
    least_beta,
    most_psi,
)
from bath_drake.certificate.regions import standing
from bath_drake.certificate.result import Box, Certificate, Doubt
from bath_drake.certificate.world import World, interval_world
from bath_drake.composition.chain import Chain
from bath_drake.composition.result import Arrival, ChainCertificate, Handover
from bath_drake.field.navigation import NavigationField, psi
from bath_drake.notation import FloatArray

# Of psi over a gate a bound is wanted, not the value: that many boxes do.
_PSI_BUDGET: Final = 2000
_CROSSING_BUDGET: Final = 2000
# Boxes near a critical point, as a share of the workspace, at which it counts as found.
_ALONE: Final = 1e-4


def certify_chain(
    chain: Chain, *, start: ArrayLike | None = None, budget: int = BUDGET
) -> ChainCertificate:
    """Proves a chain, refutes it, or says where it could do neither.

    Args:
        chain: The fields and gates.
        start: A point (2,) in N. If given, a field that is not proved whole may be
            proved in part: the first where the start can come to, a later one where
            its gate can (its component of {psi <= c} with c at least psi all over
            the gate). The chain is then certified from about this start.
        budget: How many boxes are looked at for each field and for each gate, > 0.

    Returns:
        The parts' certificates; a chain of one is certified as its field is by
        `certify` or, with a start, by `certify_from`. 'refuted' means that a premise
        is: a field has a minimum besides its goal, or a point of a gate or the start is
        not free.

    Raises:
        ValueError: The start is not two finite numbers, or the budget not positive.
    """
    begin = time.perf_counter()
    first = chain.fields[0]
    if start is None:
        stages = [certify(first, budget=budget)]
    else:
        stages = [certify_from(first, np.reshape(start, (1, 2)), budget=budget)]
    worlds = [interval_world(field, None) for field in chain.fields]
    passages = []
    for k in range(len(chain.gates)):
        passages.append(_passage(chain, k, worlds[k + 1], budget))
        level = None if start is None else passages[k].level
        stages.append(_later_stage(chain, k + 1, level, budget))
    alone = [
        _is_alone(passage, chain.fields[k + 1], worlds[k + 1], stages[k + 1], budget)
        for k, passage in enumerate(passages)
    ]
    handovers = [
        _with_arrival(passage, chain, k, worlds, alone)
        if stages[k + 1].passed
        else passage
        for k, passage in enumerate(passages)
    ]
    seconds = time.perf_counter() - begin
    return ChainCertificate(tuple(stages), tuple(handovers), seconds)


def _later_stage(chain: Chain, k: int, level: float | None, budget: int) -> Certificate:
    """Of the whole field, or of what its gate can reach if only that is proved."""
    field = chain.fields[k]
    whole = certify(field, budget=budget)
    if whole.passed or level is None:
        return whole
    # The gate is connected: any of its points names the component that holds it.
    centre = chain.gates[k - 1].centre
    region = certify(field, starts=centre, level=level, budget=budget)
    best = region if region.passed else whole
    return replace(best, boxes=whole.boxes + region.boxes)


def _passage(chain: Chain, k: int, world: World, budget: int) -> Handover:
    """Gate k: is it free in the next field, and the goal within it?"""
    gate, goal = chain.gates[k], chain.fields[k].goal
    row = gate.as_array()
    status, clearance, box, boxes = least_beta(
        world, row, RESOLUTION * gate.radius, budget
    )
    if status == NOT_FREE:
        x, y = float(box[0]), float(box[2])
        _, j = standing(world, box[[0, 2]])
        what = "beyond the rim" if j == 0 else f"in obstacle {j - 1}"
        reason = f"its point ({x:.6g}, {y:.6g}) lies {what} of stage {k + 1}"
        return Handover("refuted", reason, witness=(x, y), boxes=boxes)
    if status != FREE:
        doubt = _touch(box, k + 1)
        return Handover("undecided", doubt.remedy, doubts=(doubt,), boxes=boxes)
    level, more = most_psi(world, row, _PSI_BUDGET)
    found = Handover(
        "proved",
        f"free in stage {k + 1}, beta >= {clearance:.3g}",
        clearance=float(clearance),
        level=float(level) if np.isfinite(level) else None,
        boxes=boxes + more,
    )
    if inside((goal[0], goal[0]), (goal[1], goal[1]), row):
        return found
    x, y = goal.tolist()
    remedy = (
        f"the goal ({x:.6g}, {y:.6g}) of stage {k} lies on the gate's boundary to "
        "working precision: move either"
    )
    doubt = Doubt(Box(x, x, y, y), "tangency", remedy)
    return replace(found, verdict="undecided", reason=remedy, doubts=(doubt,))


def _touch(box: FloatArray, stage: int) -> Doubt:
    x0, x1, y0, y1 = box.tolist()
    place = Box(x0, x1, y0, y1)
    x, y = place.centre
    remedy = (
        f"it touches a boundary of stage {stage} near ({x:.6g}, {y:.6g}): a smaller "
        "gate, or one moved, decides"
    )
    return Doubt(place, "tangency", remedy)


def _is_alone(
    passage: Handover,
    field: NavigationField,
    world: World,
    stage: Certificate,
    budget: int,
) -> bool:
    """Whether no critical point lies as low as the gate reaches in the next field."""
    if passage.level is None or not stage.passed:
        return False
    known = np.array([(p.x, p.y) for p in stage.critical_points]).reshape(-1, 2)
    if (np.asarray(psi(known, field)) <= passage.level).any():
        return False
    width = _ALONE * float(field.workspace.semi_axes.max())
    return bool(goal_is_alone(world, passage.level, width, budget)[0])


def _with_arrival(
    passage: Handover, chain: Chain, k: int, worlds: list[World], alone: list[bool]
) -> Handover:
    """Adds to gate k how many of its points go on to where they should.

    Exceptions of the next field are not only its saddles' curves but those, too, that
    lead to a later field's exceptions. Where gates overlap, points of this one's
    boundary are passed on at once to later fields than the next; these must cross it
    as well.
    """
    if passage.clearance is None:
        return passage
    gates = np.stack([gate.as_array() for gate in chain.gates])
    for j in range(k + 1, len(worlds)):
        if all(alone[j - 1 :]):
            continue  # from the gate into field j on, every motion arrives
        status, _ = boundary_is_crossed(
            worlds[j], gates[k], gates[k + 1 : j], _CROSSING_BUDGET
        )
        if status == APART:
            break
        if status == NOT_SHOWN:
            reason = (
                f"a curve of stage {j} that ends at a saddle, or leads to a later "
                "stage's, may run along the gate's boundary: a gate moved or turned a "
                "little decides"
            )
            if passage.verdict == "proved":
                passage = replace(passage, verdict="undecided", reason=reason)
            return passage
    arrival: Arrival = "every" if alone[k] else "almost every"
    return replace(passage, arrival=arrival)
