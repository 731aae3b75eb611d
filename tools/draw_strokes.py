"""Draws every stroke of models/demonstrations/strokes into docs/strokes.png.

Run as ``python tools/draw_strokes.py``.
"""

import math
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt

from bath_drake.demonstrations.recording import read_recording
from bath_drake.demonstrations.strokes import STROKES, meant_curve

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / "models" / "demonstrations" / "strokes"
COLUMNS = 6
# m, of each picture's side.
SIDE = 0.56


def main() -> None:
    """Writes docs/strokes.png."""
    rows = math.ceil(len(STROKES) / COLUMNS)
    figure, axes = plt.subplots(
        rows, COLUMNS, figsize=(1.7 * COLUMNS, 1.8 * rows), layout="constrained"
    )
    for axis in axes.flat:
        axis.set_axis_off()
    for axis, stroke in zip(axes.flat, STROKES, strict=False):
        axis.plot(*meant_curve(stroke)[0].T, color="0.75", linewidth=4)
        for take in range(1, stroke.takes + 1):
            points = read_recording(FOLDER / f"{stroke.name}_{take}.csv").points
            axis.plot(*points.T, linewidth=0.8)
            axis.plot(*points[0], "o", color="0.2", markersize=3)
        axis.set_title(f"{stroke.name} ({stroke.takes})", fontsize=8)
        axis.set_aspect("equal")
        axis.set_xlim(-SIDE / 2, SIDE / 2)
        axis.set_ylim(-SIDE / 2, SIDE / 2)
    last = axes.flat[(rows - 1) * COLUMNS]
    last.plot([-0.25, -0.15], [-0.27, -0.27], color="black", linewidth=2)
    last.text(-0.20, -0.26, "0.1 m", ha="center", va="bottom", fontsize=7)
    figure.savefig(ROOT / "docs" / "strokes.png", dpi=110)


if __name__ == "__main__":
    main()
