"""What stands behind a verdict: critical points, traps and doubts made readable."""

import math
from typing import Final

import numpy as np
from numba import njit
from scipy.ndimage import label
from scipy.sparse.csgraph import connected_components

from bath_drake.certificate.evaluation import BETA, evaluate, new_table
from bath_drake.certificate.isolation import (
    MAXIMUM,
    MINIMUM,
    NONE,
    SADDLE_POINT,
    polish,
)
from bath_drake.certificate.result import Box, Cause, Component, Doubt, Enclosure, Trap
from bath_drake.certificate.world import World
from bath_drake.field.critical_points import Kind, kind_of
from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.field.rollout import RolloutStatus, rollout_ends
from bath_drake.notation import BoolArray, FloatArray, IntArray

_KINDS: Final[dict[int, Kind]] = {
    MINIMUM: "minimum",
    SADDLE_POINT: "saddle",
    MAXIMUM: "maximum",
}
# Doubts listed: more of them say nothing new.
_DOUBTS: Final = 12


def name_points(roots: FloatArray) -> tuple[Enclosure, ...]:
    """Rows (n, 9) of `isolation.critical_point_near` as values, sorted by x, then y."""
    points = []
    for x, y, low, high, proved, x0, x1, y0, y1 in sorted(roots.tolist()):
        kind, box = kind_of(low, high), None
        if int(proved) != NONE:
            kind, box = _KINDS[int(proved)], Box(x0, x1, y0, y1)
        points.append(Enclosure(x, y, kind, (low, high), box))
    return tuple(points)


def find_traps(
    field: NavigationField, points: tuple[Enclosure, ...]
) -> tuple[Trap, ...]:
    """The proved minima among critical points, with a start that ends in each."""
    minima = [p for p in points if p.kind == "minimum" and p.box is not None]
    cells = _components(field) if minima else np.zeros((0, 0), dtype=np.int64)
    traps = []
    for p in minima:
        assert p.box is not None
        start = _start_into(field, p, p.box)
        traps.append(Trap(p.box, p.x, p.y, _component(field, cells, p), start))
    return tuple(traps)


def _start_into(field: NavigationField, p: Enclosure, box: Box) -> tuple[float, float]:
    """A point from which a roll-out ends at the minimum p; the farther ones first."""
    size = float(field.workspace.semi_axes.max())
    # A trap catches what comes from beyond it, on the way to the goal.
    behind = np.arctan2(p.y - field.goal[1], p.x - field.goal[0])
    turns = behind + np.array([0.0, 0.7, -0.7, 1.7, -1.7, np.pi])
    ring = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    # psi is convex in the box: all of an ellipse of level about p flows to p, and of
    # this radius a disc lies well within one.
    low, high = p.eigenvalues
    inner = 0.25 * box.width * np.sqrt(max(low, 0.0) / high)
    for distance in (0.1, 0.03, 0.01, 1e-3, 1e-4):
        starts = np.array([p.x, p.y]) + distance * size * ring
        for start in starts[np.asarray(min_beta(starts, field)) > 0.0]:
            # Long steps may jump out of the basin: short ones have the last word.
            if all(
                _ends_at(start, p, inner, field, share * distance * size)
                for share in (0.1, 0.005)
            ):
                return float(start[0]), float(start[1])
    return p.x + float(inner) * float(ring[0, 0]), p.y + float(inner) * float(
        ring[0, 1]
    )


def _ends_at(
    start: FloatArray, p: Enclosure, inner: float, field: NavigationField, step: float
) -> bool:
    """Whether a roll-out stops at p or must go there; one that creeps by does not."""
    statuses, ends = rollout_ends(start, field, step=step, max_steps=5000)
    missed = float(np.hypot(ends[0, 0] - p.x, ends[0, 1] - p.y))
    stopped = statuses[0] is RolloutStatus.TRAPPED
    return missed <= inner or (stopped and missed <= step)


# A side of the grid on which components are told apart.
_CELLS: Final = 160


def _components(field: NavigationField) -> IntArray:
    """Labels of the components of free space on a grid over the workspace's box."""
    t = (np.arange(_CELLS) + 0.5) / _CELLS * 2.0 - 1.0
    x, y = np.meshgrid(t, t, indexing="ij")
    grid = np.stack([x, y], axis=-1) * field.workspace.semi_axes
    free = np.asarray(min_beta(field.workspace.centre + grid, field)) > 0.0
    return np.asarray(label(free)[0], dtype=np.int64)


def _component(field: NavigationField, cells: IntArray, p: Enclosure) -> Component:
    def at(q: FloatArray) -> int:
        share = (q - field.workspace.centre) / field.workspace.semi_axes
        i, j = np.clip(((share + 1.0) / 2.0 * _CELLS).astype(int), 0, _CELLS - 1)
        around = cells[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2]
        labels = around[around > 0]
        return int(labels[0]) if labels.size else 0

    return "goal" if at(np.array([p.x, p.y])) == at(field.goal) else "pocket"


def contacts(field: NavigationField) -> tuple[str, ...]:
    """Which obstacles overlap each other or the rim, in words."""
    obstacles = field.obstacles
    touching = _touching(obstacles.theta.copy())
    notes = [
        f"obstacles {i} and {j} overlap" for i, j in np.argwhere(touching).tolist()
    ]
    with np.errstate(over="ignore"):  # -inf is as good, far out
        rim = field.workspace.beta(obstacles.boundary(90))
    for i in np.flatnonzero((rim <= 0.0).any(axis=1)).tolist():
        notes.append(f"obstacle {i} crosses the rim")
    return tuple(notes)


@njit(cache=True, nogil=True)
def _touching(theta: FloatArray) -> BoolArray:
    """Pairs i < j of ellipses that none of 180 directions separates; (Q, Q)."""
    count = theta.shape[0]
    touching = np.zeros((count, count), dtype=np.bool_)
    for i in range(count):
        for j in range(i + 1, count):
            dx = theta[j, 0] - theta[i, 0]
            dy = theta[j, 1] - theta[i, 1]
            reach = max(theta[i, 2], theta[i, 3]) + max(theta[j, 2], theta[j, 3])
            touching[i, j] = math.hypot(dx, dy) <= reach
            for k in range(180):
                if not touching[i, j]:
                    break
                ux = math.cos(k * math.pi / 180.0)
                uy = math.sin(k * math.pi / 180.0)
                gap = abs(dx * ux + dy * uy)
                gap -= _support(theta[i], ux, uy) + _support(theta[j], ux, uy)
                touching[i, j] = gap <= 0.0
    return touching


@njit(cache=True, nogil=True)
def _support(row: FloatArray, ux: float, uy: float) -> float:
    c = math.cos(row[4])
    s = math.sin(row[4])
    return math.hypot(row[2] * (c * ux + s * uy), row[3] * (c * uy - s * ux))


def find_doubts(world: World, left: FloatArray, resolution: float) -> tuple[Doubt, ...]:
    """Groups open boxes (n, 4) that touch, and says what is the matter with each."""
    table = new_table(world)
    doubts = []
    for x0, x1, y0, y1 in _hulls(left).tolist():
        box = Box(x0, x1, y0, y1)
        cut: list[int] = []
        if evaluate((x0, x1), (y0, y1), world, table):
            cut = np.flatnonzero(table[:, BETA, 0] <= 0.0).tolist()
        sharp = _is_sharp(world, box, table)
        doubts.append(Doubt(box, *_explain(box, cut, sharp, resolution)))
        if len(doubts) == _DOUBTS:
            break
    return tuple(doubts)


def _is_sharp(world: World, box: Box, table: FloatArray) -> bool:
    """Whether a box holds a critical point that is far from merging with another."""
    found, _, _, a, b, c = polish(*box.centre, 100.0 * box.width, world, table)
    if not found:
        return False
    flattest = abs(0.5 * (a + c)) - float(np.hypot(0.5 * (a - c), b))
    # The attraction's own curvature is about kappa over the size squared.
    size = float(world.rim[2:4].max())
    return bool(abs(flattest) > 1e-2 * world.kappa / size**2)


def _explain(
    box: Box, cut: list[int], sharp: bool, resolution: float
) -> tuple[Cause, str]:
    x, y = box.centre
    where = f"near ({x:.6g}, {y:.6g})"
    if box.width > 1e3 * resolution:
        return (
            "budget",
            f"the budget of boxes ran out {where}: a greater one may decide",
        )
    names = ["the rim" if j == 0 else f"obstacle {j - 1}" for j in cut]
    if len(names) > 1:
        return "tangency", (
            f"{' and '.join(names)} touch {where}: moving one of them by more than "
            f"{10.0 * resolution:.1g} decides"
        )
    if names:
        return "resolution", (
            f"the field beside {names[0]} changes within the width of the smallest "
            f"boxes {where}: a finer resolution may decide"
        )
    if sharp:
        return "resolution", (
            f"a sharp critical point {where} could not be enclosed: rounder obstacles "
            "decide"
        )
    return "degeneracy", (
        f"two critical points merge or are born {where}: another kappa, or an obstacle "
        "moved or resized by a millionth, decides"
    )


def _hulls(boxes: FloatArray) -> FloatArray:
    """Bounding boxes (k, 4) of groups of touching boxes (n, 4)."""
    gap = 1e-12
    x_touch = (boxes[:, None, 0] <= boxes[None, :, 1] + gap) & (
        boxes[None, :, 0] <= boxes[:, None, 1] + gap
    )
    y_touch = (boxes[:, None, 2] <= boxes[None, :, 3] + gap) & (
        boxes[None, :, 2] <= boxes[:, None, 3] + gap
    )
    count, labels = connected_components(x_touch & y_touch, directed=False)
    hulls = np.empty((count, 4))
    for k in range(count):
        group = boxes[labels == k]
        hulls[k] = (
            group[:, 0].min(),
            group[:, 1].max(),
            group[:, 2].min(),
            group[:, 3].max(),
        )
    return hulls
