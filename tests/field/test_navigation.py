"""Properties of the navigation function that the paper's guarantee rests on."""

import math

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import assume, given

from bath_drake.field.navigation import (
    NavigationField,
    flow_direction,
    grad_phi,
    grad_psi,
    hessian_psi,
    ln_phi,
    min_beta,
    phi,
)
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import FloatArray

_ROWS = np.array([[0.0, 0.2, 0.5, 0.3, 0.4], [-1.0, -0.8, 0.3, 0.6, 1.0]])


def _field(
    kappa: float = 5.0,
    power: int = 2,
    goal: tuple[float, float] = (1.4, 0.3),
    exponents: tuple[float, float] = (1.0, 1.0),
) -> NavigationField:
    return NavigationField(
        Workspace(np.array([0.1, 0.0]), np.array([3.0, 2.5]), power),
        np.array(goal),
        kappa,
        ObstacleSet(_ROWS, np.array(exponents)),
    )


fields = st.builds(
    _field,
    kappa=st.floats(0.0, 3.0).map(lambda e: 10.0**e),
    power=st.sampled_from([2, 4, 6]),
    goal=st.tuples(st.floats(1.0, 2.0), st.floats(-1.0, 1.0)),
    exponents=st.tuples(st.floats(0.2, 3.0), st.floats(0.2, 3.0)),
)
points = st.tuples(st.floats(-3.0, 3.0), st.floats(-2.6, 2.6)).map(np.array)


@given(fields, points)
def test_phi_keeps_within_zero_and_one(field: NavigationField, q: FloatArray) -> None:
    value = phi(q, field)
    assert 0.0 <= value <= 1.0
    if min_beta(q, field) <= 0.0:
        assert value == 1.0


@given(fields)
def test_phi_is_zero_at_the_goal_and_one_on_every_boundary(
    field: NavigationField,
) -> None:
    assert phi(field.goal, field) == 0.0
    assert ln_phi(field.goal, field) == -math.inf
    # Computed boundary points are off by rounding, so beta is about 1e-15 there,
    # and to the power 0.2 / 1 up to 1e-3 of phi is lost: use exponent one.
    plain = NavigationField(
        field.workspace, field.goal, field.kappa, ObstacleSet(_ROWS)
    )
    np.testing.assert_allclose(
        phi(plain.obstacles.boundary(32), plain)[np.newaxis],
        1.0,
        # 1 - phi = beta gamma^-kappa / kappa: gamma > 0.04 below, kappa up to 5.
        atol=1e-7 if field.kappa <= 5.0 else 1.0,
    )
    t = np.linspace(0.0, 2.0 * np.pi, 33)
    rim = np.stack([np.cos(t), np.sin(t)], axis=-1)
    rim /= ((np.abs(rim) ** field.workspace.power).sum(axis=-1, keepdims=True)) ** (
        1.0 / field.workspace.power
    )
    outside = field.workspace.centre + rim * field.workspace.semi_axes * (1 + 1e-12)
    np.testing.assert_array_equal(phi(outside, field), 1.0)


@given(fields, points)
def test_the_gradient_of_psi_and_its_hessian_agree_with_central_differences(
    field: NavigationField, q: FloatArray
) -> None:
    assume(min_beta(q, field) > 0.05)
    assume(np.hypot(*(q - field.goal)) > 0.1)
    h = 1e-5
    steps = h * np.eye(2)
    # psi from ln phi where that is exact: psi = -ln(exp(-kappa ln phi) - 1).
    hessian = [
        (grad_psi(q + e, field) - grad_psi(q - e, field)) / (2 * h) for e in steps
    ]
    scale = np.abs(hessian_psi(q, field)).max()
    # h^2 / 6 times third derivatives, which a distance of 0.1 makes up to 1e4
    # times the second's unit; rounding adds 1e-16 / h.
    np.testing.assert_allclose(
        np.stack(hessian), hessian_psi(q, field), rtol=0, atol=1e-5 * scale + 1e-6
    )


@given(fields, points)
def test_the_gradient_of_phi_agrees_with_central_differences(
    field: NavigationField, q: FloatArray
) -> None:
    assume(min_beta(q, field) > 0.05)
    assume(np.hypot(*(q - field.goal)) > 0.05)
    h = 1e-6
    difference = [
        (ln_phi(q + e, field) - ln_phi(q - e, field)) / (2 * h) for e in h * np.eye(2)
    ]
    # d ln phi: rounding 1e-16 * |ln phi| / h plus h^2 times third derivatives.
    np.testing.assert_allclose(
        grad_phi(q, field),
        phi(q, field) * np.array(difference),
        rtol=1e-5,
        atol=1e-8,
    )


@given(fields, points)
def test_the_flow_is_the_unit_vector_against_the_gradient(
    field: NavigationField, q: FloatArray
) -> None:
    assume(min_beta(q, field) > 1e-6)
    assume(np.hypot(*(q - field.goal)) > 1e-6)
    direction = flow_direction(q, field)
    np.testing.assert_allclose(np.hypot(*direction), 1.0, rtol=1e-14)
    down = -grad_psi(q, field)
    np.testing.assert_allclose(direction, down / np.hypot(*down), rtol=0, atol=1e-8)
    slope = grad_phi(q, field)
    if np.hypot(*slope) > 1e-250:  # squares of smaller ones underflow
        unit = slope / np.hypot(*slope)
        np.testing.assert_allclose(direction, -unit, rtol=0, atol=1e-9)


@given(
    fields, st.floats(-3.1, 3.1), st.tuples(st.floats(-5, 5), st.floats(-5, 5)), points
)
def test_the_flow_turns_and_moves_with_the_world(
    field: NavigationField, angle: float, shift: tuple[float, float], q: FloatArray
) -> None:
    # A disc as workspace: it alone turns onto itself.
    disc = Workspace(np.zeros(2), np.array([3.0, 3.0]))
    field = NavigationField(disc, field.goal, field.kappa, field.obstacles)
    assume(min_beta(q, field) > 0.01)
    assume(np.hypot(*(q - field.goal)) > 1e-3)
    # Near a critical point a rounding error turns the flow by any angle.
    assume(np.hypot(*grad_psi(q, field)) > 1e-3)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    p = np.array(shift)
    theta = field.obstacles.theta.copy()
    theta[:, :2] = theta[:, :2] @ turn.T + p
    theta[:, 4] += angle
    moved = NavigationField(
        Workspace(p, disc.semi_axes),
        turn @ field.goal + p,
        field.kappa,
        ObstacleSet(theta, field.obstacles.powers),
    )
    np.testing.assert_allclose(
        flow_direction(turn @ q + p, moved),
        turn @ flow_direction(q, field),
        atol=1e-8,  # coordinates up to 8 lose 1e-15, over 1e-3 and beta 0.01
    )


@pytest.mark.parametrize("kappa", [1.0, 3.0, 30.0, 1000.0])
@pytest.mark.parametrize(
    "q",
    [
        (1.4, 0.3),
        (1.4 + 1e-200, 0.3),
        (1.4 + 1e-12, 0.3),
        (3.1, 0.0),
        (0.0, 2.5),
        (1e300, -1e300),
        (1.7e308, 1.7e308),
        (0.0, 0.2),
        (-2.9, 0.0),
    ],
)
def test_everything_stays_finite(kappa: float, q: tuple[float, float]) -> None:
    for power in (2, 4, 8):
        field = _field(kappa=kappa, power=power)
        for values in (
            phi(q, field),
            grad_phi(q, field),
            flow_direction(q, field),
            min_beta(q, field),
        ):
            assert np.isfinite(values).all()


@pytest.mark.parametrize("kappa", [1.0, 7.5, 200.0])
def test_on_a_boundary_the_flow_is_the_inward_normal(kappa: float) -> None:
    # Representable numbers, so that beta is exactly zero at (1, 0).
    field = NavigationField(
        Workspace(np.zeros(2), np.array([4.0, 4.0])),
        np.array([-2.0, 1.0]),
        kappa,
        ObstacleSet(np.array([[0.0, 0.0, 1.0, 0.5, 0.0]])),
    )
    q = np.array([1.0, 0.0])
    assert min_beta(q, field) == 0.0
    assert phi(q, field) == 1.0
    np.testing.assert_array_equal(flow_direction(q, field), [1.0, 0.0])
    np.testing.assert_array_equal(flow_direction([4.0, 0.0], field), [-1.0, 0.0])
    # d phi = -gamma^-kappa / kappa d beta, with d beta = 2 (1 - 1/16) along x.
    expected = -(10.0**-kappa) / kappa * 2.0 * (15.0 / 16.0)
    np.testing.assert_allclose(grad_phi(q, field), [expected, 0.0], rtol=1e-12)


@pytest.mark.parametrize("kappa", [1.5, 4.0, 50.0])
def test_the_hessian_at_the_goal_is_a_multiple_of_the_identity(kappa: float) -> None:
    field = _field(kappa=kappa)
    log_beta = np.log(field.workspace.beta(field.goal))
    q = field.goal - field.obstacles.theta[:, :2]
    for d, (_, _, a, b, angle) in zip(q, field.obstacles.theta, strict=True):
        c, s = np.cos(angle), np.sin(angle)
        u, v = c * d[0] + s * d[1], c * d[1] - s * d[0]
        log_beta += np.log((u / a) ** 2 + (v / b) ** 2 - 1.0)
    h = 1e-6
    columns = [
        (grad_phi(field.goal + e, field) - grad_phi(field.goal - e, field)) / (2 * h)
        for e in h * np.eye(2)
    ]
    # The next term is of relative order h (kappa = 1.5 leaves |q|^(2 kappa)).
    np.testing.assert_allclose(
        np.stack(columns),
        2.0 * np.exp(-log_beta / kappa) * np.eye(2),
        rtol=1e-5,
        atol=1e-5,
    )


def test_batches_keep_their_shape_and_match_single_points() -> None:
    field = _field()
    q = np.random.default_rng(1).uniform(-2.0, 2.0, (3, 4, 2))
    assert phi(q, field).shape == (3, 4)
    assert flow_direction(q, field).shape == (3, 4, 2)
    assert hessian_psi(q, field).shape == (3, 4, 2, 2)
    np.testing.assert_array_equal(grad_phi(q, field)[1, 2], grad_phi(q[1, 2], field))


@pytest.mark.parametrize("kappa", [0.0, -1.0, math.nan, math.inf])
def test_kappa_must_be_positive_and_finite(kappa: float) -> None:
    with pytest.raises(ValueError, match="kappa must be positive"):
        _field(kappa=kappa)


def test_points_of_the_wrong_shape_are_refused() -> None:
    with pytest.raises(ValueError, match="shape"):
        phi(np.zeros(3), _field())


def test_fields_compare_by_value_and_grow_by_obstacles() -> None:
    field = _field()
    assert field == _field()
    assert hash(field) == hash(_field())
    extra = ObstacleSet(np.array([[1.0, -1.0, 0.1, 0.1, 0.0]]))
    assert len(field.with_obstacles(extra).obstacles) == 3
    assert field.with_goal(np.array([0.0, 1.0])).goal.tolist() == [0.0, 1.0]
    assert field.with_obstacles(ObstacleSet()) == field
