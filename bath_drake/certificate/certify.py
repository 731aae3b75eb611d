"""Proves that a field has no trap, or shows one.

The argument. psi = kappa ln gamma - sum_j w_j ln beta_j is smooth in free space
off q_d, -inf at q_d and +inf on every boundary; phi is an increasing function of
it. `subdivision.subdivide` covers free space with boxes, and for each proves that no
minimum of psi but q_d lies in it; a critical point may, if the Hessian has a negative
eigenvalue there. Then

1.  every component of free space holds a minimum of psi, so that there is but one
    component, that of q_d;
2.  psi falls along every integral curve of -grad phi, so that curves stay in compact
    sublevel sets, away from boundaries; psi being analytic, each tends to one
    critical point or to q_d;
3.  the starts that tend to a critical point with a negative eigenvalue have measure
    zero (its stable set is a null set), so that almost every start reaches q_d.

The same holds of {psi <= c} alone if boxes where psi > c are set aside, and of any of
its components: each is compact and holds a minimum. It says nothing of a world that
moves, of a robot that is no point, or of steps so long that they leave the curve. All
of it is written out in docs/certificate.md.
"""

import time
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.certificate.diagnosis import (
    contacts,
    find_doubts,
    find_traps,
    name_points,
)
from bath_drake.certificate.regions import WHOLE, level_of, standing
from bath_drake.certificate.result import Box, Certificate, Doubt
from bath_drake.certificate.separation import within_reach
from bath_drake.certificate.subdivision import subdivide
from bath_drake.certificate.world import Uncertainty, interval_world
from bath_drake.field.navigation import NavigationField
from bath_drake.notation import FloatArray

BUDGET: Final = 200_000
"""Boxes looked at; a hard world of 20 obstacles takes a tenth of it."""
RESOLUTION: Final = 1e-9
"""Boxes not wider than this share of the workspace are left open."""
# Numbers outside would overflow in squares and quotients of squares.
_SMALL, _LARGE = 1e-15, 1e15


def certify(
    field: NavigationField,
    *,
    starts: ArrayLike | None = None,
    level: float | None = None,
    uncertainty: Uncertainty | None = None,
    budget: int = BUDGET,
    resolution: float = RESOLUTION,
) -> Certificate:
    """Proves a field free of traps, refutes it, or says where it could do neither.

    Args:
        field: The world: workspace, goal, kappa and all obstacles.
        starts: Points (..., 2) in N. If given, only what they can reach is certified:
            their components of {psi <= c}, with c the greatest psi of them.
            'refuted' then means that the set holds a minimum and that no wall of
            greater psi was found between it and the starts.
        level: With starts: c, if it is to be greater than their own greatest psi.
        uncertainty: If given, a proof or a refutation holds for every realisation.
        budget: How many boxes are looked at, > 0.
        resolution: Width at which boxes are left open, as a share of the
            workspace's longer semi-axis, > 0.

    Raises:
        ValueError: An argument is out of its range.
    """
    begin = time.perf_counter()
    if budget < 1:
        raise ValueError(f"budget must be at least 1, got {budget}")
    if not 0.0 < resolution < 1.0:
        raise ValueError(f"resolution must be between 0 and 1, got {resolution}")
    if level is not None and (starts is None or not np.isfinite(level)):
        raise ValueError(f"level must be finite and come with starts, got {level}")
    given = None if starts is None else _rows(starts)
    found = _settle(field, uncertainty, given, level, budget, resolution)
    if found.verdict == "undecided" and uncertainty is not None:
        nominal = _settle(field, None, given, level, budget, resolution).verdict
        if nominal != "undecided":
            found = _blame_uncertainty(found, nominal)
    return replace(found, seconds=time.perf_counter() - begin)


def certify_from(
    field: NavigationField, starts: ArrayLike, *, budget: int = BUDGET
) -> Certificate:
    """Proves that almost every motion from about the given starts reaches the goal.

    The whole field is proved where that can be had, else what the starts can reach
    (their own sublevel set); if neither, the whole field's certificate is returned.

    Args:
        field: The world.
        starts: Points (..., 2) in N; one that is not in free space refutes.
        budget: How many boxes are looked at for each of the two, > 0.

    Raises:
        ValueError: A start is not two finite numbers.
    """
    begin = time.perf_counter()
    given = _rows(starts)
    found = _misplaced(field, None, given)
    if found is None:
        found = certify(field, budget=budget)
        if not found.passed:
            region = certify(field, starts=given, budget=budget)
            best = region if region.passed else found
            found = replace(best, boxes=found.boxes + region.boxes)
    return replace(found, seconds=time.perf_counter() - begin)


def _rows(starts: ArrayLike) -> FloatArray:
    points = np.array(starts, dtype=np.float64)
    if not points.size or points.shape[-1] != 2 or not np.isfinite(points).all():
        raise ValueError(f"starts must be finite points (..., 2), got {points}")
    return points.reshape(-1, 2)


def _settle(
    field: NavigationField,
    uncertainty: Uncertainty | None,
    starts: FloatArray | None,
    at_least: float | None,
    budget: int,
    resolution: float,
) -> Certificate:
    found = _misplaced(field, uncertainty, starts)
    if found is not None:
        return found
    world = interval_world(field, uncertainty)
    level = WHOLE if starts is None else level_of(world, starts)
    if at_least is not None:
        level = max(level[0], at_least), max(level[1], at_least)
    width = resolution * float(field.workspace.semi_axes.max())
    roots, left, unsettled, boxes = subdivide(world, level, width, budget)
    apart = False
    if starts is not None and unsettled == len(left):
        roots, left, apart = within_reach(world, level[1], starts, roots, left)
        unsettled = len(left)
    points = name_points(roots)
    part = "free space" if starts is None else "what the starts can reach"
    traps = find_traps(field, points)
    if traps:
        x, y = traps[0].x, traps[0].y
        found = Certificate(
            "refuted",
            f"a minimum besides the goal in {part}, at ({x:.6g}, {y:.6g})",
            traps=traps,
            witness=(x, y),
        )
    elif unsettled:
        doubts = find_doubts(world, left, width)
        reasons = dict.fromkeys(doubt.remedy for doubt in doubts)
        found = Certificate(
            "undecided",
            f"{unsettled} boxes of {part} could not be settled: {'; '.join(reasons)}",
            doubts=doubts,
        )
    else:
        count = sum(point.kind == "saddle" for point in points)
        saddles = "1 saddle" if count == 1 else f"{count} saddles"
        found = Certificate(
            "proved", f"no minimum besides the goal in {part}; {saddles}"
        )
    return replace(
        found,
        critical_points=points,
        region=None if starts is None else level[1],
        apart=apart,
        notes=contacts(field),
        boxes=boxes,
    )


def _misplaced(
    field: NavigationField, uncertainty: Uncertainty | None, starts: FloatArray | None
) -> Certificate | None:
    """The certificate where nothing need be settled: ends that are not free."""
    if not _computable(field):
        return Certificate(
            "undecided",
            f"the field holds lengths, exponents or a kappa not within "
            f"{_SMALL:g}..{_LARGE:g}: nothing can be computed safely",
        )
    world = interval_world(field, uncertainty)
    places = [("goal", field.goal)]
    if starts is not None:
        places += [(f"start {i}", q) for i, q in enumerate(starts)]
    for name, q in places:
        where, j = standing(world, q)
        if where == "free":
            continue
        x, y = float(q[0]), float(q[1])
        said = f"the {name} ({x:.6g}, {y:.6g}) lies"
        if where == "outside":
            what = "outside the workspace" if j == 0 else f"in obstacle {j - 1}"
            return Certificate("refuted", f"{said} {what}", witness=(x, y))
        what = "the rim" if j == 0 else f"obstacle {j - 1}"
        remedy = f"{said} on the boundary of {what} to working precision: move either"
        doubt = Doubt(Box(x, x, y, y), "tangency", remedy)
        return Certificate("undecided", remedy, doubts=(doubt,))
    return None


def _computable(field: NavigationField) -> bool:
    obstacles, workspace = field.obstacles, field.workspace
    sizes = [*obstacles.theta[:, 2:4].flat, *workspace.semi_axes, *obstacles.powers]
    places = [*obstacles.theta[:, :2].flat, *workspace.centre, *field.goal]
    least = min(*sizes, field.kappa)
    most = max(*sizes, field.kappa, *(abs(place) for place in places))
    return bool(least >= _SMALL and most <= _LARGE)


def _blame_uncertainty(found: Certificate, nominal: str) -> Certificate:
    """The field of the rows is decided, so that the tolerances make the difference."""
    remedy = f"without uncertainty the field is {nominal}: smaller tolerances decide"
    doubts = tuple(Doubt(d.box, "uncertainty", remedy) for d in found.doubts)
    return replace(found, doubts=doubts, reason=remedy)
