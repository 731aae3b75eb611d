"""What stands behind a verdict: critical points, traps and doubts made readable."""

from typing import Final

import numpy as np
from numba import njit
from scipy.ndimage import label
from scipy.sparse.csgraph import connected_components

from bath_drake.certificate.evaluation import BETA, COLUMNS, evaluate
from bath_drake.certificate.isolation import (
    MAXIMUM,
    MINIMUM,
    NONE,
    SADDLE_POINT,
    grow,
    polish,
)
from bath_drake.certificate.result import Box, Cause, Component, Doubt, Enclosure, Trap
from bath_drake.certificate.world import World
from bath_drake.field.critical_points import Kind, kind_of
from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.field.obstacles import ObstacleSet, pair_gaps
from bath_drake.field.rollout import RolloutStatus, rollout_ends
from bath_drake.notation import FloatArray, IntArray

_KINDS: Final[dict[int, Kind]] = {
    MINIMUM: "minimum",
    SADDLE_POINT: "saddle",
    MAXIMUM: "maximum",
}
# Doubts listed: more of them say nothing new.
_DOUBTS: Final = 12


def critical_points(
    world: World, saddles: FloatArray, traps: FloatArray
) -> tuple[Enclosure, ...]:
    """Polishes and encloses the critical points in boxes (n, 4), sorted by x, y.

    All of a settled field lie in the boxes given; from each, Newton's method starts.
    """
    # One polished from its own box may lie a little outside it.
    boxes = np.concatenate([traps, saddles])
    found = []
    for x, y, low, high, kind, x0, x1, y0, y1 in _polish_all(world, boxes).tolist():
        box = None if int(kind) == NONE else Box(x0, x1, y0, y1)
        name = kind_of(low, high) if box is None else _KINDS[int(kind)]
        found.append(Enclosure(x, y, name, (low, high), box))
    return tuple(sorted(found, key=lambda point: (point.x, point.y)))


@njit(cache=True, nogil=True)
def _polish_all(world: World, boxes: FloatArray) -> FloatArray:
    """Rows x, y, both eigenvalues, what `enclose` proved and the box; one a root."""
    table = np.empty((world.exponents.shape[0], COLUMNS, 2))
    rows = np.empty((boxes.shape[0], 9))
    box = np.zeros(4)
    count = 0
    near = 1e-8 * max(world.rim[2], world.rim[3])
    for i in range(boxes.shape[0]):
        x = 0.5 * (boxes[i, 0] + boxes[i, 1])
        y = 0.5 * (boxes[i, 2] + boxes[i, 3])
        leash = 2.0 * max(boxes[i, 1] - boxes[i, 0], boxes[i, 3] - boxes[i, 2])
        ok, x, y, a, b, c = polish(x, y, leash, world, table)
        if not ok:
            continue
        known = False
        for k in range(count):
            known = known or (
                abs(rows[k, 0] - x) <= near and abs(rows[k, 1] - y) <= near
            )
        if known:
            continue
        mean = 0.5 * (a + c)
        half = np.hypot(0.5 * (a - c), b)
        rows[count, 0] = x
        rows[count, 1] = y
        rows[count, 2] = mean - half
        rows[count, 3] = mean + half
        rows[count, 4] = grow(x, y, world, np.inf, table, box)
        rows[count, 5:] = box
        count += 1
    return rows[:count]


def find_traps(
    field: NavigationField, points: tuple[Enclosure, ...]
) -> tuple[Trap, ...]:
    """The proved minima among critical points, with a start that ends in each."""
    minima = [p for p in points if p.kind == "minimum" and p.box is not None]
    cells = _components(field) if minima else np.zeros((0, 0), dtype=np.int64)
    traps = []
    for p in minima:
        assert p.box is not None
        start = _start_into(field, p)
        traps.append(Trap(p.box, p.x, p.y, _component(field, cells, p), start))
    return tuple(traps)


def _start_into(field: NavigationField, p: Enclosure) -> tuple[float, float] | None:
    """A point some way off from which a roll-out ends at p, the farthest tried."""
    size = float(field.workspace.semi_axes.max())
    turns = np.arange(16) * (np.pi / 8.0)
    ring = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    for distance in (0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4):
        starts = np.array([p.x, p.y]) + distance * size * ring
        starts = starts[np.asarray(min_beta(starts, field)) > 0.0]
        step = min(0.02, 0.3 * distance) * size
        statuses, ends = rollout_ends(starts, field, step=step, max_steps=1000)
        for q, status, end in zip(starts, statuses, ends, strict=True):
            missed = float(np.hypot(end[0] - p.x, end[1] - p.y))
            if status is RolloutStatus.TRAPPED and missed <= 0.05 * distance * size:
                return float(q[0]), float(q[1])
    return None


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
    notes: list[str] = []
    centres = obstacles.theta[:, :2]
    radii = obstacles.theta[:, 2:4].max(axis=1, initial=0.0)
    apart = np.hypot(*(centres[:, None, :] - centres[None, :, :]).transpose(2, 0, 1))
    close = np.triu(apart <= radii[:, None] + radii[None, :], 1)
    for i, j in np.argwhere(close).tolist():
        pair = ObstacleSet(obstacles.theta[[i, j]])
        if pair_gaps(pair, 180)[0, 1] <= 0.0:
            notes.append(f"obstacles {i} and {j} overlap")
    rim = field.workspace.beta(obstacles.boundary(90))
    for i in np.flatnonzero((rim <= 0.0).any(axis=1)).tolist():
        notes.append(f"obstacle {i} crosses the rim")
    return tuple(notes)


def find_doubts(world: World, left: FloatArray, resolution: float) -> tuple[Doubt, ...]:
    """Groups open boxes (n, 4) that touch, and says what is the matter with each."""
    table = np.empty((len(world.exponents), COLUMNS, 2))
    doubts = []
    for x0, x1, y0, y1 in _hulls(left).tolist():
        box = Box(x0, x1, y0, y1)
        cut: list[int] = []
        if evaluate((x0, x1), (y0, y1), world, table):
            cut = np.flatnonzero(table[:, BETA, 0] <= 0.0).tolist()
        doubts.append(Doubt(box, *_explain(box, cut, resolution)))
        if len(doubts) == _DOUBTS:
            break
    return tuple(doubts)


def _explain(box: Box, cut: list[int], resolution: float) -> tuple[Cause, str]:
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
    beside = f" beside {names[0]}" if names else ""
    return "degeneracy", (
        f"two critical points merge or are born{beside} {where}: another kappa, or "
        "an obstacle moved or resized by a millionth, decides"
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
