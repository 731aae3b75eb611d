"""How fast the skin moves where it is washed, and where it will be a moment on.

A camera's newest frame is some 20 milliseconds old on average, and skin that breathes
or leans has gone on since. The velocity of a place of skin is told by the fits at one
canonical point in two frames: what the washing itself moves is not in it.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray
from bath_drake.perception.quadric import cross
from bath_drake.perception.surface import SurfacePatch


@dataclass(frozen=True, kw_only=True)
class VelocityFilter:
    """A first-order filter on what two frames say, and its bounds.

    Attributes:
        time: Its time constant, s: the fits' noise (0.3 mm in a thirtieth of a second)
            is brought to 2 mm/s, and a breath's turn is known 0.15 s late.
        speed: No seated person's back is faster, m/s; what two frames say is bounded
            by it, so that one bad fit does not throw the nozzle.
        angular_speed: Likewise of its normal, rad/s.
    """

    time: float = 0.15
    speed: float = 0.3
    angular_speed: float = 1.0

    def __post_init__(self) -> None:
        """Raises ValueError unless all are positive and finite."""
        for name, value in vars(self).items():
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} must be positive and finite, got {value}")

    def next(
        self,
        velocity: FloatArray,
        before: SurfacePatch,
        after: SurfacePatch,
        dt: float,
    ) -> FloatArray:
        """Returns the velocity (6,) that is known with the newest frame.

        Angular part first, rad/s, then that of the point, m/s, in W. Of the turn, only
        that of the normal can be seen.

        Args:
            velocity: (6,) known before.
            before: The skin at a canonical point in the frame before.
            after: At the same canonical point in the newest frame.
            dt: Between the two, s, positive.

        Where either is not valid the skin counts as at rest: the velocity fades.

        Raises:
            ValueError: If `dt` is not positive and finite.
        """
        if not 0.0 < dt < math.inf:
            raise ValueError(f"dt must be positive and finite, got {dt}")
        seen = np.zeros(6)
        if before.valid and after.valid:
            turn = cross(before.normal_W, after.normal_W)
            seen[:3] = _at_most(turn / dt, self.angular_speed)
            seen[3:] = _at_most((after.p_WS - before.p_WS) / dt, self.speed)
        share = 1.0 - math.exp(-dt / self.time)
        return np.asarray(velocity + share * (seen - velocity))


def moved_patch(
    patch: SurfacePatch, velocity: FloatArray, elapsed: float
) -> SurfacePatch:
    """Returns where the skin is `elapsed` seconds later if it goes on like that.

    Args:
        patch: Where it was seen. One that is not valid stays as it is.
        velocity: (6,) of `VelocityFilter.next`.
        elapsed: s.
    """
    if not patch.valid or not velocity.any():
        return patch
    p_WS, normal_W = _moved(patch.p_WS, patch.normal_W, velocity, elapsed)
    return SurfacePatch(
        p_WS=p_WS,
        normal_W=normal_W,
        curvatures=patch.curvatures,
        count=patch.count,
        rms=patch.rms,
        radius=patch.radius,
        valid=patch.valid,
        normal_deviation=patch.normal_deviation,
    )


@njit(cache=True)
def _moved(
    p_WS: FloatArray, normal_W: FloatArray, velocity: FloatArray, elapsed: float
) -> tuple[FloatArray, FloatArray]:
    normal = normal_W + elapsed * cross(velocity[:3], normal_W)
    length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    return p_WS + elapsed * velocity[3:], normal / length


def _at_most(vector: FloatArray, bound: float) -> FloatArray:
    length = float(np.linalg.norm(vector))
    return vector if length <= bound else vector * (bound / length)
