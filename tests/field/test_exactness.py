"""Values at the goal, on boundaries and at the ends of what a float can hold."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import assume, given, settings

from bath_drake.field.navigation import (
    NavigationField,
    flow_direction,
    grad_phi,
    grad_psi,
    hessian_phi,
    hessian_psi,
    ln_phi,
    min_beta,
    phi,
)
from bath_drake.field.obstacles import ObstacleSet, Workspace, beta
from bath_drake.notation import FloatArray

_KAPPAS = [1.0, 1.5, 4.0, 50.0, 1000.0]


def _world(
    rows: list[list[float]],
    kappa: float,
    power: int = 2,
    goal: tuple[float, float] = (1.4, 0.3),
) -> NavigationField:
    """Obstacles of rows (cx, cy, a, b, angle, exponent) within half-axes 3 and 2.5."""
    table = np.array(rows, dtype=np.float64).reshape(-1, 6)
    return NavigationField(
        Workspace(np.zeros(2), np.array([3.0, 2.5]), power),
        np.array(goal),
        kappa,
        ObstacleSet(table[:, :5], table[:, 5]),
    )


_ROWS = [[0.0, 0.2, 0.5, 0.3, 0.4, 1.0], [-1.0, -0.8, 0.3, 0.6, 1.0, 1.0]]


def _row(draw: st.DrawFn) -> list[float]:
    centre = st.floats(-2.0, 2.0)
    axis = st.floats(0.05, 1.0)
    parts = (centre, centre, axis, axis, st.floats(-4.0, 4.0), st.floats(0.2, 3.0))
    return [draw(part) for part in parts]


@st.composite
def worlds(draw: st.DrawFn) -> NavigationField:
    """Any world: obstacles may overlap, hold the goal or cross the rim."""
    rows = [_row(draw) for _ in range(draw(st.integers(0, 5)))]
    goal = draw(st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0)))
    kappa = 10.0 ** draw(st.floats(0.0, 3.0))
    return _world(rows, kappa, draw(st.sampled_from([2, 4, 10])), goal)


any_number = st.one_of(
    st.floats(-3.0, 3.0),
    st.floats(allow_nan=False, allow_infinity=False),
    st.sampled_from([0.0, 1e308, -1.7e308, 5e-324, 1e-200]),
)


@settings(max_examples=100)
@given(worlds(), any_number, any_number)
def test_nothing_overflows_anywhere(field: NavigationField, x: float, y: float) -> None:
    here = np.array([x, y])
    for q in (here, field.goal + 1e-200 * np.sign(here), field.goal):
        value = phi(q, field)
        assert 0.0 <= value <= 1.0
        for found in (
            min_beta(q, field),
            grad_phi(q, field),
            hessian_phi(q, field),
            flow_direction(q, field),
            grad_psi(q, field),
            hessian_psi(q, field),
        ):
            assert np.isfinite(found).all()
        assert not np.isnan(ln_phi(q, field))
        if min_beta(q, field) < 0.0:
            assert value == 1.0
            for found in (
                grad_phi(q, field),
                hessian_phi(q, field),
                flow_direction(q, field),
                grad_psi(q, field),
                hessian_psi(q, field),
            ):
                np.testing.assert_array_equal(found, 0.0)


@settings(max_examples=100)
@given(worlds(), st.floats(-3.0, 3.0), st.floats(-2.5, 2.5))
def test_the_hessian_of_phi_agrees_with_central_differences(
    field: NavigationField, x: float, y: float
) -> None:
    q = np.array([x, y])
    assume(min_beta(q, field) > 0.05)
    h = 1e-6
    columns = [
        (grad_phi(q + e, field) - grad_phi(q - e, field)) / (2.0 * h)
        for e in h * np.eye(2)
    ]
    exact = hessian_phi(q, field)
    # Everything changes over lengths of beta / kappa or so at the least, and phi's
    # third derivative is up to that length's inverse times its second: with kappa
    # 1000 and beta 0.05 (h / 5e-5)^2. Rounding: 1e-13 of the gradient over h.
    slope = np.abs(grad_phi(q, field)).max()
    spread = max(np.abs(c).max() for c in (exact, *columns))
    np.testing.assert_allclose(
        np.stack(columns), exact, rtol=0, atol=1e-3 * spread + 1e-6 * slope + 1e-12
    )
    smooth = field.kappa < 30.0 and np.hypot(*(q - field.goal)) > 0.1
    if smooth and min_beta(q, field) > 0.3:
        np.testing.assert_allclose(
            np.stack(columns), exact, rtol=0, atol=1e-7 * (spread + slope) + 1e-12
        )


@pytest.mark.parametrize("kappa", _KAPPAS)
@pytest.mark.parametrize("power", [2, 4])
def test_at_the_goal_the_hessian_is_that_multiple_of_the_identity(
    kappa: float, power: int
) -> None:
    field = _world(_ROWS, kappa, power)
    beta_goal = field.workspace.beta(field.goal) * beta(
        field.goal, field.obstacles
    ).prod(axis=-1)
    expected = 2.0 * beta_goal ** (-1.0 / kappa)
    # A few roundings of ln beta and of the power.
    np.testing.assert_allclose(
        hessian_phi(field.goal, field), expected * np.eye(2), rtol=1e-13
    )


@pytest.mark.parametrize("kappa", _KAPPAS)
@pytest.mark.parametrize("distance", [1e-300, 1e-200, 1e-160, 1e-80, 1e-20])
def test_close_to_the_goal_phi_is_the_paraboloid(kappa: float, distance: float) -> None:
    # The goal at zero: only there can a point lie that close to it.
    field = _world([[1.0, 0.2, 0.5, 0.3, 0.4, 1.0]], kappa, goal=(0.0, 0.0))
    d = distance * np.array([0.6, -0.8])
    curvature = hessian_phi(field.goal, field)[0, 0]
    # The next terms are d and gamma^kappa smaller; d itself is 1e-16 off 1e-20.
    np.testing.assert_allclose(grad_phi(d, field), curvature * d, rtol=1e-13)
    np.testing.assert_allclose(
        ln_phi(d, field), np.log(0.5 * curvature) + 2.0 * np.log(distance), rtol=1e-13
    )
    np.testing.assert_allclose(flow_direction(d, field), [-0.6, 0.8], rtol=1e-14)
    assert np.isfinite(hessian_psi(d, field)).all()
    np.testing.assert_allclose(
        hessian_phi(d, field), curvature * np.eye(2), rtol=0, atol=1e-13 * curvature
    )


def _touching(kappa: float, exponent: float) -> tuple[NavigationField, FloatArray]:
    # Representable numbers, so that beta is exactly zero at (1, 0).
    rows = [[0.0, 0.0, 1.0, 0.5, 0.0, exponent], [-1.5, -0.5, 0.5, 0.25, 0.5, 1.5]]
    return _world(rows, kappa, goal=(2.0, 0.5)), np.array([1.0, 0.0])


@pytest.mark.parametrize("kappa", [1.0, 3.0, 20.0])
@pytest.mark.parametrize("exponent", [1.0, 2.0, 3.0])
def test_on_a_boundary_derivatives_are_the_limits_from_inside(
    kappa: float, exponent: float
) -> None:
    field, q = _touching(kappa, exponent)
    assert min_beta(q, field) == 0.0
    assert phi(q, field) == 1.0
    for function in (grad_phi, hessian_phi):
        limit = function(q, field)
        far, near = (
            np.abs(function(q + np.array([d, 0.0]), field) - limit).max()
            for d in (1e-4, 1e-6)
        )
        # Linear convergence takes it to a hundredth; beta there is good to 1e-10.
        assert near <= 0.011 * far + 1e-9 * np.abs(limit).max()


@pytest.mark.parametrize("exponent", [0.3, 0.9])
def test_where_phi_has_a_vertical_wall_its_derivatives_stay_finite(
    exponent: float,
) -> None:
    field, q = _touching(5.0, exponent)
    slope = grad_phi(q, field)
    assert slope[0] < -1e8  # infinite, were it not for the cut
    # All but the wall's own part is 1e-100 of it.
    assert abs(slope[1]) < 1e-90 * abs(slope[0])
    assert np.isfinite(hessian_phi(q, field)).all()


def test_where_boundaries_cross_the_flow_is_the_sum_of_their_gradients() -> None:
    rows = [[-0.75, 0.0, 0.75, 0.75, 0.0, 1.0], [0.75, 0.0, 0.75, 0.75, 0.0, 1.0]]
    touching = _world(rows, 4.0, goal=(0.0, -2.0))
    # Two discs that touch: their gradients cancel, and no way is left.
    assert min_beta([0.0, 0.0], touching) == 0.0
    np.testing.assert_array_equal(flow_direction([0.0, 0.0], touching), 0.0)
    corner = [[-0.75, 0.0, 0.75, 0.5, 0.0, 1.0], [0.0, -0.5, 0.25, 0.5, 0.0, 2.0]]
    field = _world(corner, 4.0)
    assert min_beta([0.0, 0.0], field) == 0.0
    # Gradients (2 / 0.75, 0) and, with its exponent, 2 (0, 2 / 0.5): unit of the sum.
    expected = np.array([8.0 / 3.0, 8.0])
    np.testing.assert_allclose(
        flow_direction([0.0, 0.0], field), expected / np.hypot(*expected), rtol=1e-15
    )


@given(st.floats(0.0, 1.0), st.sampled_from([2, 4, 6, 16]), st.floats(0.0, 7.0))
def test_beta_0_of_a_superellipse_is_its_formula(
    share: float, power: int, angle: float
) -> None:
    field = _world([], 3.0, power)
    q = share * np.array([3.0, 2.5]) * np.array([np.cos(angle), np.sin(angle)])
    # Products instead of powers: p roundings of each term, terms at most one.
    np.testing.assert_allclose(
        min_beta(q, field), field.workspace.beta(q), rtol=0, atol=1e-15 * power
    )


def test_many_far_and_many_close_obstacles_neither_overflow_nor_underflow() -> None:
    # beta is about 1e16 for each tiny obstacle and 1e-3 beside each of the large:
    # 60 of either leave the range of floats long before the last one.
    tiny = [[-2.0 + 0.01 * i, 1.5, 1e-8, 1e-8, 0.0, 1.0] for i in range(60)]
    thin = [[0.0, -1.5, 1.0, 1.0, 0.1 * i, 0.5 + 0.01 * i] for i in range(60)]
    q = np.array([0.0, -0.4995])
    for rows in (tiny, thin, tiny + thin):
        field = _world(rows, 300.0)
        assert np.isfinite(ln_phi(q, field))
        assert np.isfinite(grad_phi(q, field)).all()
        terms = np.log(beta(q, field.obstacles)) * field.obstacles.powers
        expected = terms.sum() + np.log(field.workspace.beta(q))
        gamma = np.hypot(*(q - field.goal)) ** 2
        t = expected - 300.0 * np.log(gamma)
        # 1e-16 of each of 120 logarithms of up to 37, over kappa.
        np.testing.assert_allclose(
            ln_phi(q, field), -np.logaddexp(0.0, t) / 300.0, rtol=1e-12, atol=1e-15
        )
