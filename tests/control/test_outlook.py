"""Worlds made ahead of the gate."""

import numpy as np
import pytest
from made_up_skill import composed_skill, crossing_chain

from bath_drake.composition.chain import Chain
from bath_drake.control.areas import inflated
from bath_drake.control.outlook import look_ahead
from bath_drake.control.staging import (
    around_areas,
    entry_point,
    left_out,
    next_stage,
)
from bath_drake.control.world import join_areas
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.rollout import RolloutStatus, rollout

CHAIN = crossing_chain()
START = composed_skill().start
AREAS = ObstacleSet(np.array([[-0.3, 0.4, 0.1, 0.1, 0.0]]))
SLACK = 0.02


def look(outlook, areas=AREAS, chain=CHAIN, point=START):
    return look_ahead(outlook, areas, chain, point, slack=SLACK)


def test_the_followed_world_is_made_first_then_the_next_then_nothing():
    first = look(None)
    assert [w.learned for w in first.worlds] == [CHAIN.fields[0]]
    second = look(first)
    assert [w.learned for w in second.worlds] == list(CHAIN.fields[:2])
    assert look(second) is second


def test_a_world_is_that_of_the_pure_function():
    outlook = look(look(None))
    for world in outlook.worlds:
        expected = join_areas(world.learned, inflated(AREAS, SLACK), world.start)
        assert world.field == expected.field
        assert world.certificate.passed
    # The next one is to be entered at its gate.
    assert CHAIN.gates[0].holds(outlook.worlds[1].start)


def test_past_the_gate_the_world_is_there_and_the_one_after_is_made():
    outlook = look(look(None))
    ahead = outlook.worlds[1]
    chain = CHAIN.rest(1)
    assert outlook.world_of(chain.fields[0]) is ahead
    passed = look(outlook, chain=chain, point=ahead.start)
    assert passed.worlds[0] is ahead
    assert [w.learned for w in passed.worlds] == list(CHAIN.fields[1:])
    last = look(passed, chain=CHAIN.rest(2), point=passed.worlds[1].start)
    assert last is passed


def test_a_new_area_makes_all_worlds_anew_and_a_flicker_none():
    outlook = look(look(None))
    assert look(outlook, inflated(AREAS, 0.5 * SLACK)) is outlook
    grown = look(outlook, inflated(AREAS, 2.0 * SLACK))
    assert len(grown.worlds) == 1
    assert grown.worlds[0].learned == CHAIN.fields[0]


@pytest.mark.parametrize("size", [0.08, 0.15, 0.25])
@pytest.mark.parametrize("k", [0, 1])
def test_round_a_covered_goal_every_world_is_proved_and_the_last_goal_reached(k, size):
    areas = ObstacleSet(np.array([[*CHAIN.fields[k].goal, size, 0.7 * size, 0.3]]))
    moved = around_areas(CHAIN, inflated(areas, SLACK))
    outlook, point = None, START
    for stage in range(len(moved)):
        out = left_out(moved, inflated(areas, SLACK))
        assert next_stage(moved, stage, point, out) == stage
        chain = moved.rest(stage)
        # As frame after frame does it: this world, then the next.
        for _ in range(2):
            outlook = look(outlook, areas, chain, point)
        world = outlook.world_of(chain.fields[0])
        assert world.certificate.passed
        if len(chain) > 1:
            driven = Chain((world.field, chain.fields[1]), chain.gates[:1])
            point = entry_point(point, driven)
            assert chain.gates[0].holds(point)
    end = rollout(point, world.field)
    assert end.status is RolloutStatus.ARRIVED
    np.testing.assert_array_equal(world.field.goal, CHAIN.goal)


def test_another_body_makes_the_worlds_anew():
    rim = Workspace(np.zeros(2), np.array([0.95, 1.0]), 6)
    before = look_ahead(None, AREAS, CHAIN, START, slack=SLACK)
    after = look_ahead(before, AREAS, CHAIN, START, slack=SLACK, rim=rim)
    assert after.rim == rim
    assert after.areas == before.areas
    assert look_ahead(after, AREAS, CHAIN, START, slack=SLACK, rim=rim).rim == rim
