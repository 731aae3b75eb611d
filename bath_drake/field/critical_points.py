"""Where the field's gradient vanishes, found by numerical search.

A navigation function has one minimum, the goal, and one saddle per obstacle.
This search can refute that: a spurious minimum it finds is real. It cannot prove
it, for it may overlook a point; its best verdict is therefore 'numeric-pass'. It
stands in until a proof by interval arithmetic takes its place.
"""

import itertools
import time
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.field import _kernels
from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.field.obstacles import ObstacleSet, beta, pair_gaps
from bath_drake.field.rollout import RolloutStatus, rollout_ends
from bath_drake.notation import FloatArray

Kind = Literal["minimum", "saddle", "maximum", "degenerate"]
Verdict = Literal["numeric-pass", "refuted", "undecided"]


@dataclass(frozen=True)
class CriticalPoint:
    """A point other than the goal where grad psi = 0.

    Attributes:
        x: In N.
        y: In N.
        kind: What the Hessian of psi says; 'degenerate' if it is singular to
            working precision.
        eigenvalues: Of that Hessian, the lower one first.
    """

    x: float
    y: float
    kind: Kind
    eigenvalues: tuple[float, float]


@dataclass(frozen=True)
class FieldCheck:
    """What the search says about a field.

    Attributes:
        verdict: 'refuted' if the field is not a navigation function (a minimum
            besides the goal, or a goal or start that is not in free space);
            'undecided' if the critical points found cannot be all there are;
            otherwise 'numeric-pass'.
        critical_points: All found, the goal not among them.
        witness: For 'refuted' the point that shows it, else None.
        reason: The verdict in words.
        notes: Facts that do not decide: obstacles that touch the rim or each other.
        seconds: Time taken.
    """

    verdict: Verdict
    critical_points: tuple[CriticalPoint, ...]
    witness: tuple[float, float] | None
    reason: str
    notes: tuple[str, ...]
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether nothing was found against the field."""
        return self.verdict == "numeric-pass"


def find_critical_points(
    field: NavigationField, *, resolution: int = 48
) -> tuple[CriticalPoint, ...]:
    """Searches free space for the roots of grad psi.

    Newton's method from a grid of ``resolution``^2 points over the workspace, from
    rings around every obstacle, and from where roll-outs get trapped.

    Returns:
        The points found, sorted by x, then y; the goal is not among them.
    """
    starts = np.concatenate([_grid(field, resolution), _rings(field)])
    coarse = _grid(field, max(resolution // 4, 8))
    workspace, _, _, kappa, forms = field.kernel_arguments
    goal = field.goal.copy()
    # Roll-outs are drawn to minima that Newton's narrow basins may miss.
    statuses, ends = rollout_ends(coarse, field, step=float(workspace[2:4].min()) / 50)
    trapped = np.array([s is RolloutStatus.TRAPPED for s in statuses], dtype=bool)
    starts = np.concatenate([starts, ends[trapped]])
    rows = _kernels.newton_points(starts, workspace, goal, kappa, forms, 60)
    return _distinct(rows, 1e-6 * float(workspace[2:4].max()))


def check_field(field: NavigationField, starts: ArrayLike | None = None) -> FieldCheck:
    """Looks for anything that keeps a field from being a navigation function.

    Args:
        field: The field.
        starts: Points (..., 2) that must lie in free space, if any.

    Returns:
        A verdict with its witness; see `FieldCheck`.
    """
    begin = time.perf_counter()
    notes, index = _layout(field)

    def result(
        verdict: Verdict,
        reason: str,
        points: tuple[CriticalPoint, ...] = (),
        witness: tuple[float, float] | None = None,
    ) -> FieldCheck:
        seconds = time.perf_counter() - begin
        return FieldCheck(verdict, points, witness, reason, notes, seconds)

    places = [("goal", field.goal)]
    if starts is not None:
        given = np.asarray(starts, dtype=np.float64).reshape(-1, 2)
        places += [(f"start {i}", q) for i, q in enumerate(given)]
    for name, q in places:
        if min_beta(q, field) <= 0.0:
            where = (float(q[0]), float(q[1]))
            return result("refuted", _what_holds(name, q, field), witness=where)
    points: tuple[CriticalPoint, ...] = ()
    for resolution in (48, 96, 192):
        points = find_critical_points(field, resolution=resolution)
        for p in points:
            if p.kind == "minimum":
                reason = f"a minimum besides the goal at ({p.x:.6g}, {p.y:.6g})"
                return result("refuted", reason, points, (p.x, p.y))
        if index is None or _index(points) == index:
            break
    if any(p.kind == "degenerate" for p in points):
        return result("undecided", "a critical point is degenerate", points)
    if index is not None and _index(points) != index:
        reason = (
            f"the critical points found sum to index {_index(points)}, "
            f"but the obstacles ask for {index}"
        )
        return result("undecided", reason, points)
    reason = f"no minimum besides the goal; {len(points)} saddles"
    if index is None:
        reason += "; the count could not be checked, the obstacles overlap"
    return result("numeric-pass", reason, points)


def _index(points: Iterable[CriticalPoint]) -> int:
    """Sum of the Poincare-Hopf indices, the goal's included."""
    weight = {"minimum": 1, "saddle": -1, "maximum": 1, "degenerate": 0}
    return 1 + sum(weight[p.kind] for p in points)


def _layout(field: NavigationField) -> tuple[tuple[str, ...], int | None]:
    """Notes on contacts, and the Euler number of free space where it is certain."""
    obstacles = field.obstacles
    notes: list[str] = []
    touching = pair_gaps(obstacles) <= 0.0
    edges = 0
    parent = list(range(len(obstacles)))

    def root(i: int) -> int:
        while parent[i] != i:
            i = parent[i]
        return i

    forest = True
    for i, j in itertools.combinations(range(len(obstacles)), 2):
        if touching[i, j]:
            edges += 1
            notes.append(f"obstacles {i} and {j} overlap")
            forest = forest and root(i) != root(j)
            parent[root(i)] = root(j)
    rim = field.workspace.beta(obstacles.boundary(720))
    crosses = (rim <= 0.0).any(axis=1)
    notes += [f"obstacle {i} crosses the rim" for i in np.flatnonzero(crosses)]
    # Convex sets that overlap like the edges of a forest fill no ring: each tree
    # of them is one hole. Other unions would need their triple intersections.
    if crosses.any() or not forest:
        return tuple(notes), None
    return tuple(notes), 1 - (len(obstacles) - edges)


def _what_holds(name: str, q: FloatArray, field: NavigationField) -> str:
    inside = np.flatnonzero(beta(q, field.obstacles) <= 0.0)
    what = f"in obstacle {inside[0]}" if inside.size else "outside the workspace"
    return f"the {name} ({q[0]:.6g}, {q[1]:.6g}) lies {what}"


def _grid(field: NavigationField, resolution: int) -> FloatArray:
    """Points over the workspace's box, shape ((resolution + 1)^2, 2)."""
    # An odd count puts a row on each axis: Newton's method keeps to an axis of
    # symmetry, and symmetric worlds have critical points on theirs.
    t = (np.arange(resolution + 1) + 0.5) / (resolution + 1) * 2.0 - 1.0
    x, y = np.meshgrid(t, t)
    box = np.stack([x.ravel(), y.ravel()], axis=-1)
    return np.asarray(field.workspace.centre + box * field.workspace.semi_axes)


def _rings(field: NavigationField) -> FloatArray:
    """Points at several distances around every obstacle, shape (n, 2)."""
    obstacles = field.obstacles
    rings = [np.empty((0, 2))]
    for growth in (1.02, 1.1, 1.3, 1.7):
        theta = obstacles.theta * np.array([1.0, 1.0, growth, growth, 1.0])
        rings.append(ObstacleSet(theta).boundary(32).reshape(-1, 2))
    return np.concatenate(rings)


def _distinct(rows: FloatArray, tolerance: float) -> tuple[CriticalPoint, ...]:
    kept: list[FloatArray] = []
    for row in rows[np.lexsort((rows[:, 1], rows[:, 0]))]:
        if all(np.hypot(*(row[:2] - k[:2])) > tolerance for k in kept):
            kept.append(row)
    return tuple(_critical_point(*row.tolist()) for row in kept)


def _critical_point(
    x: float, y: float, hxx: float, hxy: float, hyy: float
) -> CriticalPoint:
    low, high = np.linalg.eigvalsh(np.array([[hxx, hxy], [hxy, hyy]])).tolist()
    return CriticalPoint(x, y, kind_of(low, high), (low, high))


def kind_of(low: float, high: float) -> Kind:
    """What a critical point with these eigenvalues of its Hessian is."""
    # Newton's root is good to 1e-11, so an eigenvalue is to about 1e-9 relative.
    if min(abs(low), abs(high)) < 1e-9 * max(abs(low), abs(high)):
        return "degenerate"
    if low > 0.0:
        return "minimum"
    return "saddle" if high > 0.0 else "maximum"
