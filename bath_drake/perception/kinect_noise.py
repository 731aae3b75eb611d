"""The depth noise of a Kinect v2: what a real sensor makes of a perfect depth image.

Axial noise is the model of P. Fankhauser et al., "Kinect v2 for mobile robot
navigation: evaluation and modeling", ICAR 2015; its angle term was measured on tilted
planes, so it holds all that a smooth surface shows. At edges the sampled place jitters
(lateral noise) and depths of both sides mix (flying pixels): no published formula is
known to us, the shares there are our own.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import ndtri

from bath_drake.notation import FloatArray, IntArray
from bath_drake.perception.camera import PinholeCamera

DepthImage = NDArray[np.float32]

# Beyond this angle the published formula has no measurements and grows without bound.
_MAX_MODELLED_ANGLE = np.deg2rad(85.0)
# Random bits pick normal quantiles: tables that stay in the processor's first cache.
# The extremes of the axial noise are at 4 sigma.
_AXIAL_BITS, _LATERAL_BITS = 14, 12
_COSINE_STEPS = 4096
# What has no depth stands farther off than anything that has.
_NOWHERE = 1e3


@dataclass(frozen=True)
class KinectNoise:
    """The numbers of the model; the defaults are a Kinect v2.

    Attributes:
        near: Nearest depth it reports, m.
        far: Farthest depth it reports, m.
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
    lateral: float = 0.5
    edge: float = 0.01
    jump: float = 0.06
    flying: float = 0.35
    lost: float = 0.15
    grazing: float = float(np.deg2rad(80.0))
    resolution: float = 0.001

    def __post_init__(self) -> None:
        for name in ("near", "edge", "jump", "resolution"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be positive, got {value}")
        if not self.near < self.far < _NOWHERE:
            raise ValueError(f"far must be beyond near ({self.near}), got {self.far}")
        if not 0.0 <= self.lateral < 10.0:
            raise ValueError(f"lateral must be in [0, 10) pixels, got {self.lateral}")
        if not (min(self.flying, self.lost) >= 0.0 and self.flying + self.lost <= 1.0):
            raise ValueError(
                "flying and lost must be shares of at most 1 together, got "
                f"{self.flying} and {self.lost}"
            )
        if not 0.0 < self.grazing <= np.pi / 2:
            raise ValueError(f"grazing must be in (0, pi/2] rad, got {self.grazing}")


KINECT_V2 = KinectNoise()


def axial_deviation(depth: FloatArray, angle: FloatArray) -> FloatArray:
    """Returns the standard deviation of a measured depth, m (Fankhauser et al.).

    Args:
        depth: Along the optical axis, m.
        angle: Between the ray and the surface's normal, rad; clamped at 85 degrees.
    """
    t = np.minimum(angle, _MAX_MODELLED_ANGLE)
    flat = 1.5 - 0.5 * depth + 0.3 * depth**2
    tilted = 0.1 * depth**1.5 * t**2 / (np.pi / 2 - t) ** 2
    return np.asarray(1e-3 * (flat + tilted))


def _normal_quantiles(bits: int) -> DepthImage:
    count = 2**bits
    quantiles: DepthImage = ndtri((np.arange(count) + 0.5) / count).astype(np.float32)
    return quantiles


_AXIAL = _normal_quantiles(_AXIAL_BITS)
_LATERAL = _normal_quantiles(_LATERAL_BITS)
# The tilted term's factor over the square of the angle's cosine: no pixel needs acos.
_ANGLES = np.arccos(np.sqrt(np.linspace(0.0, 1.0, _COSINE_STEPS + 1)))
_TILTS = axial_deviation(np.ones(1), _ANGLES) - axial_deviation(np.ones(1), np.zeros(1))


def noisy_depth(
    depth: DepthImage,
    camera: PinholeCamera,
    *,
    seed: int,
    frame: int,
    noise: KinectNoise = KINECT_V2,
) -> DepthImage:
    """Returns what the sensor reports of a perfect depth image.

    Args:
        depth: (H, W), m along the optical axis; 0 and infinity are no depth.
        camera: The camera that saw it.
        seed: Not negative, of the whole recording.
        frame: Not negative. The same frame of the same seed has the same noise.
        noise: The sensor.

    Returns:
        (H, W), m, whole steps of the sensor's resolution; 0 where nothing is measured.

    Raises:
        ValueError: If the image is not of this camera's size, or seed or frame is
            negative.
    """
    if depth.shape != camera.shape:
        raise ValueError(f"depth must have shape {camera.shape}, got {depth.shape}")
    if seed < 0 or frame < 0:
        raise ValueError(f"seed and frame must be >= 0, got {seed} and {frame}")
    key = np.random.SeedSequence([seed, frame]).generate_state(1, np.uint64)
    measured: DepthImage = _measure(
        *_neighbourhoods(np.ascontiguousarray(depth, dtype=np.float32)),
        key[0],
        np.round(noise.lateral * _LATERAL).astype(np.int64),
        (camera.fx, camera.fy, camera.cx, camera.cy),
        (noise.near, noise.far, noise.resolution),
        (noise.edge, noise.jump),
        (noise.flying, noise.lost, float(np.cos(noise.grazing) ** 2)),
        _AXIAL,
        _TILTS,
    )
    return measured


@njit(cache=True, error_model="numpy")
def _neighbourhoods(depth: DepthImage) -> tuple[DepthImage, DepthImage, DepthImage]:
    """The image with a rim, and each pixel's nearest and farthest depth in 3 x 3.

    The rim repeats the image's border; pixels without depth are `_NOWHERE`.
    """
    rows, columns = depth.shape
    nowhere = np.float32(_NOWHERE)
    z = np.full((rows + 2, columns + 2), nowhere)
    nearest, farthest = np.empty_like(depth), np.empty_like(depth)
    # Minima and maxima of three rows, then of three columns of those.
    low, high = np.empty_like(z[0]), np.empty_like(z[0])
    for v in range(rows):
        for u in range(columns):
            here = depth[v, u]
            z[v + 1, u + 1] = here if here > 0.0 and here < nowhere else nowhere
    z[:, 0], z[:, -1] = z[:, 1], z[:, -2]
    z[0], z[-1] = z[1], z[-2]
    for v in range(rows):
        for u in range(columns + 2):
            a, b, c = z[v, u], z[v + 1, u], z[v + 2, u]
            low[u] = min(a, b, c)
            high[u] = max(a, b, c)
        for u in range(columns):
            nearest[v, u] = min(low[u], low[u + 1], low[u + 2])
            farthest[v, u] = max(high[u], high[u + 1], high[u + 2])
    return z, nearest, farthest


@njit(cache=True)
def _scrambled(x: np.uint64) -> np.uint64:
    """SplitMix64's finaliser (Steele et al., OOPSLA 2014): 64 independent bits."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@njit(cache=True)
def _slopes(z: DepthImage, v: int, u: int) -> tuple[float, float]:
    """Depth a pixel to the right and down, at pixel (v, u) of the rimmed image.

    Each is the smaller one-sided difference: an edge on one side tilts no skin.
    """
    here = z[v + 1, u + 1]
    left, right = here - z[v + 1, u], z[v + 1, u + 2] - here
    above, below = here - z[v, u + 1], z[v + 2, u + 1] - here
    across = left if abs(left) < abs(right) else right
    down = above if abs(above) < abs(below) else below
    return float(across), float(down)


@njit(cache=True, error_model="numpy")
def _measure(
    z: DepthImage,
    nearest: DepthImage,
    farthest: DepthImage,
    key: np.uint64,
    lateral: IntArray,
    intrinsics: tuple[float, float, float, float],
    limits: tuple[float, float, float],
    edges: tuple[float, float],
    losses: tuple[float, float, float],
    axial: DepthImage,
    tilts: FloatArray,
) -> DepthImage:
    rows, columns = nearest.shape
    fx, fy, cx, cy = intrinsics
    near, far, resolution = limits
    edge, jump = edges
    flying, lost, least_cosine2 = losses
    per_fx, per_step = 1.0 / fx, 1.0 / resolution
    out = np.zeros((rows, columns), dtype=np.float32)
    for v in range(rows):
        y = (v + 0.5 - cy) / fy
        for u in range(columns):
            depth = float(z[v + 1, u + 1])
            counter = np.uint64(v * columns + u + 1) * np.uint64(0x9E3779B97F4A7C15)
            bits = _scrambled(key + counter)
            across, down = _slopes(z, v, u)
            gap = float(farthest[v, u]) - float(nearest[v, u])
            if gap > edge:
                # Where another surface is near, the sampled place may show it.
                dv = lateral[(bits >> np.uint64(14)) & np.uint64(0xFFF)]
                du = lateral[(bits >> np.uint64(26)) & np.uint64(0xFFF)]
                a = min(max(v + dv, 0), rows - 1)
                b = min(max(u + du, 0), columns - 1)
                there = float(z[a + 1, b + 1])
                plane = depth + across * (b - u) + down * (a - v)
                if abs(there - plane) > edge:
                    depth = there
                    across, down = _slopes(z, a, b)
            if depth > far + 1.0:
                continue
            # Cross product of the surface's derivatives along the image's axes.
            x = (u + 0.5 - cx) * per_fx
            n0, n1 = -across * fx, -down * fy
            n2 = depth - n0 * x - n1 * y
            normal2 = n0 * n0 + n1 * n1 + n2 * n2
            cosine2 = depth * depth / (normal2 * (x * x + y * y + 1.0))
            if cosine2 < least_cosine2:
                continue
            tilt = tilts[int(min(cosine2, 1.0) * _COSINE_STEPS + 0.5)]
            deviation = 1e-3 * (1.5 - 0.5 * depth + 0.3 * depth * depth)
            deviation += depth * np.sqrt(depth) * tilt
            depth += deviation * axial[bits & np.uint64(0x3FFF)]
            if gap > jump + 2.0 * (abs(across) + abs(down)):
                fate = float(bits >> np.uint64(38)) * 2.0**-26
                if fate < lost:
                    continue
                if fate < lost + flying and farthest[v, u] < _NOWHERE:
                    share = float(_scrambled(bits) >> np.uint64(11)) * 2.0**-53
                    depth = nearest[v, u] + share * gap
            if depth >= near and depth <= far:
                out[v, u] = np.floor(depth * per_step + 0.5) * resolution
    return out
