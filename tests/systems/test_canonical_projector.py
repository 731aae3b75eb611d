import dataclasses

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.map_follower import (
    MAP_FOLLOWERS,
    FollowedMap,
    frame_map,
    tracked_follower,
)
from bath_drake.systems.canonical_projector import CanonicalProjector, unknown_map


@pytest.fixture
def observation():
    rng = np.random.default_rng(5)
    # A back with a hump, seen along y: a surface that has one place to lie.
    x, z = rng.uniform(-1, 1, (2, 20000)) * [[0.17], [0.25]]
    y = 1.2 * x**2 + 0.3 * z**2 - 0.02 * np.exp(-(x**2 + z**2) / 0.05**2)
    points = np.column_stack([x + 0.7, y, z + 0.9])
    return dataclasses.replace(
        BodyObservation(),
        found=True,
        stamp=0.0,
        points_W=points,
        point_areas=np.full(20000, 1.5e-5),
        completed_points_W=points,
        completed_areas=rng.uniform(1e-5, 2e-5, 20000),
        p_WC=np.array([0.7, -1.3, 1.5]),
    )


PERIOD = 1.0 / 30.0


def _projector(observation, follower=None):
    dut = CanonicalProjector(period=PERIOD, follower=follower)
    context = dut.CreateDefaultContext()
    dut.GetInputPort("body_observation").FixValue(context, Value(observation))
    return dut, Simulator(dut, context)


def _map(dut, simulator, end):
    simulator.AdvanceTo(end)
    return dut.GetOutputPort("canonical_map").Eval(simulator.get_context())


def _assert_same(a, b):
    for name in ("R_WP", "p_WP", "half_extents"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


def moved(observation, k, shift):
    """Frame k: the body has moved by so much along all axes, m."""
    return dataclasses.replace(
        observation,
        stamp=k * PERIOD,
        points_W=observation.points_W + shift,
        completed_points_W=observation.completed_points_W + shift,
    )


def test_the_first_map_is_that_of_the_frame(observation):
    _assert_same(_map(*_projector(observation), 0.01), frame_map(observation))


@pytest.mark.parametrize("name", MAP_FOLLOWERS)
def test_a_later_map_is_that_of_the_pure_follower(observation, name):
    follower = MAP_FOLLOWERS[name]()
    dut, simulator = _projector(observation, follower)
    _map(dut, simulator, 0.01)
    then = moved(observation, 1, 0.01)
    context = simulator.get_mutable_context()
    dut.GetInputPort("body_observation").FixValue(context, Value(then))
    known = follower.next(FollowedMap(), observation)
    expected = follower.next(known, then).smooth.canonical_map
    _assert_same(_map(dut, simulator, PERIOD + 0.01), expected)


def test_a_jump_is_not_believed_and_counted(observation):
    dut, simulator = _projector(observation)
    first = _map(dut, simulator, 0.01)
    context = simulator.get_mutable_context()
    status, count = (dut.GetOutputPort(n) for n in ("map_status", "rejected_frames"))
    assert (status.Eval(context)[0], count.Eval(context)[0]) == (1.0, 0.0)
    for k, shift in ((1, 0.3), (2, 0.3), (3, 0.0)):
        seen = moved(observation, k, shift)
        dut.GetInputPort("body_observation").FixValue(context, Value(seen))
        now = _map(dut, simulator, k * PERIOD + 0.01)
        jumped = k < 3
        assert status.Eval(context)[0] == float(not jumped)
        assert count.Eval(context)[0] == min(k, 2)
        if jumped:
            _assert_same(now, first)


def test_one_frame_counts_once(observation):
    dut, simulator = _projector(observation)
    first = _map(dut, simulator, 0.01)
    _assert_same(_map(dut, simulator, 1.0), first)


def test_a_frame_that_was_refused_is_not_refused_again_while_it_stands(observation):
    dut, simulator = _projector(observation)
    _map(dut, simulator, 0.01)
    far = moved(observation, 1, 0.3)
    context = simulator.get_mutable_context()
    dut.GetInputPort("body_observation").FixValue(context, Value(far))
    simulator.AdvanceTo(1.5)
    assert dut.GetOutputPort("rejected_frames").Eval(context)[0] == 1.0


def test_after_a_refused_frame_the_filter_counts_from_the_last_believed_one(
    observation,
):
    dut, simulator = _projector(observation)
    _map(dut, simulator, 0.01)
    seen = [moved(observation, 1, 0.3), moved(observation, 2, 0.01)]
    context = simulator.get_mutable_context()
    for k, frame in enumerate(seen, start=1):
        dut.GetInputPort("body_observation").FixValue(context, Value(frame))
        simulator.AdvanceTo(k * PERIOD + 0.01)
    follower = tracked_follower()
    known = follower.next(FollowedMap(), observation)
    expected = follower.next(known, seen[1])
    _assert_same(
        dut.GetOutputPort("canonical_map").Eval(context), expected.smooth.canonical_map
    )


def test_a_lost_body_leaves_the_last_map(observation):
    dut, simulator = _projector(observation)
    first = _map(dut, simulator, 0.01)
    lost = dataclasses.replace(
        observation,
        found=False,
        stamp=PERIOD,
        completed_points_W=observation.completed_points_W + 1.0,
    )
    context = simulator.get_mutable_context()
    dut.GetInputPort("body_observation").FixValue(context, Value(lost))
    _assert_same(_map(dut, simulator, 0.5), first)


def test_before_any_body_the_map_is_the_unknown_one():
    dut, simulator = _projector(BodyObservation())
    _assert_same(_map(dut, simulator, 0.5), unknown_map())


def test_another_value_is_refused_by_name():
    _, simulator = _projector(unknown_map())
    with pytest.raises(TypeError, match="body_observation"):
        simulator.AdvanceTo(0.01)


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan"), float("inf")])
def test_the_period_must_be_positive(period):
    with pytest.raises(ValueError, match="period must be positive"):
        CanonicalProjector(period=period)
