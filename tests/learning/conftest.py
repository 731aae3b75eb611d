"""Strokes to learn from."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from bath_drake.learning.strokes import resample
from bath_drake.notation import FloatArray


@dataclass(frozen=True)
class PlainStroke:
    """The least that the learner asks of a demonstration."""

    name: str
    points: FloatArray
    sha256: str = "0" * 64


def _sinusoid(periods: float) -> FloatArray:
    t = np.linspace(0.0, 1.0, 300)
    return np.stack([1.5 * t - 0.75, 0.35 * np.sin(2 * np.pi * periods * t)], axis=-1)


def _arc(angle: float, radius: float) -> FloatArray:
    t = np.pi / 2 + angle * (np.linspace(0.0, 1.0, 300) - 0.5)
    return radius * np.stack([-np.cos(t), np.sin(t)], axis=-1) - [0.0, 0.5 * radius]


def _letter_s() -> FloatArray:
    a = np.linspace(0.1 * np.pi, 1.5 * np.pi, 150)
    b = np.linspace(0.5 * np.pi, -0.9 * np.pi, 150)
    upper = [0.0, 0.35] + 0.35 * np.stack([np.cos(a), np.sin(a)], axis=-1)
    lower = [0.0, -0.35] + 0.35 * np.stack([np.cos(b), np.sin(b)], axis=-1)
    return np.concatenate([upper, lower[1:]])


def _letter_j() -> FloatArray:
    a = np.linspace(0.0, -np.pi, 150)
    stem = np.stack([np.full(150, 0.35), np.linspace(0.75, -0.3, 150)], axis=-1)
    hook = np.stack([0.35 * np.cos(a), -0.3 + 0.4 * np.sin(a)], axis=-1)
    return np.concatenate([stem, hook[1:]])


def _zigzag() -> FloatArray:
    x = np.array([-0.75, -0.4, -0.05, 0.3, 0.7])
    y = np.array([-0.3, 0.35, -0.35, 0.35, -0.2])
    sharp = resample(np.stack([x, y], axis=-1), 300)
    window = np.hanning(41) / np.hanning(41).sum()
    padded = np.pad(sharp, ((20, 20), (0, 0)), mode="reflect", reflect_type="odd")
    columns = [np.convolve(padded[:, k], window, "valid") for k in range(2)]
    return np.stack(columns, axis=-1)


def _loop() -> FloatArray:
    t = np.linspace(0.0, 1.0, 300)
    bump = 0.5 * np.sin(np.pi * t)
    x = 1.4 * t - 0.7 + bump * np.sin(4 * np.pi * t)
    return np.stack([x, -bump * np.cos(4 * np.pi * t)], axis=-1)


SHAPES: dict[str, Callable[[], FloatArray]] = {
    "one period": lambda: _sinusoid(1.0),
    "one and a half periods": lambda: _sinusoid(1.5),
    "two periods": lambda: _sinusoid(2.0),
    "C": lambda: _arc(1.1 * np.pi, 0.65),
    "wide arc": lambda: _arc(0.7 * np.pi, 0.8),
    "S": _letter_s,
    "J": _letter_j,
    "zigzag": _zigzag,
    "line": lambda: np.linspace([-0.75, -0.15], [0.75, 0.15], 100),
    "loop": _loop,
}

MakeStrokes = Callable[..., list[PlainStroke]]


@pytest.fixture
def make_strokes() -> MakeStrokes:
    """Noisy repetitions of a named shape: make_strokes(shape, seed, count=3)."""

    def make(shape: str, seed: int, count: int = 3) -> list[PlainStroke]:
        rng = np.random.default_rng(seed)
        base = resample(SHAPES[shape](), 300)
        t = np.linspace(0.0, 1.0, 300)[:, None]
        strokes = []
        for i in range(count):
            # Width +-2 %, amplitude +-10 %, ends 0.012 off, slow wobble of 0.004.
            points = base * [1.0 + rng.normal(0.0, 0.02), 1.0 + rng.uniform(-0.1, 0.1)]
            points = points + rng.normal(0.0, 0.012, 2) * (1.0 - t)
            points = points + rng.normal(0.0, 0.012, 2) * t
            waves = rng.uniform(1.0, 4.0, (2, 4))
            phase = rng.uniform(0.0, 2.0 * np.pi, (2, 4))
            size = rng.normal(0.0, 0.004, (2, 4))
            wobble = size * np.sin(2 * np.pi * waves * t[..., None] + phase)
            strokes.append(PlainStroke(f"{shape} {i}", points + wobble.sum(axis=-1)))
        return strokes

    return make
