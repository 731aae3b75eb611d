"""Roll-outs and times of chains: those of fields, from gate to gate."""

import hypothesis.strategies as st
import numpy as np
import pytest
from chains import gate_at, make, random_chain
from hypothesis import given, settings

from bath_drake.composition.chain import Chain, Gate
from bath_drake.composition.rollout import chain_rollout, chain_times
from bath_drake.composition.similarity import Similarity
from bath_drake.field.navigation import min_beta
from bath_drake.field.rollout import RolloutStatus, rollout, timed_rollout

SEEDS = st.integers(0, 2**32 - 1)


def free_start(chain, rng):
    while True:
        start = rng.uniform(-1.7, 1.7, 2)
        if min_beta(start, chain.fields[0]) > 0.05:
            return start


@settings(max_examples=25)
@given(SEEDS)
def test_a_chain_of_one_is_rolled_out_and_timed_as_its_field(seed):
    rng = np.random.default_rng(seed)
    chain = random_chain(rng, 1)
    start = free_start(chain, rng)
    found = chain_rollout(start, chain, step=0.02)
    alone = rollout(start, chain.fields[0], step=0.02)
    np.testing.assert_array_equal(found.path, alone.path)
    assert found.status is alone.status
    assert found.min_beta == alone.min_beta
    assert found.length == alone.length
    assert not found.stages.any()
    settings_of_time = {"speed": 0.1, "half_extents": (0.2, 0.3), "slow_radius": 0.2}
    timed = timed_rollout(start, chain.fields[0], step=0.02, **settings_of_time)
    times = chain_times(found, chain, **settings_of_time)
    np.testing.assert_array_equal(times, timed.times)


@settings(max_examples=25)
@given(SEEDS)
def test_each_stage_ends_at_the_first_point_in_its_gate(seed):
    rng = np.random.default_rng(seed)
    chain = random_chain(rng, 4)
    found = chain_rollout(free_start(chain, rng), chain, step=0.02)
    assert len(found.stages) == len(found.path)
    assert (np.diff(found.stages) >= 0).all()
    stage = 0
    for q, said in zip(found.path, found.stages, strict=True):
        stage = chain.stage_at(q, stage)
        assert stage == said
    if found.status is RolloutStatus.ARRIVED:
        assert found.stages[-1] == 3
        assert np.hypot(*(found.path[-1] - chain.goal)) <= 1e-3


@settings(max_examples=25)
@given(SEEDS)
def test_length_and_least_beta_are_those_along_the_path(seed):
    rng = np.random.default_rng(seed)
    chain = random_chain(rng)
    found = chain_rollout(free_start(chain, rng), chain, step=0.02)
    way = np.linalg.norm(np.diff(found.path, axis=0), axis=1)
    # Summed in another order: as many roundings as there are steps.
    assert found.length == pytest.approx(way.sum(), abs=1e-12)
    least = np.inf
    for k, field in enumerate(chain.fields):
        # The point at which the next field takes over is one of both.
        (at,) = np.nonzero(found.stages == k)
        if len(at):
            part = found.path[at[0] : at[-1] + 2]
            least = min(least, min_beta(part, field).min())
    assert found.min_beta == pytest.approx(least, rel=1e-12)


@settings(max_examples=15)
@given(SEEDS, st.floats(-3.0, 3.0), st.floats(0.5, 2.0))
def test_a_chain_moved_whole_takes_its_path_along(seed, turn, scale):
    rng = np.random.default_rng(seed)
    chain = random_chain(rng)
    start = free_start(chain, rng)
    found = chain_rollout(start, chain, step=0.02)
    by = Similarity(rng.normal(size=2), scale * np.exp(1j * turn), rng.normal(size=2))
    moved = chain_rollout(
        by.points(start),
        chain.moved((by,) * 3),
        step=0.02 * scale,
        goal_tolerance=1e-3 * scale,
    )
    assert moved.status is found.status
    if found.status is RolloutStatus.ARRIVED:
        # Beside saddles rounding grows, at most a thousandfold in these lengths; a
        # point on a gate's edge may make one step more or less in a stage.
        size = min(len(found.path), len(moved.path))
        assert abs(len(found.path) - len(moved.path)) <= 3
        np.testing.assert_allclose(
            moved.path[:size], by.points(found.path[:size]), atol=0.05 * scale
        )


def test_a_start_in_a_gate_begins_with_the_next_stage():
    fields = (make((0.0, 0.0)), make((1.0, 0.0)))
    chain = Chain(fields, (gate_at(fields[0].goal, 0.0),))
    found = chain_rollout([0.01, 0.01], chain)
    assert (found.stages == 1).all()
    np.testing.assert_array_equal(found.path, rollout([0.01, 0.01], fields[1]).path)


def test_a_start_in_an_obstacle_goes_nowhere():
    fields = (make((0.0, 0.0), [1.0, 1.0, 0.2, 0.2, 0.0]), make((1.0, 0.0)))
    chain = Chain(fields, (gate_at(fields[0].goal, 0.0),))
    found = chain_rollout([1.0, 1.1], chain)
    assert found.status is RolloutStatus.LEFT
    assert found.min_beta < 0.0
    assert len(found.path) == 1
    # Nor does one that comes through a gate into an obstacle of the next field.
    blocked = make((1.0, 0.0), [0.0, 0.0, 0.3, 0.3, 0.0])
    found = chain_rollout([-1.0, 0.1], Chain((fields[0], blocked), chain.gates))
    assert found.status is RolloutStatus.LEFT
    assert found.stages[-1] == 1


@pytest.mark.parametrize("steps", [1, 5, 30])
def test_steps_are_counted_over_all_stages(steps):
    fields = (make((0.0, 0.0)), make((0.2, 0.0)), make((1.5, 0.0)))
    gates = tuple(gate_at(f.goal, 0.0, 0.05) for f in fields[:2])
    found = chain_rollout(
        [-0.05, 0.0], Chain(fields, gates), step=0.02, max_steps=steps
    )
    assert found.status is RolloutStatus.OUT_OF_STEPS
    assert len(found.path) == len(found.stages) == steps + 1


def test_near_a_goal_but_not_in_its_gate_is_no_arrival():
    # The goal lies 1e-4 within the straight side: the last goal's tolerance does not
    # end the first stage.
    fields = (make((0.0, 0.0)), make((1.0, 0.0)))
    gate = Gate(np.array([-1e-4, 0.0]), np.array([1.0, 0.0]), 0.1)
    found = chain_rollout([-1.0, 0.0], Chain(fields, (gate,)), goal_tolerance=1e-2)
    assert found.status is RolloutStatus.ARRIVED
    assert found.stages[-1] == 1
    assert np.hypot(*(found.path[-1] - [1.0, 0.0])) <= 1e-2


@settings(max_examples=25)
@given(SEEDS)
def test_times_rise_and_nothing_slows_at_a_gate(seed):
    rng = np.random.default_rng(seed)
    chain = random_chain(rng)
    found = chain_rollout(free_start(chain, rng), chain, step=0.02)
    times = chain_times(found, chain, speed=0.1, slow_radius=0.2)
    assert times[0] == 0.0
    assert (np.diff(times) > 0.0).all()
    # With equal half extents the speed in N is the speed itself, but for the end;
    # differences of times of order 10 are right to 1e-14.
    early = found.stages[:-1] < 2
    way = np.linalg.norm(np.diff(found.path, axis=0), axis=1)
    np.testing.assert_allclose(
        np.diff(times)[early], way[early] / 0.1, rtol=1e-9, atol=1e-13
    )


def test_settings_out_of_range_are_refused(rng):
    chain = random_chain(rng)
    found = chain_rollout(free_start(chain, rng), chain)
    with pytest.raises(ValueError, match="speed must be positive"):
        chain_times(found, chain, speed=0.0)
    with pytest.raises(ValueError, match="step must be positive"):
        chain_rollout([0.0, 0.0], chain, step=0.0)
    with pytest.raises(ValueError, match="max_steps must be at least 1"):
        chain_rollout([0.0, 0.0], chain, max_steps=0)
