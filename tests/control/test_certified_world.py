"""How long, and of what, a certificate of the world that is driven in holds."""

import numpy as np
import pytest

from bath_drake.certificate.certify import certify_from
from bath_drake.certificate.result import Certificate
from bath_drake.control.certified_world import (
    CertifiedWorld,
    WorldVerdict,
    certified_of,
    certify_world,
    keep_certified,
    nothing_certified,
)
from bath_drake.field.navigation import NavigationField, ln_phi, psi
from bath_drake.field.obstacles import ObstacleSet, Workspace

START = np.array([-0.7, 0.3])
FIELD = NavigationField(
    workspace=Workspace(np.zeros(2), np.full(2, 2.0)),
    goal=np.array([0.7, 0.0]),
    kappa=6.0,
    obstacles=ObstacleSet(
        np.array([[0.1, -0.3, 0.2, 0.1, 1.2]]), exponents=np.array([0.5])
    ),
)


def of_region(level, verdict="proved"):
    return CertifiedWorld(FIELD, START, Certificate(verdict, "made up", region=level))


def test_the_world_is_certified_by_the_proof_of_its_start():
    world = certify_world(FIELD, START)
    found = certify_from(FIELD, START)
    assert world.certificate.verdict == found.verdict == "proved"
    assert world.verdict is WorldVerdict.PROVED
    assert world.proves(FIELD, START)


def test_a_proof_of_all_free_space_holds_anywhere_in_it_and_nowhere_else():
    world = certify_world(FIELD, START)
    assert world.certificate.region is None
    assert world.proves(FIELD, np.array([0.3, 1.2]))
    assert not world.proves(FIELD, np.array([0.1, -0.3]))  # in the obstacle
    assert not world.proves(FIELD, np.array([3.0, 0.0]))  # outside the workspace


def test_a_proof_is_of_no_other_world():
    world = certify_world(FIELD, START)
    for other in (
        FIELD.with_goal(np.array([0.7, 1e-12])),
        FIELD.with_obstacles(ObstacleSet(np.array([[-1.0, -1.0, 0.1, 0.1, 0.0]]))),
    ):
        assert not world.proves(other, START)
        assert world.is_stale(other, START)


def test_a_proof_of_a_region_holds_while_the_motion_is_in_it():
    level = psi(START, FIELD)
    world = of_region(level)
    assert world.proves(FIELD, START)
    assert world.proves(FIELD, np.array([0.5, 0.1]))  # further down
    assert not world.is_stale(FIELD, np.array([0.5, 0.1]))
    outside = START + np.array([-0.1, 0.0])
    assert psi(outside, FIELD) > level
    assert not world.proves(FIELD, outside)
    assert world.is_stale(FIELD, outside)


def test_in_another_part_of_a_region_that_traps_a_proof_says_nothing():
    # A wall broadside to the goal: two basins, each with low ground of its own.
    wall = ObstacleSet(np.array([[-0.2, 0.0, 0.05, 0.7, 0.0]]))
    field = NavigationField(FIELD.workspace, FIELD.goal, 12.0, wall)
    before, beyond = np.array([-0.45, 0.05]), np.array([0.1, 0.5])
    level = max(psi(before, field), psi(beyond, field))
    one = Certificate("proved", "made up", region=level)
    apart = Certificate("proved", "made up", region=level, apart=True)
    # As if no other part trapped, and as it is.
    assert CertifiedWorld(field, beyond, one).proves(field, before)
    world = CertifiedWorld(field, beyond, apart)
    assert world.proves(field, beyond)
    assert not world.proves(field, before)
    assert world.is_stale(field, before)


@pytest.mark.parametrize("verdict", ["refuted", "undecided"])
def test_what_is_not_proved_proves_nothing_and_is_tried_again_elsewhere(verdict):
    world = of_region(np.inf, verdict)
    assert world.verdict is WorldVerdict[verdict.upper()]
    assert not world.proves(FIELD, START)
    assert not world.is_stale(FIELD, START)
    assert world.is_stale(FIELD, START + 0.01)


def test_before_the_first_proof_nothing_is_proved_not_even_of_the_stand_in():
    world = nothing_certified()
    assert world.verdict is WorldVerdict.UNKNOWN
    assert not world.proves(world.field, world.start)
    assert world.is_stale(world.field, world.start)


def test_the_potential_is_that_of_the_field():
    for q in ([-0.7, 0.3], [0.2, 0.9], [-1.5, -1.0]):
        value = psi(q, FIELD)
        # ln phi = -ln(1 + exp(-psi)) / kappa, to rounding.
        phi = -np.log1p(np.exp(-value)) / FIELD.kappa
        np.testing.assert_allclose(phi, ln_phi(np.array(q), FIELD), rtol=1e-12)
    assert psi(FIELD.goal, FIELD) == -np.inf
    assert psi(np.array([0.1, -0.3]), FIELD) == np.inf
    assert psi(np.array([2.0, 0.0]), FIELD) == np.inf


AHEAD = FIELD.with_goal(np.array([0.5, 0.4]))
ENTRY = np.array([0.6, 0.0])


def test_the_driven_world_is_proved_first_and_one_at_a_time():
    ahead = [(AHEAD, ENTRY)]
    first = keep_certified((nothing_certified(),), FIELD, START, ahead)
    assert [w.field for w in first] == [FIELD]
    second = keep_certified(first, FIELD, START, ahead)
    assert second[0] is first[0]
    assert [w.field for w in second] == [FIELD, AHEAD]
    np.testing.assert_array_equal(second[1].start, ENTRY)
    assert keep_certified(second, FIELD, START, ahead) is second


def test_a_world_that_was_proved_ahead_is_in_force_at_once():
    worlds = keep_certified((nothing_certified(),), FIELD, START, [(AHEAD, ENTRY)])
    worlds = keep_certified(worlds, FIELD, START, [(AHEAD, ENTRY)])
    entered = certified_of(worlds, AHEAD)
    assert entered.proves(AHEAD, ENTRY + 0.01)
    assert keep_certified(worlds, AHEAD, ENTRY + 0.01, [(AHEAD, ENTRY)]) is worlds
    assert certified_of(worlds, FIELD.with_goal(ENTRY)) is None


def test_worlds_that_are_no_longer_ahead_are_forgotten():
    worlds = keep_certified((nothing_certified(),), FIELD, START, [(AHEAD, ENTRY)])
    worlds = keep_certified(worlds, FIELD, START, [(AHEAD, ENTRY)])
    other = FIELD.with_goal(ENTRY)
    renewed = keep_certified(worlds, other, START, [])
    assert [w.field for w in renewed] == [other]
