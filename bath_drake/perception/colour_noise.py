"""What a real sensor makes of a perfect colour image.

Light is noisy where it is counted: the deviation of a pixel is that of its electrons
(shot noise) and of the reading (read noise), both before the image is gamma-encoded.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bath_drake.notation import ByteArray, FloatArray
from bath_drake.perception.random_bits import (
    NORMAL_BITS,
    frame_key,
    normal_quantiles,
    pixel_bits,
)

_NORMAL = normal_quantiles(NORMAL_BITS)
# So that colour and depth of one frame do not share their numbers.
_STREAM = 1
_DRIFT_STREAM = 2
_GAMMA = 2.2
_LEVELS = 4096
# From light, in steps of a 4096th, to bytes.
_ENCODED = np.round(
    255.0 * (np.arange(_LEVELS + 1) / _LEVELS) ** (1.0 / _GAMMA)
).astype(np.uint8)
_LIGHT = (np.arange(256) / 255.0) ** _GAMMA


@dataclass(kw_only=True)
class ColourNoiseConfig:
    """The colour camera's noise, exposure and white balance; our own choices.

    The full well is that of a small sensor at a little gain, as in a bright room.
    """

    exposure: float = 1.0  # factor of the light; more than white is white
    full_well: float = 4000.0  # electrons of white: shot noise is its square root
    read: float = 8.0  # electrons, standard deviation
    white_balance: float = 0.03  # largest share by which red and blue drift
    drift_period: float = 20.0  # s


def check_colour_noise(config: ColourNoiseConfig) -> None:
    """Raises ValueError naming the field that makes no camera."""
    limits = {
        "exposure": (0.01, 100.0),
        "full_well": (10.0, 1e7),
        "read": (0.0, 1e4),
        "white_balance": (0.0, 0.5),
        "drift_period": (0.1, 1e6),
    }
    for name, (low, high) in limits.items():
        value = getattr(config, name)
        if not low <= value <= high:
            raise ValueError(f"{name}: found {value}, allowed {low:g} to {high:g}")


def white_balance(config: ColourNoiseConfig, *, seed: int, t: float) -> FloatArray:
    """Returns the factors (3,) of red, green and blue at a time, s.

    Red and blue swing on their own, slowly; the seed says where they begin.
    """
    begin = np.random.default_rng([seed, _DRIFT_STREAM]).uniform(0.0, 2.0 * np.pi, 2)
    # No common multiple worth waiting for.
    turns = 2.0 * np.pi * t / (config.drift_period * np.array([1.0, 1.37]))
    red, blue = 1.0 + config.white_balance * np.sin(begin + turns)
    return np.array([red, 1.0, blue])


def noisy_colour(
    colour: ByteArray, config: ColourNoiseConfig, *, seed: int, frame: int, t: float
) -> ByteArray:
    """Returns what the sensor reports of a perfect colour image.

    Args:
        colour: (H, W, 3 or 4), RGB and what else there is, which stays.
        config: The sensor.
        seed: Not negative, of the whole recording.
        frame: Not negative. The same frame of the same seed has the same noise.
        t: When the frame is taken, s: the white balance drifts.

    Returns:
        The image, of the same shape.

    Raises:
        ValueError: If seed or frame is negative.
    """
    key = frame_key(seed, frame, _STREAM)
    gains = config.exposure * white_balance(config, seed=seed, t=t)
    light = gains[:, None] * _LIGHT
    electrons = config.full_well * light + config.read**2
    deviation = np.sqrt(electrons) / config.full_well
    # In steps of the encoding table, for all that a byte can be.
    noisy: ByteArray = _expose(
        np.ascontiguousarray(colour),
        key,
        (_LEVELS * light).astype(np.float32),
        (_LEVELS * deviation).astype(np.float32),
        _NORMAL,
        _ENCODED,
    )
    return noisy


@njit(cache=True)
def _expose(
    colour: ByteArray,
    key: np.uint64,
    light: NDArray[np.float32],
    deviation: NDArray[np.float32],
    normal: NDArray[np.float32],
    encoded: ByteArray,
) -> ByteArray:
    rows, columns, _ = colour.shape
    brightest = encoded.size - 1
    out = colour.copy()
    for v in range(rows):
        for u in range(columns):
            bits = pixel_bits(key, v * columns + u)
            for c in range(3):
                byte = colour[v, u, c]
                own = normal[(bits >> np.uint64(14 * c)) & np.uint64(0x3FFF)]
                level = int(light[c, byte] + deviation[c, byte] * own + 0.5)
                out[v, u, c] = encoded[min(max(level, 0), brightest)]
    return out
