"""Exact derivatives of paths, against central differences of the same roll-out."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import assume, given, settings

from bath_drake.field.navigation import (
    NavigationField,
    flow_direction,
    ln_phi,
    min_beta,
)
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.rollout import RolloutStatus
from bath_drake.field.sensitivities import path_sensitivities
from bath_drake.notation import FloatArray

_STEP = 0.02


def _field(parameters: FloatArray, power: int) -> NavigationField:
    """(cx, cy, a, b, angle, exponent) of each obstacle, then kappa and the goal."""
    rows = parameters[:-3].reshape(-1, 6)
    return NavigationField(
        Workspace(np.array([0.1, 0.0]), np.array([3.0, 2.5]), power),
        parameters[-2:],
        float(parameters[-3]),
        ObstacleSet(rows[:, :5], rows[:, 5]),
    )


@st.composite
def worlds(draw: st.DrawFn) -> tuple[FloatArray, int, FloatArray]:
    """Parameters, the workspace's power and a start on the far side."""

    def number(low: float, high: float) -> float:
        return draw(st.floats(low, high))

    rows = [
        [
            x + number(-0.3, 0.3),
            number(-1.2, 1.2),
            number(0.15, 0.35),
            number(0.15, 0.35),
            number(-3.0, 3.0),
            number(0.5, 2.0),
        ]
        for x in (-1.0, 0.0, 1.0)[: draw(st.integers(1, 3))]
    ]
    tail = [number(3.0, 50.0), 1.9, number(-0.5, 0.5)]
    start = np.array([-1.9, number(-0.8, 0.8)])
    return np.array([*np.ravel(rows), *tail]), draw(st.sampled_from([2, 4])), start


def _all(found) -> FloatArray:  # type: ignore[no-untyped-def]
    """The derivatives in the order of `_field`'s parameters, then the start's."""
    flat = found.obstacles.reshape(*found.path.shape, -1)
    parts = [flat, found.kappa[..., None], found.goal, found.start]
    return np.concatenate(parts, axis=-1)


def _differences(
    parameters: FloatArray, power: int, start: FloatArray, step: float
) -> tuple[FloatArray, FloatArray]:
    """Central differences of fourth order, shape (T, 2, P), without the last step.

    With them how far those of second order are from them: a bound on their error.
    """
    whole = np.append(parameters, start)
    h = 3e-5
    columns = []
    for e in h * np.eye(len(whole)):
        paths = [
            path_sensitivities(p[-2:], _field(p[:-2], power), step=step).path
            for p in (whole + e, whole - e, whole + 2.0 * e, whole - 2.0 * e)
        ]
        # The last step jumps onto the goal, after a count that may differ.
        n = min(len(p) for p in paths) - 1
        near, far = paths[0][:n] - paths[1][:n], paths[2][:n] - paths[3][:n]
        fourth = (8.0 * near - far) / (12.0 * h)
        columns.append((fourth, np.abs(fourth - near / (2.0 * h))))
    count = min(len(fourth) for fourth, _ in columns)
    values, errors = zip(*columns, strict=True)
    return (
        np.stack([c[:count] for c in values], axis=-1),
        np.stack([c[:count] for c in errors], axis=-1),
    )


@settings(max_examples=60)
@given(worlds())
def test_they_agree_with_central_differences(world) -> None:  # type: ignore[no-untyped-def]
    parameters, power, start = world
    field = _field(parameters, power)
    found = path_sensitivities(start, field, step=_STEP)
    exact = _all(found)
    difference, error = _differences(parameters, power, start, _STEP)
    count = min(len(exact), len(difference))
    # Once derivatives have grown (towards a saddle), an obstacle is close (the flow
    # turns within a beta) or phi rises (steps without guards chatter about a trap),
    # differences are no yardstick any more.
    steady = np.abs(exact[:count]).max(axis=(1, 2)) < 20.0
    steady &= min_beta(found.path[:count], field) > 0.05
    steady &= np.diff(ln_phi(found.path[:count], field), prepend=np.inf) < 0.0
    steady = np.logical_and.accumulate(steady)
    gap = np.abs(exact[:count] - difference)
    # Rounding: 1e-16 a step, grown 20 times, over h = 3e-5.
    assert (gap <= 1e-7 + 10.0 * error)[steady].all()


def test_a_known_case_agrees_to_nine_digits() -> None:
    rows = [[-0.4, 0.1, 0.4, 0.25, 0.5, 1.0], [0.7, -0.5, 0.3, 0.3, 0.0, 1.4]]
    parameters = np.array([*np.ravel(rows), 9.0, 1.9, 0.2])
    start = np.array([-1.9, 0.35])
    exact = _all(path_sensitivities(start, _field(parameters, 2), step=0.02))
    difference, _ = _differences(parameters, 2, start, 0.02)
    assert len(difference) > 200
    # Rounding: some 1e-15 after 200 steps, over h = 3e-5.
    np.testing.assert_allclose(exact[: len(difference)], difference, rtol=0, atol=1e-9)


@settings(max_examples=30)
@given(worlds())
def test_the_path_is_one_of_equal_midpoint_steps(world) -> None:  # type: ignore[no-untyped-def]
    parameters, power, start = world
    field = _field(parameters, power)
    found = path_sensitivities(start, field, step=_STEP)
    assume(len(found.path) > 2)
    before = found.path[:-2]
    middle = before + 0.5 * _STEP * flow_direction(before, field)
    after = before + _STEP * flow_direction(middle, field)
    # The same formulas in another order: rounding, and the flow's own curvature.
    np.testing.assert_allclose(found.path[1:-1], after, rtol=0, atol=1e-10)


def test_an_arrived_path_ends_on_the_goal_and_moves_with_it() -> None:
    field = _field(np.array([0.0, 1.0, 0.3, 0.2, 0.0, 1.0, 5.0, 1.9, 0.2]), 2)
    found = path_sensitivities([-1.9, 0.0], field, step=0.05)
    assert found.status is RolloutStatus.ARRIVED
    np.testing.assert_array_equal(found.path[-1], field.goal)
    np.testing.assert_array_equal(found.goal[-1], np.eye(2))
    np.testing.assert_array_equal(found.start[-1], 0.0)
    np.testing.assert_array_equal(found.start[0], np.eye(2))
    np.testing.assert_array_equal(found.obstacles[0], 0.0)


def test_moving_the_whole_world_moves_the_path_with_it() -> None:
    # Centres, goal and start by one vector; the rim is far, its part is small.
    rows = [[0.0, 0.4, 0.3, 0.2, 0.3, 1.0], [1.0, -0.4, 0.2, 0.3, 1.0, 1.5]]
    field = NavigationField(
        Workspace(np.zeros(2), np.array([1e4, 1e4])),
        np.array([1.9, 0.2]),
        8.0,
        ObstacleSet(np.array(rows)[:, :5], np.array(rows)[:, 5]),
    )
    found = path_sensitivities([-1.9, 0.1], field, step=0.02)
    assert found.status is RolloutStatus.ARRIVED
    shift = found.obstacles[..., :2].sum(axis=2) + found.goal + found.start
    # The rim's share of the flow is about 1e-8 here.
    np.testing.assert_allclose(
        shift, np.broadcast_to(np.eye(2), shift.shape), atol=1e-6
    )


@pytest.mark.parametrize("start", [(-1.0, 0.0), (9.0, 0.0)])
def test_a_start_outside_free_space_has_left_at_once(
    start: tuple[float, float],
) -> None:
    field = _field(np.array([-1.0, 0.0, 0.3, 0.2, 0.0, 1.0, 5.0, 1.9, 0.2]), 2)
    found = path_sensitivities(start, field)
    assert found.status is RolloutStatus.LEFT
    assert len(found.path) == 1


def test_too_few_steps_and_bad_settings_are_named_so() -> None:
    field = _field(np.array([5.0, 1.9, 0.2]), 2)
    found = path_sensitivities([-1.9, 0.0], field, step=0.01, max_steps=7)
    assert found.status is RolloutStatus.OUT_OF_STEPS
    assert found.path.shape == (8, 2)
    assert found.obstacles.shape == (8, 2, 0, 6)
    with pytest.raises(ValueError, match="step must be positive"):
        path_sensitivities([0.0, 0.0], field, step=0.0)
