"""What plain floating-point numbers say against the proof's verdict on a box.

Nothing here knows of intervals or of compiled code. Floating-point numbers err as
well: only what contradicts a verdict by more than they can err counts.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from bath_drake.benchmarks import numpy_field
from bath_drake.certificate import box_test, isolation
from bath_drake.field.critical_points import find_critical_points
from bath_drake.field.navigation import NavigationField
from bath_drake.notation import BoolArray, FloatArray, IntArray

# Newton's roots are good to 1e-11 of the workspace's size unless nearly degenerate.
_MARGIN: Final = 1e-9
# Nearer to a boundary beta has too few digits left to contradict anything.
_CLEAR: Final = 1e-6
# beta is good to 1e-13, and so a quotient by it to 1e-7 where beta > _CLEAR.
_ROUNDING: Final = 1e-6

_GOALLESS = (
    box_test.OUTSIDE,
    box_test.ONE_WAY,
    box_test.NO_ROOT,
    box_test.SADDLE,
    box_test.ABOVE,
)
_ROOTLESS = (box_test.OUTSIDE, box_test.RADIAL, box_test.ONE_WAY, box_test.NO_ROOT)


@dataclass(frozen=True, eq=False)
class Evidence:
    """The critical points of a field, found numerically, and which are minima.

    Attributes:
        field: The field.
        roots: Shape (m, 2), without the goal and without nearly degenerate ones,
            whose place and kind are uncertain.
        minima: Shape (m,).
    """

    field: NavigationField
    roots: FloatArray
    minima: BoolArray

    @classmethod
    def of(cls, field: NavigationField) -> "Evidence":
        """Searches a field for its critical points."""
        found = find_critical_points(field)
        roots = np.array([(p.x, p.y) for p in found]).reshape(-1, 2)
        values = np.linalg.eigvalsh(numpy_field.derivatives(roots, field).hessian)
        size = np.abs(values)
        sure = size.min(axis=-1) > 1e-6 * size.max(axis=-1)
        return cls(field, roots[sure], (values[sure] > 0.0).all(axis=-1))

    def against_verdicts(
        self, boxes: FloatArray, verdicts: IntArray, levels: FloatArray, q: FloatArray
    ) -> BoolArray:
        """Which verdicts of `box_test` are contradicted, shape (n,).

        Args:
            boxes: Rows x low, x high, y low, y high, shape (n, 4).
            verdicts: Shape (n,).
            levels: The level c each was given, shape (n,).
            q: Points of each box to look at, shape (n, k, 2).
        """

        def said(verdict: int) -> BoolArray:
            return np.asarray(verdicts == verdict)

        at = numpy_field.derivatives(q, self.field)
        psi = numpy_field.psi(q, self.field)
        p = q - self.field.goal
        distance = np.linalg.norm(p, axis=-1)
        safe = (at.min_beta > _CLEAR) & (distance > 0.0)
        with np.errstate(invalid="ignore"):
            inwards = (p * at.gradient).sum(axis=-1) < -_ROUNDING * distance * at.force
            convex = np.linalg.eigvalsh(_finite(at.hessian))[..., 0] > (
                _ROUNDING * at.stiffness
            )
            clear = np.linalg.norm(at.gradient, axis=-1) > _ROUNDING * at.force
            under = psi < levels[:, None] - _ROUNDING * (1.0 + np.abs(levels[:, None]))
        wrong = said(box_test.OUTSIDE) & (at.min_beta > _CLEAR).any(axis=1)
        wrong |= said(box_test.RADIAL) & (safe & inwards).any(axis=1)
        wrong |= said(box_test.ONE_WAY) & _surrounded(at.gradient, safe & clear)
        wrong |= said(box_test.SADDLE) & (safe & convex).any(axis=1)
        wrong |= said(box_test.ABOVE) & (safe & under).any(axis=1)
        inside = self.roots_in(boxes)
        wrong |= np.isin(verdicts, _ROOTLESS) & inside.any(axis=1)
        wrong |= said(box_test.SADDLE) & (inside & self.minima).any(axis=1)
        with np.errstate(invalid="ignore"):
            low = numpy_field.psi(self.roots, self.field) < levels[:, None] - 1e-3
        wrong |= said(box_test.ABOVE) & (inside & low).any(axis=1)
        # psi has its pole at the goal: only RADIAL may settle a box that holds it.
        goal = _inside(boxes, self.field.goal, _MARGIN)
        settled = np.isin(verdicts, _GOALLESS)
        return np.asarray(wrong | (goal & settled))

    def against_enclosures(
        self, boxes: FloatArray, kinds: IntArray, q: FloatArray
    ) -> BoolArray:
        """Which verdicts of `enclose` are contradicted, shape (n,).

        Wrong are a second root, a root of another kind, none where Newton's method
        looks for it, and points that are not free.
        """
        claimed = kinds != isolation.NONE
        inside = self.roots_in(boxes)
        minimum = (kinds == isolation.MINIMUM)[:, None]
        other = inside & np.where(minimum, ~self.minima, self.minima)
        wrong = claimed & ((inside.sum(axis=1) > 1) | other.any(axis=1))
        at = numpy_field.derivatives(q, self.field)
        wrong |= claimed & (at.min_beta < -_ROUNDING).any(axis=1)
        unseen = np.flatnonzero(claimed & ~inside.any(axis=1))
        middles = 0.5 * (boxes[unseen, ::2] + boxes[unseen, 1::2])
        found = self._newton(middles)
        wrong[unseen] |= ~_inside(boxes[unseen], found, -_MARGIN)
        return np.asarray(wrong)

    def roots_in(self, boxes: FloatArray) -> BoolArray:
        """Whether boxes (n, 4) surely hold the roots, shape (n, m)."""
        return _inside(boxes[:, None], self.roots, _MARGIN)

    def _newton(self, q: FloatArray) -> FloatArray:
        for _ in range(20):
            at = numpy_field.derivatives(q, self.field)
            q = q - np.linalg.solve(at.hessian, at.gradient[..., None])[..., 0]
        return q


def _inside(boxes: FloatArray, points: FloatArray, margin: float) -> BoolArray:
    """Whether points lie in boxes and off their edges by a margin."""
    x, y = points[..., 0], points[..., 1]
    return np.asarray(
        (boxes[..., 0] + margin < x)
        & (x < boxes[..., 1] - margin)
        & (boxes[..., 2] + margin < y)
        & (y < boxes[..., 3] - margin)
    )


def _surrounded(vectors: FloatArray, counts: BoolArray) -> BoolArray:
    """Whether no direction points away from all vectors (n, k, 2) that count."""
    angles = np.arctan2(vectors[..., 1], vectors[..., 0])
    first = np.take_along_axis(angles, counts.argmax(axis=1)[:, None], axis=1)
    angles = np.sort(np.where(counts, angles, first), axis=1)
    around = np.concatenate([angles, angles[:, :1] + 2.0 * np.pi], axis=1)
    widest = np.diff(around, axis=1).max(axis=1)
    return np.asarray(counts.any(axis=1) & (widest < np.pi - 1e-3))


def _finite(matrices: FloatArray) -> FloatArray:
    return np.where(np.isfinite(matrices), matrices, 0.0)
