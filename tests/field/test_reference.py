"""The compiled field against plain numpy, and what leaves it as it is."""

import hypothesis.strategies as st
import numpy as np
from hypothesis import assume, given, settings

from bath_drake.field.navigation import (
    NavigationField,
    flow_direction,
    grad_phi,
    grad_psi,
    hessian_phi,
    hessian_psi,
    min_beta,
    phi,
)
from bath_drake.field.obstacles import ObstacleSet, Workspace, beta, grad_beta
from bath_drake.field.rollout import rollout
from bath_drake.notation import FloatArray


@st.composite
def worlds(
    draw: st.DrawFn, most_kappa: float = 3.0
) -> tuple[NavigationField, FloatArray]:
    """A world in a disc of radius 3 and a point of its free space off the goal."""
    axis, centre = st.floats(0.1, 0.8), st.floats(-1.8, 1.8)
    parts = (centre, centre, axis, axis, st.floats(-4.0, 4.0), st.floats(0.3, 2.5))
    rows = np.array(
        [[draw(p) for p in parts] for _ in range(draw(st.integers(0, 6)))]
    ).reshape(-1, 6)
    field = NavigationField(
        Workspace(np.zeros(2), np.array([3.0, 3.0])),
        np.array([draw(centre), draw(centre)]),
        10.0 ** draw(st.floats(0.0, most_kappa)),
        ObstacleSet(rows[:, :5], rows[:, 5]),
    )
    q = np.array([draw(st.floats(-2.5, 2.5)), draw(st.floats(-2.5, 2.5))])
    assume(min_beta(q, field) > 0.01)
    assume(np.hypot(*(q - field.goal)) > 0.01)
    return field, q


def _turned(
    field: NavigationField, turn: FloatArray, angle: float, scale: float
) -> NavigationField:
    theta = field.obstacles.theta.copy()
    theta[:, :2] = scale * theta[:, :2] @ turn.T
    theta[:, 2:4] *= scale
    theta[:, 4] += angle
    return NavigationField(
        Workspace(np.zeros(2), scale * field.workspace.semi_axes),
        scale * turn @ field.goal,
        field.kappa,
        ObstacleSet(theta, field.obstacles.powers),
    )


@settings(max_examples=100)
@given(worlds(most_kappa=1.0))
def test_it_is_the_papers_formula(world: tuple[NavigationField, FloatArray]) -> None:
    field, q = world
    gamma = ((q - field.goal) ** 2).sum()
    b = beta(q, field.obstacles)
    product = field.workspace.beta(q) * (b**field.obstacles.powers).prod()
    # kappa up to 10: plain powers still hold. beta above 0.01 is good to 1e-14,
    # kappa ln gamma to 1e-14, and phi's exponent is at most one.
    np.testing.assert_allclose(
        phi(q, field),
        gamma / (gamma**field.kappa + product) ** (1 / field.kappa),
        1e-12,
    )
    s = -2.0 * q / 9.0 / field.workspace.beta(q)
    s = s + (field.obstacles.powers / b) @ grad_beta(q, field.obstacles)
    v = gamma * s - 2.0 * field.kappa * (q - field.goal)
    terms = gamma * np.abs(s).max() + 2.0 * field.kappa
    assume(np.hypot(*v) > 1e-6 * terms)  # near critical points only rounding is left
    np.testing.assert_allclose(
        flow_direction(q, field), v / np.hypot(*v), rtol=0, atol=1e-7
    )


@settings(max_examples=50)
@given(worlds(), st.integers(1, 50))
def test_a_batch_of_flows_is_each_points_own_bit_by_bit(
    world: tuple[NavigationField, FloatArray], count: int
) -> None:
    field, q = world
    rng = np.random.default_rng(count)
    points = np.concatenate([[q], rng.uniform(-3.2, 3.2, (count, 2)), [field.goal]])
    together = flow_direction(points, field)
    for point, found in zip(points, together, strict=True):
        np.testing.assert_array_equal(flow_direction(point, field), found)
    # And the roll-out's own: its first step in the open is a midpoint step of these.
    path = rollout(q, field, step=1e-3, max_steps=1).path
    if len(path) == 2 and np.hypot(*(path[1] - q)) > 0.99e-3:
        middle = flow_direction(q + 0.5 * 1e-3 * flow_direction(q, field), field)
        np.testing.assert_array_equal(path[1], q + 1e-3 * middle)


@settings(max_examples=100)
@given(worlds(), st.floats(-3.1, 3.1))
def test_phi_and_its_derivatives_turn_with_the_world(
    world: tuple[NavigationField, FloatArray], angle: float
) -> None:
    field, q = world
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    moved, p = _turned(field, turn, angle, 1.0), turn @ q
    # Coordinates lose 1e-15, beta of 0.01 with axes of 0.1 then 1e-12, and kappa
    # 1000 times as much of ln phi's argument.
    np.testing.assert_allclose(phi(p, moved), phi(q, field), rtol=1e-9)
    for function, expected in (
        (grad_phi, turn @ grad_phi(q, field)),
        (hessian_phi, turn @ hessian_phi(q, field) @ turn.T),
        (hessian_psi, turn @ hessian_psi(q, field) @ turn.T),
    ):
        size = np.abs(expected).max()
        # Derivatives are sums whose terms may cancel: 1e-6 of the largest entry.
        np.testing.assert_allclose(
            function(p, moved), expected, rtol=0, atol=1e-6 * size + 1e-290
        )


@settings(max_examples=100)
@given(worlds(), st.integers(-20, 20))
def test_the_flow_does_not_depend_on_the_unit_of_length(
    world: tuple[NavigationField, FloatArray], octaves: int
) -> None:
    field, q = world
    # Exact, so that every rounding error scales too, but for numbers below 1e-308.
    scale = 2.0**octaves
    moved = _turned(field, np.eye(2), 0.0, scale)
    for function, dimension in (
        (flow_direction, 0),
        (min_beta, 0),
        (grad_psi, 1),
        (hessian_psi, 2),
    ):
        np.testing.assert_allclose(
            scale**dimension * function(scale * q, moved),
            function(q, field),
            rtol=0,
            atol=1e-300,
        )
