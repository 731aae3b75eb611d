import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bath_drake.control.reference import next_reference

NUMBER = st.floats(-2.0, 2.0)
POINT = st.tuples(NUMBER, NUMBER).map(np.array)
LEASH = st.floats(0.01, 0.5)


def step(reference, position, velocity, *, dt=0.01, leash=0.08, pull=0.5):
    return next_reference(reference, position, velocity, dt=dt, leash=leash, pull=pull)


@given(reference=POINT, position=POINT, velocity=POINT, leash=LEASH)
def test_it_never_leaves_the_leash(reference, position, velocity, leash):
    ahead = step(reference, position, velocity, leash=leash)
    # Numbers up to 2 and a difference of them: a few 1e-16.
    assert np.linalg.norm(ahead - position) <= leash + 1e-14


@given(reference=POINT, velocity=POINT)
def test_a_perfect_arm_leaves_the_papers_euler_step(reference, velocity):
    velocity = velocity / 2.0  # 0.014 a step: within the leash
    ahead = step(reference, reference, velocity)
    np.testing.assert_allclose(ahead, reference + 0.01 * velocity, atol=1e-15)


@given(position=POINT, offset=POINT)
@settings(max_examples=20)
def test_without_flow_it_converges_to_the_measured_point(position, offset):
    reference, distance = position + 0.03 * offset, np.inf
    for _ in range(500):
        reference = step(reference, position, np.zeros(2))
        closer = np.linalg.norm(reference - position)
        assert closer <= distance + 1e-15
        distance = closer
    # The first step may cut it to the leash; 499 take 0.5 * 0.01 of it each.
    assert distance <= 0.995**499 * 0.08 + 1e-12


def test_the_pull_is_a_rate():
    reference, position = np.array([0.05, 0.0]), np.zeros(2)
    for _ in range(200):  # 2 s at 0.5/s
        reference = step(reference, position, np.zeros(2))
    # Euler's (1 - 0.005)^200 against exp(-1): 0.25 % apart.
    assert reference[0] / 0.05 == pytest.approx(np.exp(-1.0), rel=3e-3)


def test_an_arm_that_stands_still_is_waited_for():
    reference, position = np.zeros(2), np.zeros(2)
    for _ in range(2000):
        reference = step(reference, position, np.array([0.3, 0.0]))
    # The leash cuts after each step, whatever the flow: it is reached exactly.
    np.testing.assert_allclose(reference, [0.08, 0.0], atol=1e-12)


def test_an_arm_that_lags_steadily_is_led_by_a_steady_distance():
    reference, position, flow = np.zeros(2), np.zeros(2), np.array([0.2, 0.0])
    leads = []
    for _ in range(3000):
        reference = step(reference, position, flow)
        position = position + 0.01 * 4.0 * (reference - position)
        leads.append(reference[0] - position[0])
    # Lead d with d' = 0.2 - 0.5 d - 4 d = 0; Euler and the order of the two
    # updates within a step shift it by one step's worth, 4 %.
    assert leads[-1] == pytest.approx(0.2 / 4.5, rel=0.05)
    assert np.ptp(leads[-500:]) < 1e-9


def test_the_arguments_stay_untouched():
    arguments = [np.array([0.5, 0.1]), np.zeros(2), np.array([1.0, 0.0])]
    kept = [a.copy() for a in arguments]
    step(*arguments)
    for argument, copy in zip(arguments, kept, strict=True):
        np.testing.assert_array_equal(argument, copy)
