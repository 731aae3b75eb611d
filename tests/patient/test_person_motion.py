"""How a person moves: from rest, within bounds, about the hips."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.patient.motion import MotionConfig, check_motion, person_displacement

HIPS = np.array([0.0, -0.1, 0.5])
BACK = np.array([0.0, 1.0, 0.0])
MOTION = MotionConfig()


def test_the_motion_starts_from_rest():
    h = 1e-3
    R, p = person_displacement(0.0, MOTION, HIPS, BACK)
    np.testing.assert_array_equal(R, np.eye(3))
    np.testing.assert_allclose(p, 0.0, atol=1e-16)  # cancels but for rounding
    # The ramp starts with zero velocity: 1 ms later nothing has moved a micron.
    _, later = person_displacement(h, MOTION, HIPS, BACK)
    assert np.abs(later).max() < 1e-6


@given(t=st.floats(0.0, 1e4))
def test_breath_alone_moves_along_its_direction_and_within_its_amplitude(t):
    breath = MotionConfig(twist_amplitude=0.0, lean_amplitude=0.0)
    R, p = person_displacement(t, breath, HIPS, BACK)
    np.testing.assert_array_equal(R, np.eye(3))
    np.testing.assert_allclose(p[[0, 2]], 0.0, atol=1e-15)
    assert abs(p[1]) <= breath.breath_amplitude * (1.0 + 1e-9)


@given(t=st.floats(0.0, 1e4))
def test_twist_and_lean_keep_the_hips_where_they_are(t):
    turning = MotionConfig(breath_amplitude=0.0)
    R, p = person_displacement(t, turning, HIPS, BACK)
    np.testing.assert_allclose(R @ HIPS + p, HIPS, atol=1e-12)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    angle = np.arccos(np.clip((np.trace(R) - 1.0) / 2.0, -1.0, 1.0))
    assert angle <= np.hypot(turning.twist_amplitude, turning.lean_amplitude) + 1e-9


def test_the_amplitudes_are_reached():
    times = np.linspace(10.0, 150.0, 5000)
    R = np.array([person_displacement(t, MOTION, HIPS, BACK)[0] for t in times])
    lean = np.arctan2(R[:, 2, 1], R[:, 2, 2])
    # Sampled every 28 ms, the crests of 23 s and 29 s periods are not missed.
    assert np.abs(lean).max() == pytest.approx(MOTION.lean_amplitude, rel=1e-3)
    twist = np.arctan2(R[:, 1, 0], R[:, 0, 0])
    assert np.abs(twist).max() == pytest.approx(MOTION.twist_amplitude, rel=1e-3)


def test_the_back_never_moves_faster_than_the_arm_can_follow():
    shoulder, h = np.array([0.15, -0.05, 1.05]), 0.01
    track = []
    for t in np.arange(0.0, 120.0, h):
        R, p = person_displacement(t, MOTION, HIPS, BACK)
        track.append(R @ shoulder + p)
    speed = np.linalg.norm(np.diff(track, axis=0), axis=1) / h
    assert speed.max() < 0.04  # m/s, a third of the arm's speed limit


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("breath_amplitude", -0.01),
        ("breath_amplitude", 0.5),
        ("breath_frequency", float("nan")),
        ("twist_period", 0.0),
        ("lean_amplitude", 2.0),
        ("lean_period", float("-inf")),
        ("ramp", -1.0),
        ("twist_phase", float("inf")),
    ],
)
def test_impossible_motions_are_refused_by_name(field, value):
    with pytest.raises(ValueError, match=field):
        check_motion(MotionConfig(**{field: value}))
