"""Makes demonstrations like the paper's first experiment (section IV-A).

A carer pours water across a back in a sinusoidal stroke of 1.5 periods, three
times: each take has its own speed, amplitude, ends and hand tremor. The numbers
are invented; only the shape of the stroke is the paper's.

Run as ``python -m bath_drake.demonstrations.synthetic OUT_DIR``.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bath_drake.demonstrations.metadata import BodyBox
from bath_drake.files import write_atomically
from bath_drake.notation import FloatArray
from bath_drake.yaml_io import dump_yaml

SEED = 20
BACK_WIDTH = 0.40
BACK_HEIGHT = 0.50
# Radii of curvature of the back across and along the spine, m.
BACK_RADII = (0.30, 0.90)
PERIODS = 1.5
# The stroke runs from -HALF_LENGTH to HALF_LENGTH in x: 0.68 in canonical space.
HALF_LENGTH = 0.136
SAMPLE_RATE_HZ = 60.0
TREMOR_HZ = (4.0, 12.0)
# Each tremor is a sum of this many tones in each direction.
TREMOR_TONES = 4


@dataclass(frozen=True)
class Take:
    """What differs between one stroke and the next.

    Attributes:
        duration: s.
        amplitude: Of the sinusoid, m.
        tremor: Root mean square of the hand tremor in each direction, m.
        unevenness: Share by which the speed along the stroke rises and falls.
    """

    duration: float
    amplitude: float
    tremor: float
    unevenness: float


TAKES = (
    Take(duration=7.0, amplitude=0.078, tremor=0.0008, unevenness=0.10),
    Take(duration=8.5, amplitude=0.073, tremor=0.0012, unevenness=0.18),
    Take(duration=5.8, amplitude=0.083, tremor=0.0006, unevenness=0.14),
)
# The ends of the takes scatter by this much in each direction, m.
END_SCATTER = 0.004


def back_box() -> BodyBox:
    """The box of the back: its centre is the origin, its axes are the frame's."""
    return BodyBox(np.zeros(3), np.eye(3), np.array([BACK_WIDTH, BACK_HEIGHT]))


def back_height(xy: FloatArray) -> FloatArray:
    """Height z of the gently curved back over its plane, m; xy has shape (..., 2)."""
    drop: FloatArray = np.sum(xy**2 / (2.0 * np.array(BACK_RADII)), axis=-1)
    return -drop


def stroke(phase: FloatArray, amplitude: float) -> FloatArray:
    """The stroke without tremor, in the plane of the back.

    Args:
        phase: Share of the way across, shape (n,), from 0 to 1.
        amplitude: Of the sinusoid, m.

    Returns:
        Points, shape (n, 2), m.
    """
    x = HALF_LENGTH * (2.0 * phase - 1.0)
    return np.stack([x, amplitude * np.sin(2.0 * np.pi * PERIODS * phase)], axis=-1)


def make_take(take: Take, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Makes one recording.

    Returns:
        Times, shape (n,), s, from 0, and points in the back's frame P (x to the
        person's right, y to the head, z out of the body), shape (n, 3), m.
    """
    count = round(take.duration * SAMPLE_RATE_HZ) + 1
    t = np.linspace(0.0, take.duration, count)
    # A tracker's clock: no two intervals alike, the order kept.
    t[1:-1] += rng.uniform(-0.2, 0.2, count - 2) / SAMPLE_RATE_HZ
    share = t / take.duration
    # From rest to rest (minimum jerk), with an uneven speed in between.
    swing = 2.0 * np.pi * (2.0 * share + rng.uniform())
    swing_share = take.unevenness * (np.sin(swing) - np.sin(swing[0])) / (4.0 * np.pi)
    share = share + swing_share
    phase = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    xy = stroke(phase, take.amplitude)
    first, last = rng.uniform(-END_SCATTER, END_SCATTER, (2, 2))
    xy = xy + np.outer(1.0 - phase, first) + np.outer(phase, last)
    points = np.concatenate([xy, back_height(xy)[:, None]], axis=-1)
    return t, points + tremor(t, take.tremor, rng)


def tremor(t: FloatArray, size: float, rng: np.random.Generator) -> FloatArray:
    """Hand tremor, shape (n, 3), m, with root mean square `size` in each direction."""
    tones = (TREMOR_TONES, 3)
    frequency = rng.uniform(*TREMOR_HZ, tones)
    angle = rng.uniform(0.0, 2.0 * np.pi, tones)
    sines = np.sin(2.0 * np.pi * frequency * t[:, None, None] + angle)
    tremor: FloatArray = size * np.sqrt(2.0 / TREMOR_TONES) * np.sum(sines, axis=1)
    return tremor


def write_demonstrations(folder: str | Path, seed: int = SEED) -> list[Path]:
    """Writes back_sinusoid_1.csv ... and the .yaml beside each; returns the CSVs.

    Raises:
        BathDrakeError: When the folder cannot be written to.
    """
    folder = Path(folder)
    metadata = synthetic_metadata("synthetic", seed)
    written = []
    for number, take in enumerate(TAKES, start=1):
        t, points = make_take(take, np.random.default_rng([seed, number]))
        path = folder / f"back_sinusoid_{number}.csv"
        write_take(path, t, points, metadata)
        written.append(path)
    return written


def write_take(
    path: Path, t: FloatArray, points: FloatArray, metadata: dict[str, object]
) -> None:
    """Writes a recording, times (n,) and points (n, 3), and the .yaml beside it."""
    rows = np.column_stack([t, points])
    # Micrometres are finer than any tracker, and hide the last bits of the
    # mathematics library: the files are the same on every machine. Adding
    # zero turns -0.0 into 0.0.
    lines = [",".join(f"{v:.6f}" for v in np.round(row, 6) + 0.0) for row in rows]
    write_atomically(path, "\n".join(["t_s,x_m,y_m,z_m", *lines, ""]))
    write_atomically(path.with_suffix(".yaml"), dump_yaml(metadata))


def synthetic_metadata(module: str, seed: int) -> dict[str, object]:
    """What the .yaml beside a recording made by a module of this room says."""
    box = back_box()
    return {
        "frame": "back",
        "body_box": {
            "centre": box.centre.tolist(),
            "axes": box.axes.tolist(),
            "extents": box.extents.tolist(),
        },
        "who": "nobody: synthetic",
        "licence": "CC0-1.0",
        "synthetic": True,
        "generator": f"python -m bath_drake.demonstrations.{module}",
        "seed": seed,
    }


def main(arguments: Sequence[str]) -> int:
    """Writes the demonstrations into the one folder named; returns an exit code."""
    if len(arguments) != 1 or not Path(arguments[0]).is_dir():
        print(
            "usage: python -m bath_drake.demonstrations.synthetic OUT_DIR "
            "(an existing folder)",
            file=sys.stderr,
        )
        return 2
    for path in write_demonstrations(arguments[0]):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
