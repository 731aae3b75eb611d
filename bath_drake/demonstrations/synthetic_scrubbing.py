"""Makes demonstrations of scrubbing: small ovals on a slow stroke down the back.

Like those of `bath_drake.demonstrations.synthetic`, on the same back: the paper leaves
periodic motion to future work, the numbers are invented, and nobody was recorded. Each
take has its own speed, size, ends, tremor, and a rate that drifts.

Run as ``python -m bath_drake.demonstrations.synthetic_scrubbing OUT_DIR``.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bath_drake.demonstrations.synthetic import (
    END_SCATTER,
    SAMPLE_RATE_HZ,
    back_height,
    synthetic_metadata,
    tremor,
    write_take,
)
from bath_drake.notation import FloatArray

SEED = 26
# The slow stroke runs from the right shoulder to the left of the loins, m.
HALF_WIDTH, HALF_HEIGHT = 0.10, 0.13
# Half axes of the oval, m, and the direction of the longer one.
OVAL, ANGLE = (0.026, 0.014), np.radians(35.0)
# The cycles grow and fade over this share of the stroke.
FADE = 0.06


@dataclass(frozen=True)
class ScrubbingTake:
    """What differs between one demonstration and the next.

    Attributes:
        duration: s.
        cycles: How many ovals.
        size: By which the oval is larger than it is meant.
        drift: How much the rate grows over the stroke, as a share of its mean.
        start: Where on the oval the hand begins, rad.
        tremor: Root mean square in each direction, m.
    """

    duration: float
    cycles: float
    size: float
    drift: float
    start: float
    tremor: float


TAKES = (
    ScrubbingTake(14.0, 12.5, 1.00, 0.10, 0.3, 0.0006),
    ScrubbingTake(12.2, 11.6, 1.08, -0.12, 2.1, 0.0009),
    ScrubbingTake(15.5, 13.1, 0.94, 0.05, 4.4, 0.0005),
)


def slow_stroke(share: FloatArray) -> FloatArray:
    """The stroke without ovals at shares (n,) of its time, shape (n, 2), m."""
    x = HALF_WIDTH * (2.0 * share - 1.0)
    return np.stack([x, HALF_HEIGHT * np.cos(np.pi * share)], axis=-1)


def ovals(take: ScrubbingTake, share: FloatArray) -> FloatArray:
    """What the ovals add at shares (n,) of the time, shape (n, 2), m."""
    turns = take.cycles * (share + 0.5 * take.drift * (share**2 - share))
    phase = 2.0 * np.pi * turns + take.start
    fade = np.clip(np.minimum(share, 1.0 - share) / FADE, 0.0, 1.0)
    fade = fade**2 * (3.0 - 2.0 * fade)
    along, across = OVAL[0] * np.cos(phase), OVAL[1] * np.sin(phase)
    cos, sin = np.cos(ANGLE), np.sin(ANGLE)
    oval = np.stack([cos * along - sin * across, sin * along + cos * across], axis=-1)
    return np.asarray(take.size * fade[:, None] * oval)


def make_take(
    take: ScrubbingTake, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Makes one recording: times (n,), s, and points (n, 3), m, in the back's frame."""
    count = round(take.duration * SAMPLE_RATE_HZ) + 1
    t = np.linspace(0.0, take.duration, count)
    t[1:-1] += rng.uniform(-0.2, 0.2, count - 2) / SAMPLE_RATE_HZ
    share = t / take.duration
    first, last = rng.uniform(-END_SCATTER, END_SCATTER, (2, 2))
    xy = slow_stroke(share) + ovals(take, share)
    xy = xy + np.outer(1.0 - share, first) + np.outer(share, last)
    points = np.concatenate([xy, back_height(xy)[:, None]], axis=-1)
    return t, points + tremor(t, take.tremor, rng)


def write_scrubbing(folder: str | Path, seed: int = SEED) -> list[Path]:
    """Writes scrubbing_1.csv ... and the .yaml beside each; returns the CSVs.

    Raises:
        BathDrakeError: When the folder cannot be written to.
    """
    metadata = synthetic_metadata("synthetic_scrubbing", seed)
    written = []
    for number, take in enumerate(TAKES, start=1):
        t, points = make_take(take, np.random.default_rng([seed, number]))
        path = Path(folder) / f"scrubbing_{number}.csv"
        write_take(path, t, points, metadata)
        written.append(path)
    return written


def main(arguments: Sequence[str]) -> int:
    """Writes the demonstrations into the one folder named; returns an exit code."""
    if len(arguments) != 1 or not Path(arguments[0]).is_dir():
        print(
            "usage: python -m bath_drake.demonstrations.synthetic_scrubbing OUT_DIR "
            "(an existing folder)",
            file=sys.stderr,
        )
        return 2
    for path in write_scrubbing(arguments[0]):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
