"""A stroke with circles on top comes apart; one without is left alone."""

import numpy as np
import pytest

from bath_drake.benchmarks.composites import random_composite
from bath_drake.demonstrations.processing import (
    canonical_demonstrations,
    resample_by_arc_length,
)
from bath_drake.demonstrations.recording import read_recording
from bath_drake.demonstrations.separation import separate
from bath_drake.demonstrations.strokes import STROKES, make_take
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.resources import models_folder

RECORDINGS = sorted((models_folder() / "demonstrations").rglob("*_1.csv"))
DISCRETE = [path for path in RECORDINGS if not path.name.startswith("scrubbing")]


@pytest.mark.parametrize("seed", range(50))
def test_a_composite_comes_apart(seed):
    made = random_composite(np.random.default_rng([2025, seed]))
    found = separate(made.t, made.points)
    ways = [
        resample_by_arc_length(made.t, p, 200)[1]
        for p in (found.discrete, made.discrete)
    ]
    # The bounds: 0.02 of the stroke's longest side, 3 % of the period.
    side = np.ptp(made.discrete, axis=0).max()
    assert discrete_frechet(*ways) <= 0.02 * side
    assert found.period == pytest.approx(made.period, rel=0.03)
    # A tenth: noise of 1.5 mm on cycles of 15 mm.
    assert found.amplitude == pytest.approx(made.amplitude, rel=0.1)


@pytest.mark.parametrize("path", DISCRETE, ids=lambda path: path.stem)
def test_a_stroke_without_cycles_comes_back_unchanged(path):
    recording = read_recording(path)
    found = separate(recording.t, recording.points)
    assert found.period is None
    np.testing.assert_array_equal(found.discrete, recording.points)
    assert not found.periodic.any()
    assert not found.phase.any()
    assert found.cycles == 0.0


def test_no_other_take_of_the_discrete_strokes_has_cycles():
    for number, stroke in enumerate(STROKES):
        t, points = make_take(stroke, np.random.default_rng([99, number]))
        assert separate(t, points).period is None, stroke.name


def test_tremor_and_noise_are_no_cycles(rng):
    t = np.arange(0.0, 8.0, 1.0 / 60.0)
    line = np.column_stack([0.05 * t, 0.0 * t])
    tremor = 0.002 * np.sin(2.0 * np.pi * 6.0 * t + np.array([[0.0], [1.0]])).T
    noise = rng.normal(0.0, 0.002, line.shape)
    assert separate(t, line + tremor + noise).period is None


def test_the_plane_of_circles_in_space_is_found(rng):
    t = np.arange(0.0, 10.0, 1.0 / 30.0)
    x, y = np.linalg.qr(rng.normal(size=(3, 3)))[0][:2]
    turn = 2.0 * np.pi * t[:, None]
    points = 0.03 * t[:, None] * x + 0.04 * np.cos(turn) * x + 0.02 * np.sin(turn) * y
    found = separate(t, points)
    # No noise: what is left is the trend's own bend, under a hundredth.
    assert abs(found.plane[0] @ x) == pytest.approx(1.0, abs=1e-3)
    assert abs(found.plane[1] @ y) == pytest.approx(1.0, abs=1e-3)
    assert found.amplitude == pytest.approx(0.04, rel=0.02)
    assert found.period == pytest.approx(1.0, rel=0.01)


def test_cycles_in_the_middle_are_nowhere_else():
    t = np.arange(0.0, 16.0, 1.0 / 30.0)
    fade = np.clip(np.minimum(t - 4.0, 12.0 - t) + 0.5, 0.0, 1.0)
    fade = fade**2 * (3.0 - 2.0 * fade)
    line = np.column_stack([0.025 * t, 0.1 * np.sin(0.2 * t)])
    circles = 0.03 * np.column_stack([np.cos(7.0 * t), np.sin(7.0 * t)])
    found = separate(t, line + fade[:, None] * circles)
    assert found.period == pytest.approx(2.0 * np.pi / 7.0, rel=0.03)
    away = (t < 2.5) | (t > 13.5)
    # A tenth of the cycle's amplitude.
    assert np.abs(found.periodic[away]).max() <= 0.003
    assert np.abs(found.discrete - line).max() <= 0.006


def test_a_drift_of_the_rate_is_followed():
    t = np.arange(0.0, 12.0, 1.0 / 30.0)
    rate = 1.0 + 0.2 * (t / 6.0 - 1.0)
    turns = np.cumsum(rate) / 30.0
    points = np.column_stack([0.03 * t, 0.04 * np.sin(2.0 * np.pi * turns)])
    found = separate(t, points)
    measured = np.gradient(found.phase, t) / (2.0 * np.pi)
    # The middle half: at the ends a polynomial's slope is worst.
    middle = slice(len(t) // 4, -len(t) // 4)
    np.testing.assert_allclose(measured[middle], rate[middle], rtol=0.02)
    assert found.drift == pytest.approx(0.2, abs=0.05)


def test_canonical_demonstrations_keep_the_cycles_beside_the_stroke(tmp_path):
    made = random_composite(np.random.default_rng([2025, 3]))
    rows = np.column_stack([made.t, made.points])
    path = tmp_path / "wash.csv"
    lines = ["t_s,x_m,y_m", *(",".join(f"{v:.7g}" for v in row) for row in rows)]
    path.write_text("\n".join(lines))
    (demonstration,), frame = canonical_demonstrations([read_recording(path)])
    part = demonstration.periodic
    assert part.period == pytest.approx(made.period, rel=0.03)
    raw = frame.to_canonical(made.points)
    stroke = np.stack(
        [
            np.interp(part.times, demonstration.times, column)
            for column in demonstration.points.T
        ],
        axis=-1,
    )
    # The whole is the sum of its parts, noise (1.5 mm) and smoothing apart.
    gap = np.linalg.norm(stroke + part.offsets - raw, axis=1)
    assert np.quantile(gap, 0.95) <= 0.004 / frame.scales[0]


def test_shapes_that_do_not_go_together_are_refused():
    with pytest.raises(ValueError, match="must have shapes"):
        separate(np.zeros(5), np.zeros((6, 2)))
