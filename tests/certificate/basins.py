"""An oracle for the certificate: the field written anew, and searched by brute force.

Nothing here comes from the compiled kernels: a mistake they share with the proof would
hide itself. Numbers are extended doubles (64 bits of mantissa) where they decide
anything. The search can only find minima, never exclude them.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.field.navigation import NavigationField
from bath_drake.notation import FloatArray

_GRID = 129  # odd: rows on the axes of symmetry, where symmetric worlds keep minima


@dataclass(frozen=True)
class Root:
    """A critical point to extended precision: position, eigenvalues, smallest beta."""

    x: float
    y: float
    low: float
    high: float
    clear: float
    step: float

    @property
    def is_minimum(self) -> bool:
        """Whether it is beyond doubt an isolated minimum in free space."""
        # Newton's last step is below 1e-15, so the eigenvalues are good to about
        # 1e-12 of the larger; 1e-8 leaves room for four figures more.
        return self.clear > 0.0 and self.step < 1e-12 and self.low > 1e-8 * self.high


def terms(q, field, dtype=np.longdouble):
    """beta_i, their gradients and Hessians at points (..., 2), the rim's first."""
    q = np.asarray(q, dtype=dtype)
    w = field.workspace
    power = w.power
    u = (q - w.centre.astype(dtype)) / w.semi_axes.astype(dtype)
    d = power * (power - 1) * u ** (power - 2) / w.semi_axes.astype(dtype) ** 2
    rim = 1 - (u**power).sum(axis=-1)
    slope = -power * u ** (power - 1) / w.semi_axes.astype(dtype)
    bend = np.zeros((*q.shape[:-1], 2, 2), dtype=dtype)
    bend[..., 0, 0], bend[..., 1, 1] = -d[..., 0], -d[..., 1]
    values, slopes, bends = [rim], [slope], [bend]
    for cx, cy, a, b, angle in field.obstacles.theta.astype(dtype):
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, s], [-s, c]], dtype=dtype)
        form = turn.T @ np.diag([1 / a**2, 1 / b**2]).astype(dtype) @ turn
        v = q - np.array([cx, cy])
        h = v @ form
        values.append((v * h).sum(axis=-1) - 1)
        slopes.append(2 * h)
        bends.append(np.broadcast_to(2 * form, bend.shape))
    return np.stack(values), np.stack(slopes), np.stack(bends)


def exponents(field, dtype=np.longdouble):
    """w_0 = 1 and the obstacles' exponents."""
    return np.concatenate([[1.0], field.obstacles.powers]).astype(dtype)


def least_beta(q, field, dtype=np.longdouble):
    """The smallest beta_i at points (..., 2)."""
    return _values(q, field, dtype).min(axis=0)


def _values(q, field, dtype):
    """beta_i alone, (Q + 1, ...): what a grid needs, quickly."""
    q = np.asarray(q, dtype=dtype)
    w = field.workspace
    out = np.empty((len(field.obstacles) + 1, *q.shape[:-1]), dtype=dtype)
    u = ((q - w.centre.astype(dtype)) / w.semi_axes.astype(dtype)) ** 2
    out[0] = 1 - (u ** (w.power // 2)).sum(axis=-1)
    for i, (cx, cy, a, b, angle) in enumerate(field.obstacles.theta.astype(dtype)):
        c, s = np.cos(angle), np.sin(angle)
        dx, dy = q[..., 0] - cx, q[..., 1] - cy
        out[i + 1] = ((c * dx + s * dy) / a) ** 2 + ((c * dy - s * dx) / b) ** 2 - 1
    return out


def psi(q, field, dtype=np.longdouble):
    """kappa ln gamma - sum w ln beta; +inf outside free space, -inf at the goal."""
    q = np.asarray(q, dtype=dtype)
    values = _values(q, field, dtype)
    free = (values > 0).all(axis=0)
    gamma = ((q - field.goal.astype(dtype)) ** 2).sum(axis=-1)
    logs = np.log(np.where(free, values, 1))
    with np.errstate(divide="ignore"):
        total = dtype(field.kappa) * np.log(gamma)
    total = total - np.tensordot(exponents(field, dtype), logs, axes=1)
    return np.where(free, total, np.inf)


def grad_hessian(q, field):
    """Gradient (2,) and Hessian (2, 2) of psi at one free point (2,)."""
    q = np.asarray(q, dtype=np.longdouble)
    values, slopes, bends = terms(q, field)
    w = exponents(field) / values
    d = q - field.goal.astype(np.longdouble)
    gamma = d @ d
    k = 2 * np.longdouble(field.kappa) / gamma
    gradient = k * d - w @ slopes
    hessian = k * (np.eye(2) - 2 * np.outer(d, d) / gamma)
    for weight, value, slope, bend in zip(w, values, slopes, bends, strict=True):
        hessian = hessian + weight * (np.outer(slope, slope) / value - bend)
    return gradient, hessian


def eigenvalues(hessian):
    """Of a symmetric (2, 2) matrix, the lower one first (numpy's take doubles only)."""
    mean = (hessian[0, 0] + hessian[1, 1]) / 2
    half = np.hypot((hessian[0, 0] - hessian[1, 1]) / 2, hessian[0, 1])
    return mean - half, mean + half


def polish(x, y, field):
    """The critical point Newton's method finds from (x, y), or None."""
    q = np.array([x, y], dtype=np.longdouble)
    size = np.longdouble(field.workspace.semi_axes.max())
    length = np.inf
    for _ in range(60):
        gradient, hessian = grad_hessian(q, field)
        det = hessian[0, 0] * hessian[1, 1] - hessian[0, 1] ** 2
        if det == 0 or not np.isfinite(det):
            return None
        adjugate = np.array(
            [[hessian[1, 1], -hessian[0, 1]], [-hessian[0, 1], hessian[0, 0]]]
        )
        step = -(adjugate @ gradient) / det
        before, length = length, np.hypot(*step) / size
        if not np.isfinite(length):
            return None
        if length < 1e-15 or (length < 1e-12 and length >= before):
            break
        shrink = min(np.longdouble(1), np.longdouble(0.05) / length)
        while shrink > 1e-6 and least_beta(q + shrink * step, field) <= 0:
            shrink /= 2
        if shrink <= 1e-6:
            return None
        q = q + shrink * step
    else:
        return None
    low, high = eigenvalues(grad_hessian(q, field)[1])
    clear = least_beta(q, field)
    return Root(*map(float, (q[0], q[1], low, high, clear, length)))


def find_minima(field, count: int = _GRID) -> list[Root]:
    """Minima of psi besides the goal that a grid of count^2 points leads to."""
    w = field.workspace
    t = np.linspace(-1.0, 1.0, count)
    grid = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1)
    grid = w.centre + grid * w.semi_axes
    value = np.pad(psi(grid, field, np.float64), 1, constant_values=np.inf)
    around = [
        value[1 + i : 1 + i + count, 1 + j : 1 + j + count]
        for i in (-1, 0, 1)
        for j in (-1, 0, 1)
        if i or j
    ]
    inner = value[1:-1, 1:-1]
    lowest = np.isfinite(inner) & (inner <= np.min(around, axis=0))
    starts = grid[lowest]
    if not len(starts):
        return []
    found: list[Root] = []
    near = 1e-6 * float(w.semi_axes.max())
    for x, y in _descend(starts, field, 2.0 / (count - 1) * float(w.semi_axes.max())):
        if np.hypot(x - field.goal[0], y - field.goal[1]) < near:
            continue
        root = polish(x, y, field)
        if root is None or not root.is_minimum:
            continue
        if np.hypot(root.x - x, root.y - y) > 1e3 * near:
            continue  # Newton's method went elsewhere
        if all(np.hypot(root.x - r.x, root.y - r.y) > near for r in found):
            found.append(root)
    return found


def _descend(starts: FloatArray, field: NavigationField, spacing: float) -> FloatArray:
    """Pattern search from points (n, 2): the lowest of 49 around, then closer."""
    t = np.linspace(-1.0, 1.0, 7)
    pattern = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    points = starts.copy()
    radius = np.full(len(points), 1.5 * spacing)
    for _ in range(200):
        around = points[:, None] + radius[:, None, None] * pattern
        best = psi(around, field, np.float64).argmin(axis=1)
        points = around[np.arange(len(points)), best]
        settled = np.abs(pattern[best]).max(axis=1) < 0.9
        radius = np.where(settled, radius / 2, radius)
        if (radius < 1e-7 * spacing).all():
            break
    return points


def gradient_holds_in(box, field, count: int = 9) -> FloatArray:
    """|grad psi| on a lattice over a box, to look for places where it vanishes."""
    x = np.linspace(box.x_min, box.x_max, count)
    y = np.linspace(box.y_min, box.y_max, count)
    return np.array(
        [[float(np.hypot(*grad_hessian([a, b], field)[0])) for b in y] for a in x]
    )
