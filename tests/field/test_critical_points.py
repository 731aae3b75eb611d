"""The numeric search on worlds whose critical points are known."""

import numpy as np
import pytest

from bath_drake.field.critical_points import find_critical_points
from bath_drake.field.navigation import NavigationField, grad_psi, hessian_psi
from bath_drake.field.obstacles import ObstacleSet, Workspace

Row = list[float]


def _world(kappa: float, *rows: Row) -> NavigationField:
    theta = np.array(rows, dtype=np.float64).reshape(-1, 5)
    disc = Workspace(np.zeros(2), np.array([5.0, 5.0]))
    return NavigationField(disc, np.array([3.0, 0.0]), kappa, ObstacleSet(theta))


KNOWN = {
    "one disc": (_world(4, [0, 0, 1, 1, 0]), [(-1.67172, 0)], []),
    "broadside ellipse": (
        _world(10, [-0.5, 0, 0.2, 1.6, 0]),
        [(-0.55205, -1.97946), (-0.55205, 1.97946)],
        [(-0.97537, 0)],
    ),
    "overlapping, across": (
        _world(10, [0, 0.6, 0.8, 0.8, 0], [0, -0.6, 0.8, 0.8, 0]),
        None,
        [(-1.06166, 0)],
    ),
    "overlapping, in line": (
        _world(10, [0.6, 0, 0.8, 0.8, 0], [-0.6, 0, 0.8, 0.8, 0]),
        [(-1.74547, 0)],
        [],
    ),
}


@pytest.mark.parametrize("name", KNOWN)
def test_known_worlds_show_their_critical_points(name: str) -> None:
    field, saddles, minima = KNOWN[name]
    points = find_critical_points(field)
    for kind, expected in (("saddle", saddles), ("minimum", minima)):
        if expected is None:
            continue
        found = [(p.x, p.y) for p in points if p.kind == kind]
        # The reference gives five decimals.
        np.testing.assert_allclose(
            np.reshape(found, (-1, 2)), np.reshape(expected, (-1, 2)), atol=1e-5
        )


@pytest.mark.parametrize(("offset", "minima"), [(0.805, 1), (0.85, 0)])
def test_a_slit_between_two_discs_traps_only_when_narrow(
    offset: float, minima: int
) -> None:
    field = _world(20, [-0.5, offset, 0.8, 0.8, 0], [-0.5, -offset, 0.8, 0.8, 0])
    kinds = [p.kind for p in find_critical_points(field)]
    assert kinds.count("minimum") == minima


def test_an_empty_workspace_has_no_critical_point_but_the_goal() -> None:
    assert find_critical_points(_world(2)) == ()


def test_random_disjoint_discs_have_one_saddle_each() -> None:
    rng = np.random.default_rng(5)
    for _ in range(8):
        rows: list[Row] = []
        while len(rows) < 6:
            x, y, r = *rng.uniform(-3.5, 3.5, 2), rng.uniform(0.2, 0.6)
            apart = all(np.hypot(x - q[0], y - q[1]) > r + q[2] + 0.2 for q in rows)
            inside = np.hypot(x, y) + r < 4.8
            if apart and inside and np.hypot(x - 3, y) > r + 0.5:
                rows.append([x, y, r, r, 0.0])
        points = find_critical_points(_world(80, *rows))
        assert [p.kind for p in points] == ["saddle"] * 6


def test_the_kind_is_that_of_the_hessian() -> None:
    field = KNOWN["broadside ellipse"][0]
    for p in find_critical_points(field):
        low, high = p.eigenvalues
        found = np.linalg.eigvalsh(hessian_psi([p.x, p.y], field))
        # The Hessian of the search is that of its last step, good to 1e-9.
        np.testing.assert_allclose(found, [low, high], rtol=1e-7)
        assert p.kind == ("minimum" if low > 0.0 else "saddle")
        assert high > 0.0


def test_the_points_found_are_roots() -> None:
    field = _world(12, [0, 0.2, 1, 0.5, 0.3], [-2, -1, 0.5, 0.9, 1])
    points = find_critical_points(field)
    assert len(points) == 2
    for p in points:
        q = np.array([p.x, p.y])
        # Against 2 kappa / distance, the size of the attracting term alone.
        scale = 24.0 / np.hypot(*(q - field.goal))
        assert np.hypot(*grad_psi(q, field)) < 1e-8 * scale
