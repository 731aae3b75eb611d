"""Roll-outs: guarded, falling, and with the right times."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import assume, given, settings

from bath_drake.field.navigation import NavigationField, ln_phi, min_beta
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.rollout import (
    RolloutStatus,
    rollout,
    rollout_ends,
    timed_rollout,
)
from bath_drake.field.speed import canonical_velocity
from bath_drake.notation import FloatArray

_DISC = Workspace(np.zeros(2), np.array([5.0, 5.0]))
_GOAL = np.array([3.0, 0.0])


def _world(*rows: list[float], kappa: float = 10.0) -> NavigationField:
    theta = np.array(rows, dtype=np.float64).reshape(-1, 5)
    return NavigationField(_DISC, _GOAL, kappa, ObstacleSet(theta))


_OPEN = _world()
_WORLD = _world([0, 0.2, 1, 0.5, 0.3], [-2, -1, 0.5, 0.9, 1], [1, 2, 0.4, 0.4, 0])
starts = st.tuples(st.floats(-4.9, 4.9), st.floats(-4.9, 4.9)).map(np.array)


@settings(max_examples=60)
@given(starts, st.floats(0.005, 0.8), st.floats(0.0, 3.0))
def test_a_rollout_never_enters_an_obstacle_and_phi_falls_along_it(
    start: FloatArray, step: float, log_kappa: float
) -> None:
    field = _world(*_WORLD.obstacles.theta.tolist(), kappa=10.0**log_kappa)
    assume(min_beta(start, field) > 0.0)
    found = rollout(start, field, step=step)
    assert found.min_beta > 0.0
    assert (min_beta(found.path, field) > 0.0).all()
    # ln phi may round two neighbours near a boundary to the same number.
    assert (np.diff(ln_phi(found.path, field)) <= 0.0).all()
    assert found.status in (RolloutStatus.ARRIVED, RolloutStatus.TRAPPED)
    lengths = np.linalg.norm(np.diff(found.path, axis=0), axis=1)
    assert (lengths <= step * (1.0 + 1e-12)).all()
    np.testing.assert_array_equal(found.path[0], start)


@settings(max_examples=60)
@given(starts, st.floats(0.05, 2.0), st.floats(-1.5, 1.5), st.floats(0.003, 0.05))
def test_no_step_leaps_over_a_thin_obstacle(
    start: FloatArray, step: float, angle: float, thickness: float
) -> None:
    # Blades across the way, much thinner than a step is long.
    field = _world(
        [0.0, 0.0, 1.5, thickness, angle + 1.5],
        [-2.0, 1.0, 1.0, thickness, angle],
        [1.5, -1.0, thickness, 0.8, angle],
    )
    assume(min_beta(start, field) > 0.0)
    path = rollout(start, field, step=step).path
    share = np.linspace(0.0, 1.0, 400)[:, None, None]
    between = path[:-1] + share * np.diff(path, axis=0)
    # A sample on a step's own end may round to the other side of nothing.
    assert (min_beta(between, field) > -1e-9).all()


@settings(max_examples=40)
@given(starts)
def test_starts_of_a_sound_field_arrive(start: FloatArray) -> None:
    field = _world([0, 0, 1, 1, 0], kappa=4.0)
    assume(min_beta(start, field) > 0.01)
    # The saddle's stable set, the ray behind the obstacle, is left out.
    assume(start[0] > 0.0 or abs(start[1]) > 1e-3)
    found = rollout(start, field)
    assert found.status is RolloutStatus.ARRIVED
    assert np.hypot(*(found.path[-1] - _GOAL)) <= 1e-3


def test_a_start_in_front_of_a_broadside_ellipse_is_trapped() -> None:
    field = _world([-0.5, 0, 0.2, 1.6, 0])
    found = rollout([-4.0, 0.1], field)
    assert found.status is RolloutStatus.TRAPPED
    np.testing.assert_allclose(found.path[-1], [-0.97537, 0.0], atol=1e-4)


@pytest.mark.parametrize(
    "start", [(0.0, 0.2), (6.0, 0.0), (1e300, 0.0), (np.nan, 0.0), (0.0, -np.inf)]
)
def test_a_start_outside_free_space_is_named_so(start: tuple[float, float]) -> None:
    found = rollout(start, _WORLD)
    assert found.status is RolloutStatus.LEFT
    assert len(found.path) == 1


def test_too_few_steps_are_named_so() -> None:
    found = rollout([-4.0, 1.0], _WORLD, max_steps=10)
    assert found.status is RolloutStatus.OUT_OF_STEPS
    assert len(found.path) == 11


def test_a_start_at_the_goal_has_arrived() -> None:
    found = rollout(_GOAL, _WORLD)
    assert found.status is RolloutStatus.ARRIVED
    assert found.length == 0.0


def test_a_batch_ends_where_its_members_do() -> None:
    q = np.random.default_rng(3).uniform(-3.0, 3.0, (20, 2))
    statuses, ends = rollout_ends(q, _WORLD, step=0.02)
    for start, status, end in zip(q, statuses, ends, strict=True):
        single = rollout(start, _WORLD, step=0.02)
        assert status is single.status
        np.testing.assert_array_equal(end, single.path[-1])


def test_halving_the_step_leaves_the_path_where_it_is() -> None:
    coarse = rollout([-4.0, 1.0], _WORLD, step=0.01).path
    fine = rollout([-4.0, 1.0], _WORLD, step=0.0025).path
    gap = np.linalg.norm(coarse[:, None] - fine[None], axis=-1).min(axis=1)
    # The midpoint rule errs by step^2 per length, and fine points lie 0.0025 apart.
    assert gap.max() < 2e-3


@given(starts, st.floats(1e-3, 1.0))
def test_the_speed_along_the_skin_is_the_one_asked_for(
    q: FloatArray, speed: float
) -> None:
    extents = np.array([0.16, 0.25])
    v = canonical_velocity(
        q, _WORLD, speed=speed, half_extents=extents, slow_radius=0.5
    )
    distance = np.hypot(*(q - _GOAL))
    expected = speed * min(distance / 0.5, 1.0) if min_beta(q, _WORLD) >= 0.0 else 0.0
    np.testing.assert_allclose(np.hypot(*(v * extents)), expected, rtol=1e-12)


def test_the_velocity_is_zero_at_the_goal_and_inside_obstacles() -> None:
    q = np.array([_GOAL, [0.0, 0.2], [7.0, 0.0]])
    np.testing.assert_array_equal(canonical_velocity(q, _WORLD, speed=0.1), 0.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"speed": -1.0}, "speed"),
        ({"speed": 0.1, "half_extents": (0.0, 1.0)}, "half_extents"),
        ({"speed": 0.1, "slow_radius": 0.0}, "slow_radius"),
    ],
)
def test_bad_speed_arguments_are_refused(
    arguments: dict[str, float], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        canonical_velocity(_GOAL, _WORLD, **arguments)


def test_times_are_those_of_the_velocity_integrated_in_small_steps() -> None:
    extents = (0.2, 0.3)
    field = _WORLD
    timed = timed_rollout(
        [-4.0, 1.0], field, speed=0.1, half_extents=extents, slow_radius=0.3
    )
    assert timed.status is RolloutStatus.ARRIVED
    assert (np.diff(timed.times) > 0.0).all()
    q = timed.path[0]
    dt, t = 2e-3, 0.0
    while np.hypot(*(q - _GOAL)) > 1e-2:
        k = canonical_velocity(
            q, field, speed=0.1, half_extents=extents, slow_radius=0.3
        )
        k = canonical_velocity(
            q + 0.5 * dt * k, field, speed=0.1, half_extents=extents, slow_radius=0.3
        )
        q = q + dt * k
        t += dt
    distance = np.linalg.norm(timed.path - _GOAL, axis=1)
    # The last point at least a step (0.01) beyond the compared distance, reached
    # by interpolation of ln distance; the law there is exponential.
    at = np.interp(-np.log(1e-2), -np.log(distance[-60:]), timed.times[-60:])
    np.testing.assert_allclose(at, t, rtol=5e-3)


@pytest.mark.parametrize(
    "arguments", [{"step": 0.0}, {"max_steps": 0}, {"goal_tolerance": 0.0}]
)
def test_bad_rollout_arguments_are_refused(arguments: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(arguments))):
        rollout([0.0, 1.0], _OPEN, **arguments)  # type: ignore[arg-type]
