"""Which field of a chain is followed, alone and where areas cover goals."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from made_up_skill import composed_skill, crossing_chain, stage

from bath_drake.composition.chain import Chain, Gate
from bath_drake.composition.rollout import chain_rollout
from bath_drake.control.staging import (
    MOVED_RADIUS,
    around_areas,
    covered,
    entry_point,
    left_out,
    next_stage,
)
from bath_drake.field.navigation import min_beta
from bath_drake.field.obstacles import ObstacleSet, beta
from bath_drake.field.rollout import RolloutStatus

CHAIN = crossing_chain()
START = composed_skill().start
NONE = ObstacleSet()
POINTS = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)).map(np.array)


def area(x, y, a=0.12, b=0.08, angle=0.3):
    return ObstacleSet(np.array([[x, y, a, b, angle]]))


AREAS = st.builds(
    area,
    st.floats(-0.8, 0.8),
    st.floats(-0.8, 0.8),
    st.floats(0.03, 0.25),
    st.floats(0.03, 0.25),
    st.floats(-3.0, 3.0),
)


@given(st.lists(POINTS, min_size=1, max_size=30))
def test_a_stage_is_never_left_backwards_nor_without_its_gate(points):
    reached = 0
    for point in points:
        following = next_stage(CHAIN, reached, point, left_out(CHAIN, NONE))
        assert reached <= following < len(CHAIN)
        assert all(gate.holds(point) for gate in CHAIN.gates[reached:following])
        assert following == len(CHAIN) - 1 or not CHAIN.gates[following].holds(point)
        reached = following


def test_nested_gates_are_passed_at_once():
    gates = tuple(Gate(np.zeros(2), np.array([1.0, 0.0]), r) for r in (0.2, 0.4))
    fields = [stage([0.1, y], []) for y in (0.0, 0.1, 0.2)]
    nested = Chain(tuple(fields), gates)
    assert next_stage(nested, 0, [0.05, 0.0], left_out(nested, NONE)) == 2
    assert next_stage(nested, 0, [0.3, 0.0], left_out(nested, NONE)) == 0


def test_the_stages_are_those_of_the_roll_out():
    found = chain_rollout(START, CHAIN)
    reached, stages = 0, []
    for point in found.path:
        reached = next_stage(CHAIN, reached, point, left_out(CHAIN, NONE))
        stages.append(reached)
    np.testing.assert_array_equal(stages, found.stages)


def test_areas_beside_the_goals_change_nothing():
    assert around_areas(CHAIN, NONE) is CHAIN
    assert around_areas(CHAIN, area(-0.4, 0.0)) == CHAIN


@given(AREAS)
def test_a_covered_goal_is_moved_to_a_free_place_in_its_gate(areas):
    moved = around_areas(CHAIN, areas)
    before, after = covered(CHAIN, areas), covered(moved, areas)
    # The areas are small: there always is a place.
    assert not after[:-1].any()
    assert moved.fields[-1] == CHAIN.fields[-1]
    for k, gate in enumerate(moved.gates):
        if not before[k]:
            assert gate == CHAIN.gates[k]
            assert moved.fields[k] == CHAIN.fields[k]
            continue
        goal = moved.fields[k].goal
        assert gate.holds(goal)
        assert gate.radius == MOVED_RADIUS
        assert np.abs(goal).max() <= 0.9
        # Wherever the motion enters the gate, it is free of the next field's own.
        assert min_beta(gate.outline(), moved.fields[k + 1]).min() > 0.0
        assert (beta(goal, areas) > 0.0).all()


def test_the_motion_goes_round_a_covered_goal_and_on():
    areas = area(*CHAIN.fields[0].goal, 0.2, 0.15)
    moved = around_areas(CHAIN, areas)
    worlds = tuple(field.with_obstacles(areas) for field in moved.fields)
    found = chain_rollout(START, Chain(worlds, moved.gates))
    assert found.status is RolloutStatus.ARRIVED
    assert set(found.stages) == {0, 1, 2}
    assert (beta(found.path, areas) > 0.0).all()
    # Still far to the right, as shown, before it turns.
    assert found.path[:, 0].max() > 0.4


def test_a_goal_without_a_free_place_near_leaves_its_stage_out():
    # All the body's right half: the first goal is deep in it, the second at its edge.
    areas = area(1.2, 0.0, 1.1, 2.0, 0.0)
    moved = around_areas(CHAIN, areas)
    assert covered(moved, areas).tolist() == [True, False, False]
    assert next_stage(moved, 0, START, left_out(moved, areas)) == 1


def test_a_covered_last_goal_stays_the_goal():
    areas = area(*CHAIN.goal)
    assert around_areas(CHAIN, areas) == CHAIN
    assert next_stage(CHAIN, 2, START, left_out(CHAIN, areas)) == 2


def test_without_areas_no_stage_is_left_out():
    assert not left_out(CHAIN, NONE).any()


def test_what_remains_are_the_later_fields_and_their_gates():
    assert CHAIN.rest(0) is CHAIN
    assert CHAIN.rest(1) is CHAIN.rest(1)
    assert CHAIN.rest(1).fields == CHAIN.fields[1:]
    assert CHAIN.rest(1).gates == CHAIN.gates[1:]
    assert len(CHAIN.rest(2)) == 1


def test_the_entry_is_where_the_roll_out_passes_the_gate():
    entry = entry_point(START, CHAIN)
    assert CHAIN.gates[0].holds(entry)
    # The straight side is passed within a step of 0.01.
    away = (entry - CHAIN.gates[0].centre) @ CHAIN.gates[0].direction
    assert 0.0 <= away <= 0.01


def test_where_the_motion_does_not_come_to_the_gate_its_goal_is_the_entry():
    wall = ObstacleSet(np.array([[0.3, 0.0, 0.05, 1.9, 0.0]]))
    walled = Chain(
        (CHAIN.fields[0].with_obstacles(wall), *CHAIN.fields[1:]), CHAIN.gates
    )
    np.testing.assert_array_equal(entry_point(START, walled), CHAIN.fields[0].goal)
