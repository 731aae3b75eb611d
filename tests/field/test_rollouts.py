"""Batches of roll-outs over starts and fields: each is the one done alone."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import assume, given, settings

from bath_drake.field.navigation import NavigationField, grad_phi, ln_phi, min_beta
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.rollout import (
    RolloutStatus,
    path_times,
    rollout,
    rollout_ends,
    rollouts,
    timed_rollout,
)

_DISC = Workspace(np.zeros(2), np.array([5.0, 5.0]))


def _world(*rows: list[float], kappa: float = 10.0) -> NavigationField:
    theta = np.array(rows, dtype=np.float64).reshape(-1, 5)
    return NavigationField(_DISC, np.array([3.0, 0.0]), kappa, ObstacleSet(theta))


# Three fields of different sizes; the second traps.
_FIELDS = (
    _world([0, 0.2, 1, 0.5, 0.3], [-2, -1, 0.5, 0.9, 1], [1, 2, 0.4, 0.4, 0]),
    _world([-0.5, 0, 0.2, 1.6, 0]),
    _world(kappa=3.0),
)


def test_every_start_under_every_field_is_the_rollout_done_alone(
    rng: np.random.Generator,
) -> None:
    # Enough starts for several threads, some of them outside free space.
    starts = rng.uniform(-4.5, 4.5, (7, 5, 2))
    found = rollouts(starts, _FIELDS, step=0.05, max_steps=150)
    assert found.paths.shape[:3] == (3, 7, 5)
    seen = set()
    for f, field in enumerate(_FIELDS):
        for index in np.ndindex(7, 5):
            alone = rollout(starts[index], field, step=0.05, max_steps=150)
            one = found[(f, *index)]
            assert one.status is alone.status
            assert one.min_beta == alone.min_beta
            assert one.length == alone.length
            np.testing.assert_array_equal(one.path, alone.path)
            padding = found.paths[(f, *index)][len(one.path) :]
            np.testing.assert_array_equal(
                padding, np.broadcast_to(one.path[-1], padding.shape)
            )
            seen.add(one.status)
    assert seen == set(RolloutStatus)
    assert found.paths.shape[3] == found.counts.max()
    np.testing.assert_array_equal(found.arrived, found.statuses == 0)


@pytest.mark.parametrize("count", [1, 7, 8, 16, 17, 40])
def test_so_it_is_for_few_and_for_many(count: int, rng: np.random.Generator) -> None:
    # Of mixed exponents, at which ln beta takes several logarithms, and a superellipse.
    rows = np.array([[0, 0.2, 1, 0.5, 0.3], [-2, -1, 0.5, 0.9, 1], [1, 2, 0.4, 0.4, 0]])
    field = NavigationField(
        Workspace(np.zeros(2), np.array([5.0, 4.0]), 4),
        np.array([3.0, 0.0]),
        30.0,
        ObstacleSet(rows, np.array([1.0, 0.5, 2.0])),
    )
    starts = rng.uniform(-4.0, 4.0, (count, 2))
    found = rollouts(starts, field, step=0.1)
    statuses, ends = rollout_ends(starts, field, step=0.1)
    for i, start in enumerate(starts):
        alone = rollout(start, field, step=0.1)
        assert found[i].status is statuses[i] is alone.status
        assert found[i].length == alone.length
        np.testing.assert_array_equal(found[i].path, alone.path)
        np.testing.assert_array_equal(ends[i], alone.path[-1])


def test_one_field_and_one_start_give_no_leading_axes() -> None:
    found = rollouts([-4.0, 1.0], _FIELDS[0])
    assert found.paths.ndim == 2
    assert bool(found.arrived)
    np.testing.assert_array_equal(found.paths, rollout([-4.0, 1.0], _FIELDS[0]).path)


def test_no_starts_give_no_paths() -> None:
    found = rollouts(np.empty((0, 2)), _FIELDS)
    assert found.counts.shape == (3, 0)
    assert rollout_ends(np.empty((0, 2)), _FIELDS[0])[0] == ()


def test_times_of_a_batch_are_those_of_its_paths(rng: np.random.Generator) -> None:
    starts = rng.uniform(-4.0, -3.0, (4, 2))
    found = rollouts(starts, _FIELDS[0], step=0.05)
    times = path_times(found.paths, _FIELDS[0], speed=0.2, goal_tolerance=1e-3)
    assert times.shape == found.paths.shape[:2]
    for start, row, count in zip(starts, times, found.counts, strict=True):
        alone = timed_rollout(start, _FIELDS[0], speed=0.2, step=0.05)
        # The same operations; sums of up to 200 terms may be cut up differently.
        np.testing.assert_allclose(row[:count], alone.times, rtol=1e-13)
        np.testing.assert_array_equal(row[count:], row[count - 1])


@settings(max_examples=40)
@given(
    st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0)),
    st.sampled_from(_FIELDS),
)
def test_paths_are_those_of_the_gradient_of_phi(
    start: tuple[float, float], field: NavigationField
) -> None:
    assume(min_beta(start, field) > 0.05)
    found = rollout(start, field, step=0.002)
    assume(len(found.path) > 2)
    steps = np.diff(found.path, axis=0)
    length = np.linalg.norm(steps, axis=1, keepdims=True)
    middles = 0.5 * (found.path[1:] + found.path[:-1])
    slopes = grad_phi(middles, field)
    steep = np.linalg.norm(slopes, axis=1, keepdims=True)
    angle = np.cross(
        np.pad(steps / length, ((0, 0), (0, 1))),
        np.pad(slopes / np.maximum(steep, 1e-300), ((0, 0), (0, 1))),
    )[:, 2]
    # The field at the chord's middle is off the chord by some 1/8 of the step's
    # square times the rates at which the flow turns along and across: 4e-6 / 8 times
    # up to 1e3, where neighbouring steps show that no critical point is near.
    turn = np.linalg.norm(np.diff(steps / length, axis=0), axis=1)
    calm = np.append(turn, 1.0) < 0.01
    calm &= np.append(1.0, turn) < 0.01
    if found.status is RolloutStatus.TRAPPED:  # no direction there
        calm &= np.linalg.norm(middles - found.path[-1], axis=1) > 0.1
    assert np.abs(angle[calm]).max(initial=0.0) < 5e-4
    assert (np.diff(ln_phi(found.path, field)) <= 0.0).all()


@pytest.mark.parametrize(
    ("starts", "fields", "message"),
    [
        (np.zeros(3), _FIELDS, "shape"),
        (np.zeros((2, 2)), (), "fields"),
        (0.0, _FIELDS, "shape"),
    ],
)
def test_bad_batches_are_refused(starts, fields, message) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ValueError, match=message):
        rollouts(starts, fields)
