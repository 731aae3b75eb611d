"""How a chain's stages follow the motion's two ends.

Demonstrations from other starts differ from their mean; `bath_drake.learning` fits how.
Each stage of the mean's chain is moved by a similarity of its own, whose four numbers
are linear in features of start and goal: their offsets, and how near the start is to
each demonstration's. A moved stage is a field like any other and keeps its proof.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.composition.similarity import Similarity
from bath_drake.notation import FloatArray

NUMBERS = 4
"""Of a stage's similarity: real and imaginary part of stretch - 1, then the shift."""
MOST_STRETCH = 0.6
"""Greatest |stretch - 1|: a stage is never turned round or made a point."""


@dataclass(frozen=True, eq=False)
class Conditioning:
    """Similarities of K stages as functions of start and goal.

    Attributes:
        start: Where nothing is moved, shape (2,), in N: the mean start.
        goal: The last stage's goal, where nothing is moved, shape (2,).
        starts: The demonstrations' starts, shape (D, 2).
        width: Of the Gaussian bells about them, in N, positive.
        reach: Farthest from ``start`` that a start counts as; what is farther out is
            treated as the point of this distance in its direction, positive.
        pivots: Shape (K, 2).
        coefficients: Shape (K, 4, 4 + D): of the start's offset, the goal's offset and
            the bells.

    Raises:
        ValueError: Shapes do not fit, or a number is not finite or not positive.
    """

    start: FloatArray
    goal: FloatArray
    starts: FloatArray
    width: float
    reach: float
    pivots: FloatArray
    coefficients: FloatArray

    def __post_init__(self) -> None:
        for name in ("start", "goal", "starts", "pivots", "coefficients"):
            array = np.array(getattr(self, name), dtype=np.float64)
            if not np.isfinite(array).all():
                raise ValueError(f"{name} must be finite")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        count, stages = len(self.starts), len(self.pivots)
        shapes = {
            "start": (2,),
            "goal": (2,),
            "starts": (count, 2),
            "pivots": (stages, 2),
            "coefficients": (stages, NUMBERS, 4 + count),
        }
        for name, shape in shapes.items():
            if (found := getattr(self, name).shape) != shape:
                raise ValueError(f"{name} has shape {found}, not {shape}")
        for name in ("width", "reach"):
            value = float(getattr(self, name))
            if not 0.0 < value < np.inf:
                raise ValueError(f"{name} must be positive and finite, got {value}")
            object.__setattr__(self, name, value)

    def similarities(
        self, start: ArrayLike, goal: ArrayLike | None = None
    ) -> tuple[Similarity, ...]:
        """How each stage is moved for a start and a goal (2,); the learned one if None.

        Raises:
            ValueError: Start or goal are not two finite numbers.
        """
        features = self.features(start, self.goal if goal is None else goal)
        moved = []
        for pivot, (a, b, x, y) in zip(
            self.pivots, self.coefficients @ features, strict=True
        ):
            change = complex(a, b)
            change *= min(1.0, MOST_STRETCH / max(abs(change), 1e-300))
            moved.append(Similarity(pivot, 1.0 + change, np.array([x, y])))
        return tuple(moved)

    def features(self, start: ArrayLike, goal: ArrayLike) -> FloatArray:
        """What the similarities are linear in, shape (4 + D,); zero at the mean's ends.

        Raises:
            ValueError: Start or goal are not two finite numbers.
        """
        ends = np.array([start, goal], dtype=np.float64)
        if ends.shape != (2, 2) or not np.isfinite(ends).all():
            raise ValueError(f"start and goal must be two finite numbers, got {ends}")
        offset = ends[0] - self.start
        offset *= min(1.0, self.reach / max(float(np.hypot(*offset)), 1e-300))
        near = bells(self.start + offset, self.starts, self.width)
        rest = bells(self.start, self.starts, self.width)
        return np.concatenate([offset, ends[1] - self.goal, near - rest])


def bells(q: FloatArray, centres: FloatArray, width: float) -> FloatArray:
    """Gaussian bells of height one about centres (D, 2) at a point (2,), shape (D,)."""
    square = ((centres - q) ** 2).sum(axis=-1)
    return np.asarray(np.exp(-0.5 * square / width**2))
