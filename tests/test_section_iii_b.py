"""The claims of the paper's Section III-B, on the code of tutorial 01."""

import os
import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from bath_drake.certificate.certify import certify
from bath_drake.field.rollout import RolloutStatus, rollout

TUTORIAL = Path(__file__).parent.parent / "tutorials" / "01_navigation_function.py"


@pytest.fixture(scope="module")
def tutorial():
    """The tutorial's names, after it ran without a window."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(os.environ, "MPLBACKEND", "Agg")
        import matplotlib.pyplot as plt

        backend = plt.get_backend()
        plt.switch_backend("Agg")
        patch.setattr(plt, "show", lambda: None)
        names = runpy.run_path(str(TUTORIAL))
        plt.close("all")
        plt.switch_backend(backend)
    return SimpleNamespace(**names)


@pytest.fixture
def x2(tutorial):
    """The deflection as a function of the obstacle's centre (and kappa)."""
    return lambda x1, *kappa: tutorial.deflection(tutorial.path(x1, *kappa))


@pytest.mark.parametrize("x1", [-1.5, -1.2, 1.2, 1.5])
def test_cases_i_and_iv_a_far_obstacle_leaves_the_path_on_the_axis(x1, x2):
    # Its push falls like 1 / (kappa x1), so that "on the axis" needs a tolerance:
    # a hundredth of the way from start to goal, 1.6, at kappa = 40 ...
    assert abs(x2(x1)) < 0.016
    # ... and what is left goes with 1 / kappa, to first order.
    assert x2(x1, 160.0) == pytest.approx(x2(x1) / 4.0, rel=0.05)


@pytest.mark.parametrize("x1", [0.05, 0.15, 0.3])
def test_cases_ii_and_iii_the_path_goes_round_on_the_other_side(x1, x2, tutorial):
    clear = tutorial.RADIUS - x1  # how far the obstacle reaches across the axis
    assert x2(-x1) > clear  # II: obstacle left, path right
    assert x2(x1) < -clear  # III: obstacle right, path left


@pytest.mark.parametrize("x1", [0.01, 0.2, 0.5, 1.3])
def test_the_relation_is_odd(x1, x2):
    # The world is mirrored exactly; sums in another order round differently.
    assert x2(x1) == pytest.approx(-x2(-x1), abs=1e-12)


def test_the_deflection_jumps_where_the_obstacle_crosses_the_axis(x2, tutorial):
    for near in (1e-2, 1e-4, 1e-8):
        # Twice the radius or more, however near: no limit of resolution.
        assert x2(-near) - x2(near) > 2.0 * tutorial.RADIUS * 0.99
    head_on = rollout(tutorial.START, tutorial.world(0.0))
    assert head_on.status is RolloutStatus.TRAPPED
    assert head_on.path[-1, 1] > tutorial.RADIUS  # at the saddle behind the obstacle


def test_the_deflection_grows_all_the_way_to_the_jump(tutorial):
    for left, right in tutorial.curves.values():
        assert (np.diff(left) > 0.0).all()
        assert (np.diff(right) > 0.0).all()
        assert left[0] > 0.0 > right[-1]


def test_every_path_but_the_head_on_one_arrives(tutorial):
    for x1 in (-1.5, -0.4, -1e-3, 1e-3, 0.25, 1.0):
        found = rollout(tutorial.START, tutorial.world(x1))
        assert found.status is RolloutStatus.ARRIVED
        assert found.min_beta > 0.0


def test_descent_from_initial_runs_to_final_and_never_to_target(tutorial):
    plateau = tutorial.cost(-tutorial.LIMIT)
    steps = np.geomspace(0.01, 10.0, 7)
    for omega in steps:
        iterates = tutorial.descend(tutorial.INITIAL, float(omega))
        assert (np.diff(iterates) <= 0.0).all()  # pushed away at every step
        # Clear of the axis: the stroke is not bent at all there, and the cost is
        # the stroke's own deflection, within the far obstacle's remaining push.
        assert iterates[-1] < -tutorial.RADIUS
        assert tutorial.cost(iterates[-1]) == pytest.approx(plateau, rel=0.1)
        assert tutorial.cost(iterates[-1]) > 0.9 * abs(
            tutorial.deflection(tutorial.stroke)
        )
    assert tutorial.cost(tutorial.TARGET) == 0.0


@pytest.mark.parametrize("initial", [-1.0, -0.3, -0.02])
def test_so_does_descent_from_anywhere_left_of_the_axis(tutorial, initial):
    assert (np.diff(tutorial.descend(initial, 0.1, iterations=30)) <= 0.0).all()


def test_the_cost_is_not_convex_and_not_even_in_one_piece(tutorial):
    final, target = tutorial.FINAL, tutorial.TARGET
    middle = tutorial.cost(0.5 * (final + target))
    assert middle > 0.5 * (tutorial.cost(final) + tutorial.cost(target))
    # From Final to Target every way is uphill first: not even quasi-convex.
    between = [tutorial.cost(x1) for x1 in np.linspace(final, -1e-3, 30)]
    assert (np.diff(between) > 0.0).all()
    assert between[-1] > 2.0 * tutorial.cost(final)


def test_a_population_reaches_target(tutorial):
    assert tutorial.evolved.x[0] == pytest.approx(tutorial.TARGET, abs=2e-3)
    ends = tutorial.ends[:, 0]
    right = tutorial.members[:, 0] > 0.0
    np.testing.assert_allclose(ends[right], tutorial.TARGET, atol=2e-3)
    np.testing.assert_allclose(ends[~right], -tutorial.LIMIT)


@pytest.mark.parametrize("seed", range(3))
def test_a_population_reaches_target_whatever_the_seed(tutorial, seed):
    # A search without descent: its resolution after 20 generations.
    found = tutorial.differential_evolution(
        lambda x: tutorial.cost(x[0]),
        [(-tutorial.LIMIT, tutorial.LIMIT)],
        popsize=8,
        maxiter=20,
        rng=seed,
        polish=False,
    )
    assert found.x[0] == pytest.approx(tutorial.TARGET, abs=2e-3)


def test_the_tutorials_certificates_are_what_it_says(tutorial):
    proved, refuted = tutorial.certificates.values()
    assert proved.verdict == "proved"
    assert [p.kind for p in proved.critical_points] == ["saddle"]
    assert refuted.verdict == "refuted"
    kinds = sorted(p.kind for p in refuted.critical_points)
    assert kinds == ["minimum", "saddle", "saddle"]
    assert tutorial.certify(tutorial.world(0.25)).passed


@pytest.mark.parametrize("kappa", [1.2, 3.0, 30.0, 200.0])
def test_no_kappa_frees_the_bay_of_the_broadside_ellipse(tutorial, kappa):
    field = tutorial.known_world(kappa, -0.5, 0.0, 0.2, 1.6, 0.0)
    assert certify(field).verdict == "refuted"
