"""Demonstrations in canonical space N, and the map that took them there.

The paper performs every motion in a canonical space that is aligned with the
body and scaled by it (section III-A). A recording with a body box maps the box
to ``[-1, 1]^2``; a recording of a path alone is laid into its own best plane
and scaled by its own extents.
"""

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from bath_drake.notation import FloatArray

FrameKind = Literal["body_box", "path_plane", "planar"]

# Rows of a file's axes are rounded to some digits; more than this is a mistake.
AXES_TOLERANCE = 1e-6


def read_only(array: object) -> FloatArray:
    """Returns a private, read-only float64 copy of an array."""
    copy = np.array(array, dtype=np.float64)
    copy.setflags(write=False)
    return copy


@dataclass(frozen=True, eq=False)
class CanonicalFrame:
    """The map between the coordinates of a demonstration and canonical space N.

    ``p_N = axes (p - origin) / scales``: orthogonal projection onto the plane of
    the two axes, then one division per axis.

    Attributes:
        kind: `body_box` (the person's box is ``[-1, 1]^2``), `path_plane` (a 3-D
            path in its own best plane) or `planar` (a 2-D path, not rotated).
        origin: Centre of canonical space, shape (d,), m; d is 2 or 3.
        axes: The canonical x and y axes as orthonormal rows, shape (2, d).
        scales: Length of one canonical unit along each axis, shape (2,), m.

    Raises:
        ValueError: On a wrong shape, a non-finite number, axes that are not
            orthonormal, or a scale that is not positive.
    """

    kind: FrameKind
    origin: FloatArray
    axes: FloatArray
    scales: FloatArray

    def __post_init__(self) -> None:
        if self.kind not in get_args(FrameKind):
            raise ValueError(f"kind must be one of {get_args(FrameKind)}: {self.kind}")
        for name in ("origin", "axes", "scales"):
            array = read_only(getattr(self, name))
            if not np.all(np.isfinite(array)):
                raise ValueError(f"{name} must be finite, got {array.tolist()}")
            object.__setattr__(self, name, array)
        dimension = 2 if self.kind == "planar" else 3
        shapes = {"origin": (dimension,), "axes": (2, dimension), "scales": (2,)}
        for name, shape in shapes.items():
            found = getattr(self, name).shape
            if found != shape:
                raise ValueError(
                    f"{name} of a {self.kind} frame has shape {found}, not {shape}"
                )
        if not np.allclose(self.axes @ self.axes.T, np.eye(2), atol=AXES_TOLERANCE):
            raise ValueError(f"axes must be orthonormal rows, got {self.axes.tolist()}")
        if not np.all(self.scales > 0.0):
            raise ValueError(f"scales must be positive, got {self.scales.tolist()}")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, CanonicalFrame):
            return NotImplemented
        return self.kind == other.kind and all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("origin", "axes", "scales")
        )

    @property
    def dimension(self) -> int:
        """Number of coordinates of a demonstration's points, 2 or 3."""
        return int(self.origin.size)

    def to_canonical(self, points: FloatArray) -> FloatArray:
        """Maps points of a demonstration, shape (..., d), m, to N, shape (..., 2)."""
        mapped: FloatArray = ((points - self.origin) @ self.axes.T) / self.scales
        return mapped

    def to_demonstration(self, points: FloatArray) -> FloatArray:
        """Maps points of N, shape (..., 2), to the frame's plane, shape (..., d), m.

        The inverse of `to_canonical` for points of the plane; what a 3-D point
        had out of the plane is not in N and does not come back.
        """
        mapped: FloatArray = (points * self.scales) @ self.axes + self.origin
        return mapped


@dataclass(frozen=True, eq=False)
class PeriodicPart:
    """Circles or scrubbing on top of a demonstration, in N.

    Attributes:
        times: Shape (n,), s, from the same zero as the demonstration's.
        offsets: From the discrete part to the hand, shape (n, 2), in N.
        phase: Shape (n,), rad, not decreasing, 2 pi a cycle.
        envelope: Shape (n,): how much of the cycle there is, from 0 to about 1.
        period: Mean, s.
    """

    times: FloatArray
    offsets: FloatArray
    phase: FloatArray
    envelope: FloatArray
    period: float

    def __post_init__(self) -> None:
        for name in ("times", "offsets", "phase", "envelope"):
            array = read_only(getattr(self, name))
            if not np.all(np.isfinite(array)):
                raise ValueError(f"{name} of a periodic part must be finite")
            object.__setattr__(self, name, array)
        n = self.times.size
        shapes = [getattr(self, k).shape for k in ("times", "phase", "envelope")]
        if n < 2 or shapes != [(n,)] * 3 or self.offsets.shape != (n, 2):
            raise ValueError(
                f"times, phase and envelope must have shape (n,), n >= 2, and offsets "
                f"(n, 2), got {shapes} and {self.offsets.shape}"
            )
        if not (0.0 < self.period < np.inf):
            raise ValueError(f"period must be positive and finite, got {self.period}")


@dataclass(frozen=True, eq=False)
class CanonicalDemonstration:
    """One demonstration in canonical space.

    Attributes:
        name: Where it came from, for messages and legends.
        times: Times of `points`, shape (T,), s, from 0, not decreasing.
        points: Denoised path, equally spaced by arc length, shape (T, 2), in N.
        raw: The recorded points in N, shape (n, 2), not denoised, not shifted.
        sha256: Hash of the recording's bytes.
        goal_offset: What was taken from the denoised path to bring its end to
            the common goal, shape (2,), in N.
        periodic: What was taken off before `points` were made; None if nothing was.
        stray: Why it does not belong to the others it was read with; empty if it does.
            A stray is not moved to the common goal.
    """

    name: str
    times: FloatArray
    points: FloatArray
    raw: FloatArray
    sha256: str
    goal_offset: FloatArray = field(default_factory=lambda: np.zeros(2))
    periodic: PeriodicPart | None = None
    stray: str = ""

    def __post_init__(self) -> None:
        for name in ("times", "points", "raw", "goal_offset"):
            array = read_only(getattr(self, name))
            if not np.all(np.isfinite(array)):
                raise ValueError(f"{name} of demonstration {self.name} must be finite")
            object.__setattr__(self, name, array)
        count = self.times.size
        if self.times.shape != (count,) or self.points.shape != (count, 2):
            raise ValueError(
                f"times {self.times.shape} and points {self.points.shape} of "
                f"demonstration {self.name} must have shapes (T,) and (T, 2)"
            )
        if count < 2 or self.raw.ndim != 2 or self.raw.shape[1] != 2:
            raise ValueError(
                f"demonstration {self.name} needs at least 2 points and raw (n, 2), "
                f"got {count} and {self.raw.shape}"
            )
        if self.goal_offset.shape != (2,):
            raise ValueError(
                f"goal_offset has shape {self.goal_offset.shape}, not (2,)"
            )
