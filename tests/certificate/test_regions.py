"""Sublevel sets and uncertain obstacles."""

import itertools
from dataclasses import replace

import hypothesis.strategies as st
import numpy as np
import pytest
from basins import find_minima, least_beta, polish, psi
from checks import assert_all_arrive, holds
from hypothesis import given, settings
from random_worlds import KINDS, random_world
from scipy.ndimage import label
from strategies import any_worlds, disjoint_worlds, worlds
from worlds import make

from bath_drake.certificate.certify import Uncertainty, certify, certify_from
from bath_drake.certificate.result import Certificate
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.notation import FloatArray

# Proved only in part: the minimum lies behind the ellipse, at (-0.97537, 0).
BROADSIDE = make(10, [-0.5, 0, 0.2, 1.6, 0])
BEYOND = [[1.0, 0.5], [0.5, -1.0], [3.0, 2.0]]
BEHIND = [[-3.0, 0.2]]


def _free(field: NavigationField, count: int, seed: int) -> FloatArray:
    q = np.random.default_rng(seed).uniform(-5.0, 5.0, (count, 2))
    return q[least_beta(q, field) > 1e-3]


def _near_goal(field: NavigationField, seed: int) -> FloatArray:
    """Three free points about the goal, nearer where it is narrow."""
    turns = np.random.default_rng(seed).uniform(-1.0, 1.0, (3, 2))
    reach = 2.0
    while True:
        q = field.goal + reach * turns
        if (least_beta(q, field) > 1e-3).all():
            return q
        reach /= 2.0


def _below(field: NavigationField, level: float, seed: int) -> FloatArray:
    q = _free(field, 300, seed)
    return q[psi(q, field) <= level][:60]


def test_a_refuted_world_can_have_a_proved_region() -> None:
    assert certify(BROADSIDE).verdict == "refuted"
    region = certify(BROADSIDE, starts=BEYOND)
    assert region.passed, region.reason
    assert region.region is not None
    assert region.traps == ()
    assert_all_arrive(_below(BROADSIDE, region.region, 1), BROADSIDE)
    # All the way round the trap: its own sublevel set is left out.
    trap = polish(-0.97537, 0.0, BROADSIDE)
    assert trap is not None
    assert region.region < float(psi([trap.x, trap.y], BROADSIDE))


def test_a_region_that_holds_the_trap_is_refuted() -> None:
    region = certify(BROADSIDE, starts=BEHIND)
    assert region.verdict == "refuted"
    (trap,) = region.traps
    assert trap.box.holds(trap.x, trap.y)
    assert region.region is not None
    edges = [
        (x, y)
        for x in (trap.box.x_min, trap.box.x_max)
        for y in (trap.box.y_min, trap.box.y_max)
    ]
    assert (psi(edges, BROADSIDE) <= region.region).all()


def test_from_the_trap_s_level_on_the_start_s_component_is_told_apart() -> None:
    trap = polish(-0.97537, 0.0, BROADSIDE)
    assert trap is not None
    level = float(psi([trap.x, trap.y], BROADSIDE))
    # Starts on the goal's side, found by bisection along y = 0.3, whose psi is the
    # trap's less or plus a millionth.
    for offset, apart in ((-1e-6, False), (1e-6, True)):
        low, high = -0.303, 2.9  # from the ellipse on, psi falls towards the goal here
        for _ in range(60):
            middle = 0.5 * (low + high)
            above = float(psi([middle, 0.3], BROADSIDE)) > level + offset
            low, high = (middle, high) if above else (low, middle)
        found = certify(BROADSIDE, starts=[[high, 0.3]])
        assert found.verdict == "proved"
        assert found.apart is apart


@settings(max_examples=60)
@given(worlds, st.integers(0, 2**32 - 1))
def test_a_proved_region_holds_its_starts_and_all_that_starts_in_it_arrives(
    field: NavigationField, seed: int
) -> None:
    starts = _near_goal(field, seed)
    found = certify(field, starts=starts)
    assert found.region is not None
    highest = float(psi(starts, field).max())
    # The level is rounded up, by about 1e-15 a term; and no more.
    assert highest - 1e-12 <= found.region <= highest + 1e-9 * (1 + abs(highest))
    assert found.region >= psi(starts, field).max()
    if found.passed:
        assert_all_arrive(starts, field)
        if not found.apart:
            assert_all_arrive(_below(field, found.region, seed), field)
    for trap in found.traps:
        root = polish(trap.x, trap.y, field)
        assert root is not None
        assert holds(trap.box, root)
        assert float(psi([root.x, root.y], field)) <= found.region


@settings(max_examples=40)
@given(worlds, st.integers(0, 2**32 - 1))
def test_the_whole_and_its_regions_agree(field: NavigationField, seed: int) -> None:
    starts = _near_goal(field, seed)
    whole, region = certify(field), certify(field, starts=starts)
    if whole.passed:
        assert region.verdict != "refuted"
    if region.verdict == "refuted":
        assert whole.verdict != "proved"
    larger = certify(field, starts=np.concatenate([starts, _free(field, 3, seed)]))
    if larger.passed:
        assert region.verdict != "refuted"
    if region.verdict == "refuted":
        assert larger.verdict != "proved"


@settings(max_examples=40)
@given(worlds, st.integers(0, 2**32 - 1))
def test_certify_from_proves_only_starts_that_arrive(
    field: NavigationField, seed: int
) -> None:
    starts = _near_goal(field, seed)
    found = certify_from(field, starts)
    whole = certify(field)
    if whole.passed:
        assert replace(found, seconds=0.0) == replace(whole, seconds=0.0)
    assert found.passed == (whole.passed or certify(field, starts=starts).passed)
    if found.passed:
        assert_all_arrive(starts, field)


def test_certify_from_refutes_a_start_that_is_not_free() -> None:
    found = certify_from(make(4, [0, 0, 1, 1, 0]), [[-3.0, 0.5], [0.2, 0.0]])
    assert found.verdict == "refuted"
    assert found.witness == (0.2, 0.0)


def test_a_start_in_a_pocket_is_never_proved() -> None:
    angles = 2.0 * np.pi * np.arange(8) / 8
    rows = [[1.5 * np.cos(t) - 1.5, 1.5 * np.sin(t), 0.7, 0.7, 0.0] for t in angles]
    field = make(10, *rows)
    assert certify_from(field, [[-1.5, 0.1]]).verdict == "refuted"
    assert certify_from(field, [[2.0, 0.5]]).passed


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
    starts = _near_goal(field, seed)
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
        _assert_out_of_reach(found, real, starts)


def _joined(field: NavigationField, level: float, a, b, count: int) -> bool:
    """Whether two points are joined on a lattice of points where psi <= level."""
    w = field.workspace
    t = np.linspace(-1.0, 1.0, count)
    grid = w.centre + np.stack(np.meshgrid(t, t, indexing="ij"), -1) * w.semi_axes
    parts, _ = label(psi(grid, field, np.float64) <= level)

    def around(q) -> set[int]:
        i, j = (((q - w.centre) / w.semi_axes + 1.0) / 2.0 * (count - 1)).astype(int)
        return set(parts[i : i + 2, j : j + 2].ravel().tolist()) - {0}

    return bool(around(np.asarray(a)) & around(np.asarray(b)))


def _assert_out_of_reach(
    found: Certificate, field: NavigationField, starts: FloatArray
) -> int:
    """No minimum below the level is joined with a start; how many lie below it."""
    assert found.region is not None
    below = 0
    for root in find_minima(field):
        if float(psi([root.x, root.y], field)) > found.region:
            continue
        below += 1
        assert found.apart
        for q in starts:
            # A lattice may skip over a thin ridge: only a finer one convicts.
            assert not all(
                _joined(field, found.region, (root.x, root.y), q, count)
                for count in (257, 1025)
            )
    return below


def _attack_regions(seed: int, count: int) -> int:
    """Regions of single starts anywhere; how many were proved below a trap's level."""
    below = 0
    for i in range(count):
        rng = np.random.default_rng([seed, i])
        field = random_world(KINDS[i % 3], rng)
        if least_beta(field.goal, field) <= 1e-2 or certify(field).passed:
            continue
        for start in _free(field, 8, i)[:3]:
            found = certify(field, starts=start)
            if found.passed:
                assert_all_arrive(start[None], field)
                below += _assert_out_of_reach(found, field, start[None])
    return below


def test_traps_below_a_proved_region_s_level_are_out_of_its_reach() -> None:
    assert _attack_regions(seed=22, count=24) >= 1


@pytest.mark.exhaustive
def test_traps_below_many_proved_regions_levels_are_out_of_their_reach() -> None:
    assert _attack_regions(seed=23, count=900) >= 20


@pytest.mark.exhaustive
def test_regions_of_random_worlds_hold_what_they_promise() -> None:
    proved_in_refuted = 0
    for i in range(600):
        rng = np.random.default_rng([21, i])
        field = random_world(KINDS[i % 3], rng)
        if least_beta(field.goal, field) <= 1e-2:
            continue
        starts = _near_goal(field, i)
        found = certify(field, starts=starts)
        if found.passed:
            assert found.region is not None
            assert_all_arrive(starts, field)
            if not found.apart:
                assert_all_arrive(_below(field, found.region, i), field)
            _assert_out_of_reach(found, field, starts)
            proved_in_refuted += certify(field).verdict == "refuted"
    assert proved_in_refuted > 30
