"""Uncertain obstacles: a verdict holds for every realisation, or is none."""

import itertools
from dataclasses import replace

import hypothesis.strategies as st
import numpy as np
import pytest
from basins import find_minima, polish, psi
from checks import assert_all_arrive, holds
from hypothesis import given, settings
from reach import BEHIND, BROADSIDE, assert_out_of_reach, near_goal
from strategies import any_worlds, disjoint_worlds, worlds
from worlds import make

from bath_drake.certificate.certify import Uncertainty, certify
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet

# Enough for all these worlds; where tolerances leave doubt, all of it is spent.
_EFFORT = 10_000
tolerances = st.floats(-5.0, -0.5).map(lambda e: 10.0**e)


def _realisation(field: NavigationField, tolerance: float, signs) -> NavigationField:
    theta = field.obstacles.theta.copy()
    theta[:, :4] += tolerance * signs
    return NavigationField(
        field.workspace,
        field.goal,
        field.kappa,
        ObstacleSet(theta, field.obstacles.powers),
    )


@settings(max_examples=40)
@given(disjoint_worlds(most=4), tolerances, st.integers(0, 2**32 - 1))
def test_a_verdict_under_uncertainty_holds_for_every_realisation(
    field: NavigationField, tolerance: float, seed: int
) -> None:
    tolerance *= 0.1  # at most 0.032: half of the smallest semi-axis
    found = certify(
        field, uncertainty=Uncertainty(tolerance, tolerance), budget=_EFFORT
    )
    rng = np.random.default_rng(seed)
    shape = (len(field.obstacles), 4)
    for signs in (
        np.zeros(shape),
        rng.choice([-1.0, 1.0], shape),  # corners
        rng.uniform(-1.0, 1.0, shape),
    ):
        real = _realisation(field, tolerance * (1.0 - 1e-12), signs)
        if found.passed:
            assert find_minima(real) == []
            assert certify(real).verdict != "refuted"
        for trap in found.traps:
            root = polish(trap.x, trap.y, real)
            assert root is not None
            assert holds(trap.box, root)
            assert root.low > 0.0


@settings(max_examples=40)
@given(worlds, tolerances)
def test_more_uncertainty_never_makes_a_proof_of_what_is_none(
    field: NavigationField, tolerance: float
) -> None:
    least = field.obstacles.theta[:, 2:4].min(initial=np.inf)
    tolerance = min(tolerance, 0.5 * least)
    verdicts = [
        certify(field, uncertainty=Uncertainty(t, t), budget=_EFFORT).verdict
        for t in (0.0, 0.1 * tolerance, tolerance)
    ]
    exact = certify(field, budget=_EFFORT)
    assert verdicts[0] == exact.verdict
    for less, more in itertools.pairwise(verdicts):
        assert not (less != "proved" and more == "proved")
        assert not (less != "refuted" and more == "refuted")


def test_a_region_is_refuted_under_uncertainty_only_if_every_realisation_is() -> None:
    # The start's psi is a thousandth below the trap's: its own set is free of traps.
    # Tolerances raise the level that surely holds the start, past the trap.
    trap = polish(-0.97537, 0.0, BROADSIDE)
    assert trap is not None
    level = float(psi([trap.x, trap.y], BROADSIDE)) - 1e-3
    low, high = -0.303, 2.9  # from the ellipse on, psi falls towards the goal
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = float(psi([middle, 0.3], BROADSIDE)) > level
        low, high = (middle, high) if above else (low, middle)
    start = [[high, 0.3]]
    assert certify(BROADSIDE, starts=start).passed
    for tolerance, verdict in ((1e-6, "proved"), (1e-5, "undecided")):
        uncertainty = Uncertainty(tolerance, tolerance)
        found = certify(BROADSIDE, starts=start, uncertainty=uncertainty)
        assert found.verdict == verdict
    # A start well above the trap stays refuted.
    uncertainty = Uncertainty(1e-5, 1e-5)
    found = certify(BROADSIDE, starts=BEHIND, uncertainty=uncertainty)
    assert found.verdict == "refuted"


def test_uncertainty_is_named_as_the_cause_where_it_makes_the_difference() -> None:
    # A gap of 2 % of the radius passes, one of 0.2 % traps: tolerances that reach
    # from the one to the other leave both possible.
    field = make(20, [-0.5, 0.85, 0.8, 0.8, 0], [-0.5, -0.85, 0.8, 0.8, 0])
    assert certify(field).passed
    found = certify(field, uncertainty=Uncertainty(centres=0.05))
    assert found.verdict == "undecided"
    assert {d.cause for d in found.doubts} == {"uncertainty"}
    assert certify(field, uncertainty=Uncertainty(centres=0.001)).passed


def test_each_obstacle_can_have_a_tolerance_of_its_own() -> None:
    gap = [[-0.5, 0.85, 0.8, 0.8, 0.0], [-0.5, -0.85, 0.8, 0.8, 0.0]]
    field = make(20, *gap, [-3.0, 3.0, 0.3, 0.3, 0.0])

    def verdict(*centres: float) -> str:
        return certify(field, uncertainty=Uncertainty(centres=centres)).verdict

    # The far obstacle may lie anywhere within 0.02; the two at the gap may not.
    assert verdict(0.0, 0.0, 0.02) == "proved"
    assert verdict(0.02, 0.02, 0.0) == "undecided"
    even = Uncertainty(np.full(3, 1e-3), np.full(3, 1e-3))
    one, two = (certify(field, uncertainty=u) for u in (even, Uncertainty(1e-3, 1e-3)))
    assert replace(one, seconds=0.0) == replace(two, seconds=0.0)


def test_a_goal_or_start_that_only_some_realisations_leave_free_is_undecided() -> None:
    field = make(10, [1.95, 0, 1, 1, 0])
    assert certify(field).passed
    found = certify(field, uncertainty=Uncertainty(centres=0.1))
    assert found.verdict == "undecided"
    assert {d.cause for d in found.doubts} == {"uncertainty"}
    found = certify(
        make(10, [0, 0, 1, 1, 0]),
        starts=[[-1.05, 0.0]],
        uncertainty=Uncertainty(semi_axes=0.1),
    )
    assert found.verdict == "undecided"


@pytest.mark.parametrize(
    "arguments",
    [
        {"centres": -1.0},
        {"semi_axes": np.nan},
        {"centres": np.inf},
        {"centres": np.zeros(3)},
        {"semi_axes": 1.0},
    ],
)
def test_uncertainties_that_make_no_sense_are_refused(arguments) -> None:
    with pytest.raises(ValueError, match=next(iter(arguments))):
        certify(make(4, [0, 0, 1, 1, 0]), uncertainty=Uncertainty(**arguments))


@settings(max_examples=30)
@given(any_worlds(), tolerances, st.integers(0, 2**32 - 1))
def test_a_region_proved_under_uncertainty_is_proved_for_realisations(
    field: NavigationField, tolerance: float, seed: int
) -> None:
    tolerance = min(tolerance, 0.05, 0.2 * field.obstacles.theta[:, 2:4].min(initial=1))
    starts = near_goal(field, seed)
    found = certify(
        field,
        starts=starts,
        uncertainty=Uncertainty(tolerance, tolerance),
        budget=_EFFORT,
    )
    if not found.passed:
        return
    assert found.region is not None
    rng = np.random.default_rng(seed)
    for _ in range(3):
        signs = rng.uniform(-1.0, 1.0, (len(field.obstacles), 4))
        real = _realisation(field, tolerance, signs)
        assert (psi(starts, real) <= found.region).all()
        assert_all_arrive(starts, real)
        assert_out_of_reach(found, real, starts)
