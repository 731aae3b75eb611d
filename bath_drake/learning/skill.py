"""A learned skill: everything that reproducing it needs."""

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from bath_drake.demonstrations.canonical import CanonicalFrame
from bath_drake.field.navigation import NavigationField
from bath_drake.notation import FloatArray


@dataclass(frozen=True, eq=False)
class Skill:
    """A field, where it starts, and where both came from.

    Attributes:
        field: The navigation field, in N.
        start: Mean start of the demonstrations, shape (2,), in N.
        seed: Of the learner's random generator.
        config: The learner's configuration, plain values.
        demonstration_hashes: SHA-256 of every demonstration file, in order.
        canonical: The map between the demonstrations' coordinates and N.
        mean_demonstration: The demonstrations' mean at equal shares of arc length,
            shape (T, 2), in N: what the motion is compared with.
        scale: Longest side of the demonstrations' joint box, in N; Fréchet
            figures are divided by it.
        frechet: Figures as in `LearningResult.frechet`.
        certificate: What was proved of the field, plain values (see
            `bath_drake.certificate_file`).

    Raises:
        ValueError: The start or the mean demonstration is not finite and of its
            shape, or the scale is not positive.
    """

    field: NavigationField
    start: FloatArray
    seed: int
    config: dict[str, Any]
    demonstration_hashes: tuple[str, ...]
    canonical: CanonicalFrame
    mean_demonstration: FloatArray
    scale: float
    frechet: dict[str, float] = dataclasses.field(default_factory=dict)
    certificate: dict[str, Any] = dataclasses.field(default_factory=dict)

    def __post_init__(self) -> None:
        start = np.array(self.start, dtype=np.float64)
        if start.shape != (2,) or not np.isfinite(start).all():
            raise ValueError(f"start must be two finite numbers, got {self.start}")
        start.setflags(write=False)
        object.__setattr__(self, "start", start)
        mean = np.array(self.mean_demonstration, dtype=np.float64)
        if mean.ndim != 2 or mean.shape[1] != 2 or len(mean) < 2:
            raise ValueError(f"mean_demonstration has shape {mean.shape}, not (T, 2)")
        if not np.isfinite(mean).all():
            raise ValueError("mean_demonstration must be finite")
        mean.setflags(write=False)
        object.__setattr__(self, "mean_demonstration", mean)
        if not (0.0 < self.scale < np.inf):
            raise ValueError(f"scale must be positive and finite, got {self.scale}")
