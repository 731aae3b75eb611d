import numpy as np
import pytest

from bath_drake.benchmarks import numpy_field
from bath_drake.benchmarks.random_worlds import (
    disjoint_world,
    free_points,
    overlapping_world,
)
from bath_drake.field.navigation import (
    flow_direction,
    grad_psi,
    hessian_psi,
    ln_phi,
    min_beta,
)
from bath_drake.field.obstacles import Workspace
from bath_drake.field.rollout import rollout_ends

STEP = 0.01


@pytest.fixture(params=[disjoint_world, overlapping_world])
def field(request, rng):
    return request.param(rng, 12, 20.0)


def test_the_direction_is_the_compiled_one(field, rng):
    q = free_points(rng, field, 2000)
    found = numpy_field.flow_direction(q, field)
    # Where terms cancel, at a critical point, the direction itself is uncertain.
    np.testing.assert_allclose(found, flow_direction(q, field), atol=1e-9)


def test_a_superellipse_has_the_compiled_direction_too(field, rng):
    workspace = Workspace(np.array([0.1, -0.2]), np.array([6.0, 5.0]), 4)
    other = type(field)(workspace, field.goal, field.kappa, field.obstacles)
    q = free_points(rng, other, 2000)
    found = numpy_field.flow_direction(q, other)
    np.testing.assert_allclose(found, flow_direction(q, other), atol=1e-9)


def test_outside_free_space_there_is_no_direction(field):
    q = np.concatenate([field.obstacles.theta[:, :2], [[9.0, 0.0]]])
    assert (numpy_field.flow_direction(q, field) == 0.0).all()
    assert (numpy_field.psi(q, field) == np.inf).all()


def test_the_potential_is_the_compiled_one(field, rng):
    q = free_points(rng, field, 2000)
    psi = numpy_field.psi(q, field)
    # Sums of a dozen logarithms in another order.
    expected = -np.logaddexp(0.0, -psi) / field.kappa
    np.testing.assert_allclose(expected, ln_phi(q, field), rtol=1e-10, atol=1e-14)


def test_the_derivatives_are_the_compiled_ones(field, rng):
    q = free_points(rng, field, 2000)
    q = q[min_beta(q, field) > 1e-3]
    at = numpy_field.derivatives(q, field)
    # beta, a difference, is good to 1e-13; divided by itself at 1e-3, to 1e-10.
    wrong = np.abs(at.gradient - grad_psi(q, field)).max(axis=-1)
    assert (wrong <= 1e-9 * at.force).all()
    wrong = np.abs(at.hessian - hessian_psi(q, field)).max(axis=(-2, -1))
    assert (wrong <= 1e-9 * at.stiffness).all()
    np.testing.assert_allclose(at.min_beta, min_beta(q, field), atol=1e-12)


def test_roll_outs_end_where_the_compiled_ones_do(rng):
    field = disjoint_world(rng, 12, 20.0)
    starts = free_points(rng, field, 100)
    found = numpy_field.rollout_ends(starts, field, step=STEP, max_steps=200)
    _, ends = rollout_ends(starts, field, step=STEP, max_steps=200)
    # Both follow the flow; how each guards its steps may shift the end along it.
    gap = np.linalg.norm(found - ends, axis=-1)
    assert np.median(gap) < 1e-6
    assert gap.max() < STEP


def test_a_start_in_an_obstacle_stays_there(rng):
    field = disjoint_world(rng, 3, 20.0)
    starts = field.obstacles.theta[:, :2]
    found = numpy_field.rollout_ends(starts, field, step=STEP, max_steps=5)
    np.testing.assert_array_equal(found, starts)
