"""The oracle and the catalogue, checked without the certificate they are to judge."""

import numpy as np
import pytest
from basins import find_minima, grad_hessian, least_beta, polish, psi
from folds import broadside, fold, pitchfork, tilted, tilted_by_kappa
from worlds import KNOWN, WORLDS, make

from bath_drake.field.navigation import grad_psi, hessian_psi, ln_phi, min_beta

_FREE_GOAL = [n for n, w in WORLDS.items() if least_beta(w.field.goal, w.field) > 1e-12]


@pytest.mark.parametrize("power", [2, 4, 8])
def test_the_field_written_anew_is_the_field(power: int) -> None:
    rows = [[0, 0.2, 1, 0.5, 0.3], [-2, -1, 0.5, 0.9, 1], [1, 2, 0.3, 0.4, -2]]
    field = make(
        7, *rows, exponents=[1, 0.5, 2], power=power, centre=(0.1, 0.2), goal=(2, -1)
    )
    q = np.random.default_rng(4).uniform(-4.0, 4.0, (200, 2))
    np.testing.assert_allclose(least_beta(q, field), min_beta(q, field), rtol=1e-9)
    q = q[min_beta(q, field) > 0.01]
    # phi from psi by the definition; beta > 0.01 magnifies rounding by 100.
    value = psi(q, field).astype(float)
    expected = -np.logaddexp(0.0, -value) / field.kappa
    np.testing.assert_allclose(ln_phi(q, field), expected, rtol=1e-11, atol=1e-13)
    for point in q[:20]:
        gradient, hessian = grad_hessian(point, field)
        size = np.abs(hessian).max()
        np.testing.assert_allclose(
            grad_psi(point, field), gradient.astype(float), rtol=0, atol=1e-11 * size
        )
        np.testing.assert_allclose(
            hessian_psi(point, field), hessian.astype(float), rtol=0, atol=1e-11 * size
        )


@pytest.mark.parametrize("name", KNOWN)
def test_the_oracle_finds_the_critical_points_that_are_known(name: str) -> None:
    world = KNOWN[name]
    found = [(m.x, m.y) for m in find_minima(world.field)]
    # The reference gives five decimals.
    np.testing.assert_allclose(
        np.reshape(found, (-1, 2)), np.reshape(world.minima, (-1, 2)), atol=1e-5
    )
    for x, y in world.saddles or ():
        root = polish(x, y, world.field)
        assert root is not None
        assert np.hypot(root.x - x, root.y - y) < 1e-5
        assert root.low < 0.0 < root.high


@pytest.mark.parametrize("name", _FREE_GOAL)
def test_brute_force_finds_a_trap_just_where_the_catalogue_says_so(name: str) -> None:
    world = WORLDS[name]
    found = [(m.x, m.y) for m in find_minima(world.field)]
    if "proved" in world.verdicts:
        assert found == []
    else:
        assert found
    if world.minima is not None:
        np.testing.assert_allclose(
            np.reshape(found, (-1, 2)), np.reshape(world.minima, (-1, 2)), atol=1e-5
        )


def test_the_minimum_of_a_fold_is_born_where_the_oracle_says() -> None:
    for build, low, high, guess, sign in (
        (tilted, 1.4, 1.6, (-1.1, -0.65), 1.0),
        (tilted_by_kappa, 20.0, 30.0, (-1.0, -0.65), -1.0),
    ):
        birth = fold(build, low, high, guess)
        assert np.nextafter(birth.below, np.inf) == birth.above
        # The two critical points part like the root of the distance, by 0.1 here.
        with_one = find_minima(build(birth.above * (1.0 + 0.01 * sign)), 257)
        without = find_minima(build(birth.below * (1.0 - 0.01 * sign)), 257)
        assert len(with_one) == 1
        assert np.hypot(with_one[0].x - birth.x, with_one[0].y - birth.y) < 0.2
        assert without == []


def test_the_saddle_behind_a_broadside_ellipse_turns_at_the_pitchfork() -> None:
    birth = pitchfork(broadside, 0.8, 1.4, -1.25)
    assert np.nextafter(birth.below, np.inf) == birth.above
    before = polish(birth.x, 0.0, broadside(birth.below * (1.0 - 1e-6)))
    after = polish(birth.x, 0.0, broadside(birth.above * (1.0 + 1e-6)))
    assert before is not None
    assert after is not None
    assert before.low < 0.0 < after.low
