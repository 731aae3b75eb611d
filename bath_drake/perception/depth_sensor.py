"""How depth cameras err: one model, and the numbers of three common ones.

Published is the deviation on smooth surfaces; docs/sensors.md has every source. At
edges the sampled place jitters (lateral noise) and depths of both sides mix (flying
pixels): no published formula is known to us, the shares there are our own.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.notation import FloatArray
from bath_drake.perception.camera import PinholeCamera

# Beyond this angle no published formula has measurements; that of the Kinect v2 would
# grow without bound.
MAX_MODELLED_ANGLE = np.deg2rad(85.0)
# What has no depth stands farther off than anything that has.
NOWHERE = 1e3
# Of the noise's grain, pixels.
MAX_GRAIN = 31


@dataclass(frozen=True)
class DepthSensor:
    """The numbers of the model; the defaults are a Kinect v2.

    The deviation along the optical axis is, at depth z and angle t to the normal,
    (a0 + a1 z + a2 z^2) + b z^1.5 t^2 / (pi/2 - t)^2 in mm, and for a stereo camera
    also z^2 d / (f B) for disparities that err by d pixels.

    Attributes:
        near: Nearest depth it reports, m.
        far: Farthest depth it reports, m.
        axial: a0, a1, a2, in mm for z in m.
        tilt: b, in mm for z in m.
        disparity: d, standard deviation of a stereo camera's disparities, pixels; 0
            for others.
        baseline: B, between a stereo camera's two eyes, m: what the right one does not
            see has no depth. 0 for others.
        grain: The noise is alike over this many pixels, odd; 1 if it is each pixel's
            own. Matching windows make it larger.
        lateral: Standard deviation of the sampled place at an edge, pixels.
        edge: The sampled place shows another surface than the pixel where it is this
            far off the pixel's plane, m.
        jump: Where depths within 3 x 3 pixels differ by more than the slope of their
            surface makes them, pixels fly, m.
        flying: Share of the pixels at a jump that mix the depths of both sides.
        lost: Share of the pixels at a jump that measure nothing.
        grazing: Skin seen at a flatter angle than this to its normal gives none, rad.
        resolution: Step of the reported depths, m.

    Raises:
        ValueError: If a number makes no sensor.
    """

    near: float = 0.5
    far: float = 4.5
    axial: tuple[float, float, float] = (1.5, -0.5, 0.3)
    tilt: float = 0.1
    disparity: float = 0.0
    baseline: float = 0.0
    grain: int = 1
    lateral: float = 0.5
    edge: float = 0.01
    jump: float = 0.06
    flying: float = 0.35
    lost: float = 0.15
    grazing: float = float(np.deg2rad(80.0))
    resolution: float = 0.001

    def __post_init__(self) -> None:
        """Checks all numbers."""
        for name in ("near", "edge", "jump", "resolution"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be positive, got {value}")
        if not self.near < self.far < NOWHERE:
            raise ValueError(f"far must be beyond near ({self.near}), got {self.far}")
        for name in ("tilt", "disparity", "baseline"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise ValueError(f"{name} must be >= 0 and finite, got {value}")
        if self.disparity > 0.0 and self.baseline == 0.0:
            raise ValueError("disparity needs a baseline, got 0")
        z = np.linspace(self.near, self.far, 50)
        a0, a1, a2 = self.axial
        # Not a number is less than nothing here.
        if not (a0 + a1 * z + a2 * z**2 >= 0.0).all():
            raise ValueError(
                f"axial must not be negative from near to far, got {self.axial}"
            )
        if not (1 <= self.grain <= MAX_GRAIN and self.grain % 2 == 1):
            raise ValueError(
                f"grain must be odd and in [1, {MAX_GRAIN}] pixels, got {self.grain}"
            )
        if not 0.0 <= self.lateral < 10.0:
            raise ValueError(f"lateral must be in [0, 10) pixels, got {self.lateral}")
        if not (min(self.flying, self.lost) >= 0.0 and self.flying + self.lost <= 1.0):
            raise ValueError(
                "flying and lost must be shares of at most 1 together, got "
                f"{self.flying} and {self.lost}"
            )
        if not 0.0 < self.grazing <= np.pi / 2:
            raise ValueError(f"grazing must be in (0, pi/2] rad, got {self.grazing}")

    def axial_with(self, fx: float) -> tuple[float, float, float]:
        """Returns a0, a1, a2 with the disparity's part, for a focal length in pixels.

        In mm, for z in m.
        """
        a0, a1, a2 = self.axial
        if self.disparity > 0.0:
            a2 += 1e3 * self.disparity / (fx * self.baseline)
        return a0, a1, a2


@dataclass(frozen=True)
class CameraModel:
    """A depth camera one can buy.

    Attributes:
        camera: The projection of its depth images.
        sensor: How they err.
    """

    camera: PinholeCamera
    sensor: DepthSensor


def axial_deviation(
    depth: FloatArray,
    angle: FloatArray,
    sensor: DepthSensor | None = None,
    fx: float = PinholeCamera.fx,
) -> FloatArray:
    """Returns the standard deviation of a measured depth, m.

    Args:
        depth: Along the optical axis, m.
        angle: Between the ray and the surface's normal, rad; clamped at 85 degrees.
        sensor: Which errs; None for a Kinect v2.
        fx: Focal length across, pixels; matters to stereo cameras.
    """
    sensor = KINECT_V2 if sensor is None else sensor
    t = np.minimum(angle, MAX_MODELLED_ANGLE)
    a0, a1, a2 = sensor.axial_with(fx)
    flat = a0 + a1 * depth + a2 * depth**2
    tilted = sensor.tilt * depth**1.5 * t**2 / (np.pi / 2 - t) ** 2
    return np.asarray(1e-3 * (flat + tilted))


# Axial: P. Fankhauser et al., "Kinect v2 for mobile robot navigation: evaluation and
# modeling", ICAR 2015; its angle term was measured on tilted planes, so it holds all
# that a smooth surface shows.
KINECT_V2 = DepthSensor()
# Range: Microsoft's hardware specification, NFOV unbinned; its random error is at most
# 17 mm. Axial: G. Kurillo et al., Sensors 22(7), 2022, found it comparable with the
# Kinect v2's up to 2.5 m and less beyond, so that one's formula is on the safe side.
AZURE_KINECT = DepthSensor(far=3.86)
# Error: z^2 d / (f B), with d below 0.1 pixels on textured targets and B = 50 mm, from
# the maker's papers on tuning. The range is ours. Grain and jitter are
# our own: a matching window is 9 pixels wide, its middle counts most.
REALSENSE_D435 = DepthSensor(
    near=0.3,
    far=3.0,
    axial=(0.0, 0.0, 0.0),
    tilt=0.0,
    disparity=0.08,
    baseline=0.05,
    grain=5,
    lateral=1.0,
)

CAMERA_MODELS = {
    "kinect_v2": CameraModel(PinholeCamera(), KINECT_V2),
    # One unit's calibration (Azure-Kinect-Sensor-SDK, issue 1617), cut to NFOV as the
    # SDK does: 1024 times the stored numbers, less 192 columns and 180 rows.
    "azure_kinect": CameraModel(
        PinholeCamera(640, 576, 503.847, 503.738, 321.511, 328.978), AZURE_KINECT
    ),
    # Ideal: f = width / (2 tan(HFOV / 2)) with the 90 degrees of the maker's papers.
    "realsense_d435": CameraModel(
        PinholeCamera(848, 480, 424.0, 424.0, 424.0, 240.0), REALSENSE_D435
    ),
}
