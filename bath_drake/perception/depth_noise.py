"""What a real sensor makes of a perfect depth image."""

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from bath_drake.notation import FloatArray, IntArray
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.depth_sensor import (
    KINECT_V2,
    NOWHERE,
    DepthSensor,
    axial_deviation,
)
from bath_drake.perception.random_bits import (
    NORMAL_BITS,
    frame_key,
    normal_quantiles,
    pixel_bits,
    scrambled,
)

DepthImage = NDArray[np.float32]

_LATERAL_BITS = 12
_COSINE_STEPS = 4096

_AXIAL = normal_quantiles(NORMAL_BITS)
_LATERAL = normal_quantiles(_LATERAL_BITS)
# The tilted term's factor over the square of the angle's cosine: no pixel needs acos.
_ANGLES = np.arccos(np.sqrt(np.linspace(0.0, 1.0, _COSINE_STEPS + 1)))
_TILTS = axial_deviation(np.ones(1), _ANGLES) - axial_deviation(np.ones(1), np.zeros(1))
_NO_TILTS = np.zeros(0)
_NO_GRAIN = np.zeros((0, 0), dtype=np.float32)


def noisy_depth(
    depth: DepthImage,
    camera: PinholeCamera,
    *,
    seed: int,
    frame: int,
    sensor: DepthSensor = KINECT_V2,
) -> DepthImage:
    """Returns what the sensor reports of a perfect depth image.

    Args:
        depth: (H, W), m along the optical axis; 0 and infinity are no depth.
        camera: The camera that saw it.
        seed: Not negative, of the whole recording.
        frame: Not negative. The same frame of the same seed has the same noise.
        sensor: How it errs.

    Returns:
        (H, W), m, whole steps of the sensor's resolution; 0 where nothing is measured.

    Raises:
        ValueError: If the image is not of this camera's size, or seed or frame is
            negative.
    """
    if depth.shape != camera.shape:
        raise ValueError(f"depth must have shape {camera.shape}, got {depth.shape}")
    key = frame_key(seed, frame)
    seen = np.ascontiguousarray(depth, dtype=np.float32)
    grains = _NO_GRAIN
    if sensor.grain > 1:
        # A sum of so many independent numbers; its deviation is the window's side.
        size = (sensor.grain, sensor.grain)
        shares = _AXIAL / np.float32(sensor.grain)
        own = _normal_image(np.uint64(scrambled(key)), camera.shape, shares)
        grains = np.asarray(
            cv2.boxFilter(own, -1, size, dst=own, normalize=False), dtype=np.float32
        )
    measured: DepthImage = _measure(
        _rimmed(seen, camera.fx * sensor.baseline),
        key,
        np.round(sensor.lateral * _LATERAL).astype(np.int64),
        (camera.fx, camera.fy, camera.cx, camera.cy),
        (sensor.near, sensor.far, sensor.resolution),
        (sensor.edge, sensor.jump),
        (sensor.flying, sensor.lost, float(np.cos(sensor.grazing) ** 2)),
        sensor.axial_with(camera.fx),
        _AXIAL,
        grains,
        _TILTS * (sensor.tilt / KINECT_V2.tilt) if sensor.tilt > 0.0 else _NO_TILTS,
    )
    return measured


@njit(cache=True)
def _normal_image(
    key: np.uint64, shape: tuple[int, int], normal: DepthImage
) -> DepthImage:
    rows, columns = shape
    pixels = rows * columns
    out = np.empty(pixels, dtype=np.float32)
    # 64 bits are enough for four.
    for group in range((pixels + 3) // 4):
        bits = pixel_bits(key, group)
        for pixel in range(4 * group, min(4 * group + 4, pixels)):
            out[pixel] = normal[bits & np.uint64(0x3FFF)]
            bits >>= np.uint64(14)
    return out.reshape(rows, columns)


@njit(cache=True, error_model="numpy")
def _rimmed(depth: DepthImage, disparity_depth: float) -> DepthImage:
    """The image with a rim that repeats its border; without depth is `NOWHERE`.

    With a disparity (pixels, at a metre) what only the left eye sees has no depth:
    seen from further right, what is nearer moves further left, so a pixel is hidden
    where one to its right comes to lie left of it.
    """
    rows, columns = depth.shape
    nowhere = np.float32(NOWHERE)
    z = np.empty((rows + 2, columns + 2), dtype=np.float32)
    for v in range(rows):
        for u in range(columns):
            here = depth[v, u]
            z[v + 1, u + 1] = here if here > 0.0 and here < nowhere else nowhere
        if disparity_depth > 0.0:
            leftmost = np.inf
            for u in range(columns, 0, -1):
                there = u - disparity_depth / z[v + 1, u]
                if there < leftmost:
                    # Where there is nothing, nothing hides anything.
                    leftmost = there if z[v + 1, u] < nowhere else leftmost
                else:
                    z[v + 1, u] = nowhere
    z[:, 0], z[:, -1] = z[:, 1], z[:, -2]
    z[0], z[-1] = z[1], z[-2]
    return z


# Python's own min and max ask for NaN, and are not vectorised.
@njit(cache=True)
def _least(a: float, b: float, c: float) -> float:
    d = a if a < b else b
    return d if d < c else c


@njit(cache=True)
def _greatest(a: float, b: float, c: float) -> float:
    d = a if a > b else b
    return d if d > c else c


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
    key: np.uint64,
    lateral: IntArray,
    intrinsics: tuple[float, float, float, float],
    limits: tuple[float, float, float],
    edges: tuple[float, float],
    losses: tuple[float, float, float],
    coefficients: tuple[float, float, float],
    axial: DepthImage,
    grains: DepthImage,
    tilts: FloatArray,
) -> DepthImage:
    rows, columns = z.shape[0] - 2, z.shape[1] - 2
    fx, fy, cx, cy = intrinsics
    near, far, resolution = limits
    edge, jump = edges
    flying, lost, least_cosine2 = losses
    a0, a1, a2 = coefficients
    per_fx, per_step = 1.0 / fx, 1.0 / resolution
    out = np.zeros((rows, columns), dtype=np.float32)
    # The nearest and farthest of three rows, then of three columns of those.
    low, high = np.empty_like(z[0]), np.empty_like(z[0])
    for v in range(rows):
        for u in range(columns + 2):
            a, b, c = z[v, u], z[v + 1, u], z[v + 2, u]
            low[u], high[u] = _least(a, b, c), _greatest(a, b, c)
        y = (v + 0.5 - cy) / fy
        for u in range(columns):
            depth = float(z[v + 1, u + 1])
            bits = pixel_bits(key, v * columns + u)
            across, down = _slopes(z, v, u)
            nearest = float(_least(low[u], low[u + 1], low[u + 2]))
            farthest = float(_greatest(high[u], high[u + 1], high[u + 2]))
            gap = farthest - nearest
            if gap > edge:
                # Where another surface is near, the sampled place may show it.
                dv = lateral[(bits >> np.uint64(14)) & np.uint64(0xFFF)]
                du = lateral[(bits >> np.uint64(26)) & np.uint64(0xFFF)]
                i = min(max(v + dv, 0), rows - 1)
                j = min(max(u + du, 0), columns - 1)
                there = float(z[i + 1, j + 1])
                plane = depth + across * (j - u) + down * (i - v)
                if abs(there - plane) > edge:
                    depth = there
                    across, down = _slopes(z, i, j)
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
            deviation = 1e-3 * (a0 + a1 * depth + a2 * depth * depth)
            if tilts.size > 0:
                tilt = tilts[int(min(cosine2, 1.0) * _COSINE_STEPS + 0.5)]
                deviation += depth * np.sqrt(depth) * tilt
            if grains.size > 0:
                depth += deviation * grains[v, u]
            else:
                depth += deviation * axial[bits & np.uint64(0x3FFF)]
            if gap > jump + 2.0 * (abs(across) + abs(down)):
                fate = float(bits >> np.uint64(38)) * 2.0**-26
                if fate < lost:
                    continue
                if fate < lost + flying and farthest < NOWHERE:
                    share = float(scrambled(bits) >> np.uint64(11)) * 2.0**-53
                    depth = nearest + share * gap
            if depth >= near and depth <= far:
                out[v, u] = np.floor(depth * per_step + 0.5) * resolution
    return out
