"""Keeping links off things: the push in the null space, and the damper."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.control.avoidance import (
    AvoidanceConfig,
    bend,
    damped_share,
    push_away,
    reachable_share,
)

CONFIG = AvoidanceConfig()
number = st.floats(-1.0, 1.0)
velocity = st.lists(number, min_size=7, max_size=7).map(np.array)
row = st.tuples(st.floats(-0.1, 0.3), velocity).map(lambda r: np.append(r[0], r[1]))
rows = st.lists(row, min_size=1, max_size=9).map(np.array)


@given(v=velocity, rows=rows)
def test_no_link_nears_a_thing_faster_than_it_may(v, rows):
    share = damped_share(v, rows, CONFIG)
    assert 0.0 <= share <= 1.0
    nearing = -(rows[:, 1:] @ v) * share
    allowed = CONFIG.gain * np.maximum(rows[:, 0] - CONFIG.stop, 0.0)
    assert (nearing <= allowed + 1e-12).all()  # rounding


@given(v=velocity, rows=rows)
def test_what_nears_nothing_is_not_slowed(v, rows):
    rows[:, 1:] *= np.where(rows[:, 1:] @ v < 0.0, -1.0, 1.0)[:, None]
    assert damped_share(v, rows, CONFIG) == 1.0


@given(row=row)
def test_the_push_takes_a_near_link_away_and_leaves_a_far_one(row):
    push = push_away(row[None], CONFIG)
    assert np.abs(push).max() <= CONFIG.push * (1.0 + 1e-12)
    if row[0] >= CONFIG.near:
        np.testing.assert_array_equal(push, np.zeros(7))
    else:
        assert row[1:] @ push >= 0.0


def test_the_push_is_in_proportion_to_how_near_it_is():
    slope = np.array([0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0])
    for gap in (0.06, 0.05):
        push = push_away(np.append(gap, slope)[None], CONFIG)
        assert slope @ push == pytest.approx(CONFIG.gain * (CONFIG.near - gap))


def test_followed_by_the_damper_alone_nothing_comes_nearer_than_the_stop():
    gap, dt = 0.2, 0.005
    slope = np.array([0.4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    for _ in range(2000):
        v = np.array([-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        v = v * damped_share(v, np.append(gap, slope)[None], CONFIG)
        gap += dt * float(slope @ v)
        assert gap >= CONFIG.stop - 1e-12
    assert gap == pytest.approx(CONFIG.stop, abs=1e-6)


def test_nothing_near_is_nothing_to_heed():
    none = np.zeros((0, 8))
    np.testing.assert_array_equal(push_away(none, CONFIG), np.zeros(7))
    assert damped_share(np.ones(7), none, CONFIG) == 1.0


@pytest.mark.parametrize("name", ["stop", "near", "gain", "push"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_numbers_are_positive(name, value):
    with pytest.raises(ValueError, match=f"{name} must be positive"):
        AvoidanceConfig(**{name: value})


def test_the_stop_is_nearer_than_where_avoiding_begins():
    with pytest.raises(ValueError, match="near must be above stop"):
        AvoidanceConfig(stop=0.1, near=0.05)


JACOBIANS = st.integers(0, 1000).map(
    lambda seed: np.random.default_rng(seed).normal(size=(5, 7))
)


@given(v=velocity, J=JACOBIANS, rows=rows)
def test_what_is_added_in_the_null_space_moves_no_nozzle(v, J, rows):
    added = bend(v, J, rows, CONFIG)
    # The pseudo-inverse is good to rounding over the least singular value kept, 1/100.
    np.testing.assert_allclose(J @ added, 0.0, atol=1e-9 * (1.0 + np.abs(added).max()))


@given(v=velocity, J=JACOBIANS, row=row)
def test_one_near_link_is_kept_off_as_far_as_the_null_space_goes(v, J, row):
    after = v + bend(v, J, row[None], CONFIG)
    allowed = CONFIG.gain * max(row[0] - CONFIG.stop, 0.0)
    free = (np.eye(7) - np.linalg.pinv(J) @ J) @ row[1:]
    if free @ free > 1e-3:
        assert row[1:] @ after >= -allowed - 1e-9
    if row[1:] @ v >= -allowed:
        np.testing.assert_array_equal(after, v)


@given(start=velocity, change=velocity)
def test_the_reachable_share_keeps_within_the_bounds(start, change):
    low, high = np.full(7, -1.0), np.full(7, 1.0)
    share = reachable_share(start, change, low, high)
    assert 0.0 <= share <= 1.0
    after = start + share * change
    assert ((after >= low - 1e-12) & (after <= high + 1e-12)).all()
    if (np.abs(start + change) <= 1.0).all():
        assert share == pytest.approx(1.0)
