"""Makes the washing strokes of models/demonstrations/strokes.

A stroke is written down as a hand would be told it: legs, each a length and the
angle it turns through. The numbers are invented; nobody was recorded. Each take of a
stroke has its own size, slant, place, wobble and pace, and its sensor's noise.

Run as ``python -m bath_drake.demonstrations.strokes OUT_DIR``.
"""

import sys
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bath_drake.files import write_atomically
from bath_drake.notation import FloatArray
from bath_drake.yaml_io import dump_yaml

SEED = 24

# (length, angle turned through to the left, degrees); lengths are relative.
Leg = tuple[float, float]


@dataclass(frozen=True)
class Stroke:
    """A stroke as it is meant.

    Attributes:
        name: Of its files, without the take's number.
        heading: Direction of its start, degrees, from the person's right to the head.
        legs: What follows, in turn.
        size: Longest side of its box, m.
        takes: How many demonstrations.
    """

    name: str
    heading: float
    legs: tuple[Leg, ...]
    size: float
    takes: int


def _bends(straight: float, bend: float, turns: Sequence[float]) -> tuple[Leg, ...]:
    """Straight legs with a bend of the given length between any two."""
    legs: list[Leg] = [(straight, 0.0)]
    for turn in turns:
        legs += [(bend, turn), (straight, 0.0)]
    return tuple(legs)


def _spiral(rounds: int, first: float, last: float) -> tuple[Leg, ...]:
    """Half rounds to the left, radii from the first to the last in even steps."""
    radii = np.linspace(first, last, 2 * rounds)
    return tuple((float(np.pi * radius), 180.0) for radius in radii)


_LOOP: tuple[Leg, ...] = ((0.7, -40), (1, 400))
STROKES = (
    Stroke("line_across", 0, ((1, 0),), 0.38, 3),
    Stroke("line_down", -90, ((1, 0),), 0.45, 4),
    Stroke("line_diagonal", -50, ((1, 0),), 0.42, 3),
    Stroke("arc_shallow", 28, ((1, -56),), 0.40, 3),
    Stroke("arc_half", 90, ((1, -180),), 0.40, 5),
    Stroke("horseshoe", 135, ((1, -270),), 0.36, 4),
    Stroke("s_curve", 160, ((1, 220), (1, -220)), 0.44, 5),
    Stroke("s_lying", 70, ((1, -140), (1, 140)), 0.42, 4),
    Stroke("sine", 60, ((1, -120), (1, 120), (1, -120)), 0.40, 3),
    Stroke("wave", 50, ((1, -100), (1, 100), (1, -100), (1, 100)), 0.42, 4),
    Stroke("chevron", -60, _bends(1, 0.15, [120]), 0.38, 4),
    Stroke("w", -70, _bends(1, 0.15, [140, -140, 140]), 0.40, 5),
    Stroke("step", 0, _bends(1, 0.25, [-90, 90, -90]), 0.40, 4),
    Stroke("zigzag", -15, _bends(1, 0.12, [-150, 150]), 0.38, 5),
    Stroke("zigzag_long", -15, _bends(1, 0.12, [-150, 150, -150, 150, -150]), 0.45, 6),
    Stroke("raster", 0, _bends(1, 0.3, [-180, 180, -180]), 0.40, 5),
    Stroke("back_and_forth", 0, _bends(1, 0.1, [-174, 174, -174, 174]), 0.36, 7),
    Stroke("u_turn", -90, _bends(1, 0.8, [180]), 0.42, 4),
    Stroke("hook_left", -90, ((1, 0), (0.7, -200)), 0.42, 5),
    Stroke("hook_right", -90, ((1, 0), (0.5, 130), (0.35, 90)), 0.42, 5),
    Stroke("question_mark", 100, ((1, -230), (0.5, 140), (0.5, 0)), 0.45, 4),
    Stroke("c_tail", 150, ((1.2, 240), (0.5, -150), (0.3, 0)), 0.40, 4),
    Stroke("spiral_in", 90, _spiral(2, 1.0, 0.25), 0.40, 5),
    Stroke("spiral_out", 180, _spiral(2, 0.25, 1.0), 0.40, 5),
    Stroke("ribbon", -30, ((0.6, 0), (1.3, 240), (0.6, 0)), 0.42, 4),
    Stroke("loop", 0, ((0.6, 0), (1.3, 360), (0.6, 0)), 0.44, 4),
    Stroke(
        "loops", 20, ((0.7, -40), (1, 400), (0.7, -80), (1, 400), (0.7, -40)), 0.46, 6
    ),
    Stroke("figure_eight", 45, ((2, 0), (4.7, -270), (2, 0), (4, 230)), 0.44, 3),
    Stroke("circle", 180, ((1, 345),), 0.36, 5),
    Stroke("oval", 170, ((1, 20), (0.6, 160), (1, 20), (0.6, 150)), 0.42, 4),
)

# Bends begin and end over this share of the stroke's length.
ROUNDING = 0.04
# Points of the meant curve.
FINE = 2001
# The hand slows in bends as the cube root of curvature (Lacquaniti, Terzuolo and
# Viviani 1983), from about this radius as a share of the stroke's length.
SLOWING_RADIUS = 0.12
ROWS = (100, 151)
# Mean speed of a take, m/s.
SPEED = (0.10, 0.18)
# Standard deviations of a take: turned by (rad), each side stretched by, sheared by;
# moved by, in m; wobble of each of three waves, as a share of the size.
TURN, STRETCH, SHEAR, PLACE, WOBBLE = 0.05, 0.05, 0.04, 0.008, 0.008
# The sensor's, m.
NOISE = 0.0005
# Share by which the pace rises and falls.
UNEVENNESS = 0.15


def meant_curve(stroke: Stroke) -> tuple[FloatArray, FloatArray]:
    """A stroke as it is meant, centred.

    Returns:
        Points at equal steps of arc length, shape (n, 2), m, and the direction at
        each, shape (n,), rad.
    """
    lengths, turns = np.array(stroke.legs).T
    along = np.r_[0.0, np.cumsum(lengths)] / lengths.sum()
    angles = stroke.heading + np.r_[0.0, np.cumsum(turns)]
    heading = np.radians(np.interp(np.linspace(0.0, 1.0, FINE), along, angles))
    # A hand cannot bend at once: directions are averaged over a window.
    reach = round(0.5 * ROUNDING * FINE)
    window = np.hanning(2 * reach + 1)
    padded = np.pad(heading, reach, mode="reflect", reflect_type="odd")
    heading = np.convolve(padded, window / window.sum(), mode="valid")
    steps = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    points = np.concatenate([np.zeros((1, 2)), np.cumsum(steps[1:], axis=0)])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = stroke.size / float((high - low).max())
    return scale * (points - (low + high) / 2.0), heading


def make_take(
    stroke: Stroke, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Makes one demonstration of a stroke.

    Returns:
        Times, shape (n,), s, from 0, and points, shape (n, 2), m, x to the person's
        right and y to the head.
    """
    points, heading = meant_curve(stroke)
    points = perturbed(points, stroke.size, rng)
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    duration = length / rng.uniform(*SPEED)
    count = int(rng.integers(*ROWS))
    t = np.linspace(0.0, duration, count)
    # A tracker's clock: no two intervals alike, the order kept.
    t[1:-1] += rng.uniform(-0.2, 0.2, count - 2) * duration / (count - 1)
    taken = hand_at(points, heading, t / duration, rng)
    return t, taken + rng.normal(0.0, NOISE, taken.shape)


def hand_at(
    points: FloatArray,
    heading: FloatArray,
    share: FloatArray,
    rng: np.random.Generator,
) -> FloatArray:
    """Where a hand is at shares (n,) of its time, shape (n, 2), m.

    Args:
        points: The curve it follows, shape (FINE, 2), m.
        heading: Direction at each of its points, shape (FINE,), rad.
        share: From 0 to 1.
        rng: For the unevenness of its pace.
    """
    wanted = _progress(share, rng)
    # What each point costs in time: more in bends.
    bend = np.gradient(heading, 1.0 / (FINE - 1)) * SLOWING_RADIUS
    cost = np.cumsum((1.0 + bend**2) ** (1.0 / 6.0))
    cost = (cost - cost[0]) / (cost[-1] - cost[0])
    return np.stack([np.interp(wanted, cost, p) for p in points.T], axis=-1)


def perturbed(points: FloatArray, size: float, rng: np.random.Generator) -> FloatArray:
    """Points turned, stretched, sheared and moved a little, with a slow wobble."""
    angle = rng.normal(0.0, TURN)
    cos, sin = np.cos(angle), np.sin(angle)
    stretch = np.diag(1.0 + rng.normal(0.0, STRETCH, 2))
    stretch[0, 1] = rng.normal(0.0, SHEAR)
    turned = points @ (np.array([[cos, -sin], [sin, cos]]) @ stretch).T
    share = np.linspace(0.0, 1.0, len(points))
    waves = np.arange(1, 4)
    phases = rng.uniform(0.0, 2.0 * np.pi, (2, 3))
    sizes = rng.normal(0.0, WOBBLE * size, (2, 3))
    angles = np.pi * share[:, None, None] * waves + phases
    wobble = (sizes * np.sin(angles)).sum(axis=-1)
    perturbed: FloatArray = turned + wobble + rng.normal(0.0, PLACE, 2)
    return perturbed


def _progress(share: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Share of the stroke done at a share of the time: minimum jerk, uneven pace."""
    swing = 2.0 * np.pi * (share + rng.uniform())
    uneven = rng.uniform(0.0, UNEVENNESS)
    share = share + uneven * (np.sin(swing) - np.sin(swing[0])) / (2.0 * np.pi)
    share = np.clip(share, 0.0, 1.0)
    done: FloatArray = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    return done


def write_strokes(folder: str | Path, seed: int = SEED) -> list[Path]:
    """Writes line_across_1.csv ... and the .yaml beside each; returns the CSVs.

    A stroke's numbers hang on its name and the seed alone, not on the other strokes.

    Raises:
        BathDrakeError: When the folder cannot be written to.
    """
    folder = Path(folder)
    metadata = dump_yaml(
        {
            "frame": "back",
            "who": "nobody: synthetic",
            "licence": "CC0-1.0",
            "synthetic": True,
            "generator": "python -m bath_drake.demonstrations.strokes",
            "seed": seed,
        }
    )
    written = []
    for stroke in STROKES:
        own = zlib.crc32(stroke.name.encode())
        for number in range(1, stroke.takes + 1):
            t, points = make_take(stroke, np.random.default_rng([seed, own, number]))
            rows = np.column_stack([t, points])
            # Rounding hides the last bits of the mathematics library: the files are
            # the same on every machine. Adding zero turns -0.0 into 0.0.
            rows = np.round(rows, 5) + 0.0
            lines = [f"{t:.4f},{x:.5f},{y:.5f}" for t, x, y in rows]
            path = folder / f"{stroke.name}_{number}.csv"
            write_atomically(path, "\n".join(["t_s,x_m,y_m", *lines, ""]))
            write_atomically(path.with_suffix(".yaml"), metadata)
            written.append(path)
    return written


def main(arguments: Sequence[str]) -> int:
    """Writes the strokes into the one folder named; returns an exit code."""
    if len(arguments) != 1 or not Path(arguments[0]).is_dir():
        print(
            "usage: python -m bath_drake.demonstrations.strokes OUT_DIR "
            "(an existing folder)",
            file=sys.stderr,
        )
        return 2
    print(f"{len(write_strokes(arguments[0]))} demonstrations in {arguments[0]}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
