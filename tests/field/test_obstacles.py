"""Properties of the implicit functions beta_i."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from bath_drake.field.obstacles import (
    ObstacleSet,
    Workspace,
    beta,
    curvature_margin,
    grad_beta,
    hessian_beta,
    pair_gaps,
    suits_large_kappa,
    support,
)
from bath_drake.notation import FloatArray

coordinate = st.floats(-2.0, 2.0)
axis = st.floats(0.05, 1.5)
rows = st.tuples(coordinate, coordinate, axis, axis, st.floats(-4.0, 4.0))
sets = st.lists(rows, min_size=1, max_size=4).map(
    lambda r: ObstacleSet(np.array(r, dtype=np.float64))
)
points = st.tuples(coordinate, coordinate).map(np.array)


@given(sets, points)
def test_gradient_and_hessian_agree_with_central_differences(
    obstacles: ObstacleSet, q: FloatArray
) -> None:
    # beta is quadratic: central differences are exact but for rounding, which a
    # step of 1e-3 magnifies by 1e3 (gradient), over values up to 4e3.
    h = 1e-3
    steps = h * np.eye(2)
    gradient = [
        (beta(q + e, obstacles) - beta(q - e, obstacles)) / (2 * h) for e in steps
    ]
    np.testing.assert_allclose(
        np.stack(gradient, axis=-1), grad_beta(q, obstacles), rtol=1e-9, atol=1e-7
    )
    hessian = [
        (grad_beta(q + e, obstacles) - grad_beta(q - e, obstacles)) / (2 * h)
        for e in steps
    ]
    np.testing.assert_allclose(
        np.stack(hessian, axis=-1), hessian_beta(obstacles), rtol=1e-9, atol=1e-7
    )


@given(sets)
def test_beta_vanishes_on_the_boundary_and_is_minus_one_in_the_centre(
    obstacles: ObstacleSet,
) -> None:
    boundary = obstacles.boundary(16)
    for i in range(len(obstacles)):
        values = beta(boundary[i], obstacles)[:, i]
        # Coordinates up to 3.5 carry 4e-16 of rounding; an axis of 0.05 turns
        # that into 2 * 4e-16 / 0.05.
        np.testing.assert_allclose(values, 0.0, atol=1e-13)
        assert beta(obstacles.theta[i, :2], obstacles)[i] == -1.0


@given(sets, st.floats(0.0, 6.3))
def test_no_boundary_point_reaches_beyond_the_support(
    obstacles: ObstacleSet, angle: float
) -> None:
    n = np.array([[np.cos(angle), np.sin(angle)]])
    along = (obstacles.boundary(256) - obstacles.theta[:, None, :2]) @ n[0]
    reach = support(obstacles, n)[0]
    assert (along.max(axis=1) <= reach + 1e-12).all()
    # 256 points miss the extreme one by half a step of 0.0245 rad at most; the
    # loss is 1 - cos(0.0123) of the reach.
    np.testing.assert_allclose(along.max(axis=1), reach, rtol=1e-4)


@settings(max_examples=50)
@given(rows, rows)
def test_the_pair_gap_is_the_distance_and_negative_when_they_overlap(
    first: tuple[float, ...], second: tuple[float, ...]
) -> None:
    pair = ObstacleSet(np.array([first, second]))
    gap = pair_gaps(pair)[0, 1]
    one, other = pair.boundary(200)
    distance = np.linalg.norm(one[:, None] - other[None], axis=-1).min()
    if gap > 0.0:
        # Both sides sample: boundaries every 1.5 * 0.0314 apart, directions finer.
        assert gap <= distance + 1e-12
        assert distance <= gap + 0.05
    else:
        meets = (beta(one, pair)[:, 1] <= 0.0).any() or (
            beta(other, pair)[:, 0] <= 0
        ).any()
        assert meets or distance < 0.05


@given(
    st.floats(0.05, 1.0),
    st.floats(0.05, 1.0),
    st.floats(-3.1, 3.1),
    st.floats(1.05, 8.0),
    st.floats(-3.1, 3.1),
)
def test_the_curvature_test_agrees_with_a_scan_of_the_boundary(
    a: float, b: float, angle: float, far: float, bearing: float
) -> None:
    obstacle = ObstacleSet(np.array([[0.3, -0.2, a, b, angle]]))
    # A goal outside: `far` times the ellipse's own boundary point.
    u, v = far * a * np.cos(bearing), far * b * np.sin(bearing)
    c, s = np.cos(angle), np.sin(angle)
    goal = np.array([0.3 + c * u - s * v, -0.2 + s * u + c * v])
    if abs(curvature_margin(obstacle, goal)[0]) < 1e-3:
        return  # too close to call on a grid
    t = np.linspace(0.0, 2.0 * np.pi, 20001)
    x, y = a * np.cos(t) - u, b * np.sin(t) - v
    nx, ny = np.cos(t) / a, np.sin(t) / b
    across = x * ny - y * nx  # zero where the normal is parallel to q - q_d
    away = x * nx + y * ny > 0.0
    crossing = np.flatnonzero((across[:-1] * across[1:] <= 0.0) & away[:-1])
    curvature = a * b / np.hypot(a * np.sin(t), b * np.cos(t)) ** 3
    bends = curvature * np.hypot(x, y) > 1.0
    assert suits_large_kappa(obstacle, goal)[0] == bends[crossing].all()


def test_every_circle_suits_large_kappa_and_a_broadside_ellipse_does_not() -> None:
    goal = np.array([3.0, 0.0])
    worlds = ObstacleSet(
        np.array([[0, 0, 1, 1, 0], [-0.5, 0, 0.2, 1.6, 0]], dtype=float)
    )
    assert suits_large_kappa(worlds, goal).tolist() == [True, False]


def test_the_sum_of_sets_lists_the_rows_of_both() -> None:
    one = ObstacleSet(np.array([[0.0, 0.0, 1.0, 1.0, 0.0]]))
    two = ObstacleSet(np.array([[2.0, 0.0, 1.0, 0.5, 0.1]]), np.array([2.0]))
    both = one + two
    assert len(both) == 2
    assert both.powers.tolist() == [1.0, 2.0]
    assert both + ObstacleSet() == both
    assert both != one


def test_obstacle_arrays_cannot_be_changed_and_are_copies() -> None:
    theta = np.array([[0.0, 0.0, 1.0, 1.0, 0.0]])
    obstacles = ObstacleSet(theta)
    theta[0, 0] = 5.0
    assert obstacles.theta[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        obstacles.theta[0, 0] = 1.0


@pytest.mark.parametrize(
    ("theta", "exponents", "message"),
    [
        ([[0, 0, 1, 1]], None, r"shape \(Q, 5\)"),
        ([[0, 0, 1, 0, 0]], None, "semi-axes must be positive"),
        ([[0, 0, 1, np.nan, 0]], None, "non-finite"),
        ([[0, 0, 1, 1, 0]], [0.0], "exponent must be positive"),
        ([[0, 0, 1, 1, 0]], [1.0, 1.0], r"exponents must have shape \(1,\)"),
    ],
)
def test_bad_obstacles_are_refused(
    theta: list[list[float]], exponents: list[float] | None, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        ObstacleSet(
            np.array(theta, dtype=float),
            None if exponents is None else np.array(exponents),
        )


@pytest.mark.parametrize("power", [0, 1, 3, -2, 2.5])
def test_the_workspace_power_must_be_even(power: int) -> None:
    with pytest.raises(ValueError, match="power must be even"):
        Workspace(np.zeros(2), np.ones(2), power)
