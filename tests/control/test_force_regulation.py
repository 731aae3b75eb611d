import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.control.approach import Phase
from bath_drake.control.force_regulation import (
    ForceLimits,
    ForceState,
    Touch,
    next_force_state,
    touch_phase,
)

LIMITS = ForceLimits()
DT = 0.005
FORCES = st.floats(-5.0, 50.0) | st.just(float("nan")) | st.just(float("inf"))


def step(state, force, *, phase=Phase.WASH, held=False, limits=LIMITS):
    return next_force_state(state, force, phase, held=held, dt=DT, limits=limits)


def press(skin_at, seconds, *, stiffness=450.0, state=None):
    """Presses on a spring that begins at a depth, with a lagging arm.

    The lag is that of the arm's tracking, a tenth of a second. Returns the states and
    forces.
    """
    state, arm, force, states, forces = state or ForceState(), 0.0, 0.0, [], []
    for k in range(round(seconds / DT)):
        state = step(state, force)
        arm += DT / 0.1 * (state.depth - arm)
        force = max(0.0, stiffness * (arm - skin_at(k * DT)))
        states.append(state)
        forces.append(force)
    return states, forces


@given(forces=st.lists(FORCES, max_size=300))
def test_whatever_is_felt_neither_way_nor_speed_nor_force_leaves_its_bounds(forces):
    state = ForceState()
    for force in forces:
        after = step(state, force)
        assert 0.0 <= after.depth <= LIMITS.deepest
        # 1e-12 m: one sum of numbers near 0.01.
        assert abs(after.depth - state.depth) <= LIMITS.speed * DT + 1e-12
        assert 0.0 <= after.asked <= LIMITS.force
        state = after


@pytest.mark.parametrize("skin", [0.004, 0.008, 0.015])
def test_it_comes_to_the_force_without_much_more(skin):
    states, forces = press(lambda t: skin, 6.0)
    assert forces[-1] == pytest.approx(LIMITS.force, abs=0.05)
    assert max(forces) < LIMITS.force + 1.0
    assert states[-1].washing


def test_skin_that_comes_and_goes_is_pressed_with_the_same_force():
    # Two millimetres in two seconds, what the surface estimate leaves over.
    _, forces = press(lambda t: 0.008 + 0.002 * math.sin(math.pi * t), 12.0)
    late = forces[len(forces) // 2 :]
    assert min(late) > LIMITS.force - 1.0
    assert max(late) < LIMITS.force + 1.0


def test_it_is_sought_slowly_until_it_is_felt():
    state = ForceState()
    for k in range(100):
        state = step(state, 0.0)
        assert state.touch is Touch.SEEK
        assert state.depth == pytest.approx((k + 1) * LIMITS.seek_speed * DT)
    assert step(state, LIMITS.felt).touch is Touch.PRESS


def test_nothing_winds_up_where_there_is_no_skin():
    states, _ = press(lambda t: 1.0, 10.0)
    assert states[-1].depth == LIMITS.deepest
    pressed = step(states[-1], 9.0)
    assert step(pressed, 9.0).depth < LIMITS.deepest


@pytest.mark.parametrize("phase", [Phase.REACH, Phase.DESCEND])
def test_who_has_not_come_down_seeks_nothing(phase):
    states, _ = press(lambda t: 0.008, 4.0)
    assert step(states[-1], 4.0, phase=phase) == ForceState()
    assert touch_phase(states[-1], phase) is phase


def test_a_hold_takes_it_away_from_the_skin_and_all_begins_anew():
    states, _ = press(lambda t: 0.008, 4.0)
    assert step(states[-1], 4.0, held=True) == ForceState()


def test_washing_waits_for_the_force_and_stops_when_it_is_lost():
    states, _ = press(lambda t: 0.008, 4.0)
    washes = [touch_phase(s, Phase.WASH) is Phase.WASH for s in states]
    assert not washes[0]
    assert washes[-1]
    state = states[-1]
    for _ in range(round(LIMITS.patience / DT) - 1):
        state = step(state, 0.0)
        assert touch_phase(state, Phase.WASH) is Phase.WASH
    for _ in range(3):
        state = step(state, 0.0)
    assert state.touch is Touch.SEEK
    assert touch_phase(state, Phase.WASH) is Phase.DESCEND


def test_skin_that_went_away_is_followed_no_faster_than_it_was_sought():
    states, _ = press(lambda t: 0.008, 4.0)
    after = step(states[-1], 0.0)
    assert after.depth - states[-1].depth <= LIMITS.seek_speed * DT + 1e-12


@pytest.mark.parametrize("force", [float("nan"), float("inf"), -float("inf")])
def test_a_force_that_is_no_number_takes_it_out(force):
    states, _ = press(lambda t: 0.008, 4.0)
    after = step(states[-1], force)
    assert after.depth < states[-1].depth
    assert not after.washing


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("force", 5.1),
        ("force", float("nan")),
        ("speed", 0.051),
        ("seek_speed", 0.0),
        ("admittance", -1.0),
        ("felt", 0.2),
        ("lost", 0.9),
    ],
)
def test_limits_out_of_their_range_are_refused(name, value):
    with pytest.raises(ValueError, match="must"):
        replace(LIMITS, **{name: value})
