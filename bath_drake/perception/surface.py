"""The skin at one point: position, normal and curvature by a quadric fit."""

from dataclasses import dataclass

from bath_drake.notation import FloatArray


@dataclass(frozen=True, eq=False)
class SurfacePatch:
    """A second-order patch of skin around the washed point.

    Attributes:
        p_WS: (3,) the point on the skin, metres.
        normal_W: (3,) outward unit normal.
        curvatures: (2,) principal curvatures, 1/m, falling; positive bulges out.
        count: Points the fit rests on.
        rms: Residual of the fit, metres.
        radius: Radius of the fitted neighbourhood, metres.
        valid: False if the points did not determine a patch; then `p_WS` and
            `normal_W` are those of the back's plane and must not be washed at.
    """

    p_WS: FloatArray
    normal_W: FloatArray
    curvatures: FloatArray
    count: int
    rms: float
    radius: float
    valid: bool
