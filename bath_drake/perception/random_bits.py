"""Random numbers a pixel: the same frame of the same seed has the same ones."""

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import ndtri

# Random bits pick normal quantiles: tables that stay in the processor's first cache.
# The extremes are at 4 sigma.
NORMAL_BITS = 14


def frame_key(seed: int, frame: int, *stream: int) -> np.uint64:
    """Returns what the bits of a frame are made from.

    Args:
        seed: Not negative, of the whole recording.
        frame: Not negative.
        stream: Tells uses apart that must not share their numbers.

    Raises:
        ValueError: If seed or frame is negative.
    """
    if seed < 0 or frame < 0:
        raise ValueError(f"seed and frame must be >= 0, got {seed} and {frame}")
    sequence = np.random.SeedSequence([seed, frame, *stream])
    return np.uint64(sequence.generate_state(1, np.uint64)[0])


def normal_quantiles(bits: int) -> NDArray[np.float32]:
    """Returns (2^bits,) equally likely values of a standard normal variable."""
    count = 2**bits
    quantiles: NDArray[np.float32] = ndtri((np.arange(count) + 0.5) / count).astype(
        np.float32
    )
    return quantiles


@njit(cache=True)
def scrambled(x: np.uint64) -> np.uint64:
    """SplitMix64's finaliser (Steele et al., OOPSLA 2014): 64 independent bits."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@njit(cache=True)
def pixel_bits(key: np.uint64, pixel: int) -> np.uint64:
    """Returns the 64 bits of a frame's pixel, counted by row."""
    return scrambled(key + np.uint64(pixel + 1) * np.uint64(0x9E3779B97F4A7C15))
