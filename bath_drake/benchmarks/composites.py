"""Strokes with circles or scrubbing on top, made with known truth."""

from dataclasses import dataclass

import numpy as np

from bath_drake.notation import FloatArray


@dataclass(frozen=True)
class Composite:
    """A hand's path and what it is made of; metres and seconds."""

    t: FloatArray
    points: FloatArray
    discrete: FloatArray
    period: float
    amplitude: float


def random_composite(rng: np.random.Generator, hard: bool = False) -> Composite:
    """A slow stroke of 20 to 50 cm with 8 to 25 cycles of 1.5 to 6 cm on top.

    Line, arc, sine or S; circle, ellipse, straight scrubbing or figure of eight; the
    rate drifts by up to 20 %, to one side or to and fro; 15 to 100 samples a second
    with up to 1.5 mm of noise. Hard ones have from 5 cycles on, which set in and end
    within the stroke.
    """
    duration, rate = rng.uniform(6.0, 20.0), rng.choice([15.0, 30.0, 60.0, 100.0])
    t = np.arange(0.0, duration, 1.0 / rate)
    t[1:-1] += rng.uniform(-0.2, 0.2, len(t) - 2) / rate
    share = t / t[-1]
    hand = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    stroke = _turned(rng, _stroke(rng, hand if rng.random() < 0.5 else share))
    cycles = rng.uniform(5.0 if hard else 8.0, min(25.0, t[-1] / 0.5))
    drift = rng.uniform(-0.2, 0.2)
    if rng.random() < 0.5:
        turns = cycles * (share + 0.5 * drift * (share**2 - share))
    else:
        turns = cycles * (share + drift * np.sin(2.0 * np.pi * share) / (2.0 * np.pi))
    amplitude = rng.uniform(0.015, 0.06)
    cycle = _turned(rng, amplitude * _cycle(rng, 2.0 * np.pi * (turns + rng.random())))
    period = float(t[-1] / cycles)
    if hard:
        first, last = rng.uniform(0.0, 0.15), rng.uniform(0.85, 1.0)
        fade = np.clip(np.minimum(share - first, last - share) / 0.08, 0.0, 1.0)
        cycle = cycle * (fade**2 * (3.0 - 2.0 * fade))[:, None]
        # The rate drifts: the mean is that of the part that is there.
        there = np.flatnonzero(fade >= 0.5)[[0, -1]]
        period = float(np.diff(t[there])[0] / np.diff(turns[there])[0])
    noise = rng.normal(0.0, rng.uniform(2e-4, 1.5e-3), stroke.shape)
    return Composite(t, stroke + cycle + noise, stroke, period, amplitude)


def _stroke(rng: np.random.Generator, s: FloatArray) -> FloatArray:
    length, kind = rng.uniform(0.2, 0.5), rng.integers(4)
    if kind == 0:
        return length * np.column_stack([s, 0.0 * s])
    if kind == 1:
        bend = rng.uniform(0.5, 2.5)
        return length * np.column_stack([np.sin(bend * s), 1 - np.cos(bend * s)]) / bend
    if kind == 2:
        wave = np.sin(2.0 * np.pi * rng.uniform(0.5, 1.0) * s)
        return length * np.column_stack([s, rng.uniform(0.1, 0.3) * wave])
    return length * np.column_stack([s, 0.3 * np.tanh(3.0 * (s - 0.5))])


def _cycle(rng: np.random.Generator, phase: FloatArray) -> FloatArray:
    kind = rng.integers(4)
    if kind == 0:
        return np.column_stack([np.cos(phase), rng.choice([-1, 1]) * np.sin(phase)])
    if kind == 1:
        flat = rng.uniform(0.2, 0.8)
        return np.column_stack([np.cos(phase), flat * np.sin(phase)])
    if kind == 2:
        return np.column_stack([np.cos(phase), 0.0 * phase])
    return np.column_stack([np.cos(phase), 0.5 * np.sin(2.0 * phase)])


def _turned(rng: np.random.Generator, points: FloatArray) -> FloatArray:
    angle = rng.uniform(0.0, 2.0 * np.pi)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.asarray(points @ np.array([[cos, sin], [-sin, cos]]))
