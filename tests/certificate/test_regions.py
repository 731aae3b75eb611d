"""Sublevel sets and uncertain obstacles."""

from dataclasses import replace

import hypothesis.strategies as st
import numpy as np
import pytest
from basins import least_beta, polish, psi
from checks import assert_all_arrive, holds
from hypothesis import given, settings
from random_worlds import KINDS, random_world
from reach import (
    BEHIND,
    BEYOND,
    BROADSIDE,
    assert_out_of_reach,
    below,
    free_starts,
    near_goal,
)
from strategies import worlds
from worlds import make

from bath_drake.certificate.certify import certify, certify_from
from bath_drake.field.navigation import NavigationField


def test_a_refuted_world_can_have_a_proved_region() -> None:
    assert certify(BROADSIDE).verdict == "refuted"
    region = certify(BROADSIDE, starts=BEYOND)
    assert region.passed, region.reason
    assert region.region is not None
    assert region.traps == ()
    assert_all_arrive(below(BROADSIDE, region.region, 1), BROADSIDE)
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
    starts = near_goal(field, seed)
    found = certify(field, starts=starts)
    assert found.region is not None
    highest = float(psi(starts, field).max())
    # The level is rounded up, by about 1e-15 a term; and no more.
    assert highest - 1e-12 <= found.region <= highest + 1e-9 * (1 + abs(highest))
    assert found.region >= psi(starts, field).max()
    if found.passed:
        assert_all_arrive(starts, field)
        if not found.apart:
            assert_all_arrive(below(field, found.region, seed), field)
    for trap in found.traps:
        root = polish(trap.x, trap.y, field)
        assert root is not None
        assert holds(trap.box, root)
        assert float(psi([root.x, root.y], field)) <= found.region


@settings(max_examples=40)
@given(worlds, st.integers(0, 2**32 - 1))
def test_the_whole_and_its_regions_agree(field: NavigationField, seed: int) -> None:
    starts = near_goal(field, seed)
    whole, region = certify(field), certify(field, starts=starts)
    if whole.passed:
        assert region.verdict != "refuted"
    if region.verdict == "refuted":
        assert whole.verdict != "proved"
    larger = certify(
        field, starts=np.concatenate([starts, free_starts(field, 3, seed)])
    )
    if larger.passed:
        assert region.verdict != "refuted"
    if region.verdict == "refuted":
        assert larger.verdict != "proved"


@settings(max_examples=40)
@given(worlds, st.integers(0, 2**32 - 1))
def test_certify_from_proves_only_starts_that_arrive(
    field: NavigationField, seed: int
) -> None:
    starts = near_goal(field, seed)
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


def _attack_regions(seed: int, count: int) -> int:
    """Regions of single starts anywhere; how many were proved below a trap's level."""
    below = 0
    for i in range(count):
        rng = np.random.default_rng([seed, i])
        field = random_world(KINDS[i % 3], rng)
        if least_beta(field.goal, field) <= 1e-2 or certify(field).passed:
            continue
        for start in free_starts(field, 8, i)[:3]:
            found = certify(field, starts=start)
            if found.passed:
                assert_all_arrive(start[None], field)
                below += assert_out_of_reach(found, field, start[None])
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
        starts = near_goal(field, i)
        found = certify(field, starts=starts)
        if found.passed:
            assert found.region is not None
            assert_all_arrive(starts, field)
            if not found.apart:
                assert_all_arrive(below(field, found.region, i), field)
            assert_out_of_reach(found, field, starts)
            proved_in_refuted += certify(field).verdict == "refuted"
    assert proved_in_refuted > 30
