"""Gates and chains: what they hold, how they move, what they refuse."""

import hypothesis.strategies as st
import numpy as np
import pytest
from chains import gate_at, make, random_chain
from hypothesis import given, settings

from bath_drake.composition.chain import Chain, Gate
from bath_drake.composition.similarity import Similarity, identity

GATE = Gate(np.array([1.0, 0.0]), np.array([0.0, 2.0]), 0.5)


@pytest.mark.parametrize(
    ("q", "held"),
    [
        ((1.0, 0.0), True),
        ((1.0, 0.5), True),
        ((0.5, 0.0), True),
        ((1.0, -1e-9), False),
        ((1.0, 0.5 + 1e-9), False),
        ((1.4, 0.4), False),
    ],
)
def test_a_gate_is_a_closed_half_disc(q, held):
    assert bool(GATE.holds(q)) is held


def test_a_gate_s_direction_is_made_a_unit_vector_once():
    np.testing.assert_array_equal(GATE.direction, [0.0, 1.0])
    slanted = Gate(np.zeros(2), np.array([0.3, -0.7]), 1.0)
    again = Gate(slanted.centre, slanted.direction, 1.0)
    assert again == slanted
    assert hash(again) == hash(slanted)
    assert slanted != GATE
    assert slanted != "gate"


def test_a_gate_s_outline_is_closed_and_its_own():
    outline = GATE.outline()
    np.testing.assert_array_equal(outline[0], outline[-1])
    # Rounding alone takes points of the outline out.
    shrunk = GATE.centre + [0.0, 1e-9] + (1.0 - 1e-8) * (outline - GATE.centre)
    assert GATE.holds(shrunk).all()


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.floats(-3.0, 3.0), st.floats(0.3, 3.0))
def test_a_moved_gate_holds_the_moved_points(seed, turn, scale):
    rng = np.random.default_rng(seed)
    by = Similarity(rng.normal(size=2), scale * np.exp(1j * turn), rng.normal(size=2))
    gate = gate_at(rng.normal(size=2), rng.uniform(-3, 3), 0.4)
    q = gate.centre + 0.5 * rng.normal(size=(100, 2))
    away = q - gate.centre
    # Points on an edge to rounding may fall on either side.
    clear = np.abs(away @ gate.direction) > 1e-9
    clear &= np.abs(np.linalg.norm(away, axis=1) - gate.radius) > 1e-9
    np.testing.assert_array_equal(
        gate.moved(by).holds(by.points(q))[clear], gate.holds(q)[clear]
    )


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (([0.0], [1.0, 0.0], 1.0), "centre must be two finite numbers"),
        (([0.0, 0.0], [np.inf, 0.0], 1.0), "direction must be two finite numbers"),
        (([0.0, 0.0], [0.0, 0.0], 1.0), "direction must not be zero"),
        (([0.0, 0.0], [1.0, 0.0], 0.0), "radius must be positive and finite, got 0"),
        (([0.0, 0.0], [1.0, 0.0], np.nan), "radius must be positive and finite"),
    ],
)
def test_what_is_no_gate_is_refused(values, message):
    with pytest.raises(ValueError, match=message):
        Gate(*values)


def test_a_chain_knows_its_goal_and_counts_its_obstacles(rng):
    chain = random_chain(rng)
    assert len(chain) == 3
    np.testing.assert_array_equal(chain.goal, chain.fields[2].goal)
    assert chain.obstacle_count == sum(len(f.obstacles) for f in chain.fields)
    assert chain == Chain(list(chain.fields), list(chain.gates))
    assert hash(chain) == hash(Chain(chain.fields, chain.gates))
    assert chain != random_chain(rng)
    assert chain != chain.fields[0]


def test_gates_that_overlap_are_passed_at_once():
    fields = tuple(make((x, 0.0)) for x in (0.0, 0.05, 1.0))
    chain = Chain(fields, (gate_at(fields[0].goal, 0.0), gate_at(fields[1].goal, 0.0)))
    assert chain.stage_at([-1.0, 0.0], 0) == 0
    assert chain.stage_at([0.03, 0.0], 0) == 2
    assert chain.stage_at([-0.02, 0.0], 0) == 1
    # Never back: the second stage stays where its gate is not.
    assert chain.stage_at([-1.0, 0.0], 1) == 1
    assert chain.stage_at([0.03, 0.0], 2) == 2


def test_each_stage_moves_with_its_own_similarity(rng):
    chain = random_chain(rng)
    by = Similarity(np.zeros(2), 0.5j, np.array([0.1, 0.2]))
    moved = chain.moved((identity(), by, identity()))
    assert moved.fields[0] is chain.fields[0]
    assert moved.gates[0] is chain.gates[0]
    np.testing.assert_array_equal(moved.fields[1].goal, by.points(chain.fields[1].goal))
    assert moved.gates[1] == chain.gates[1].moved(by)
    with pytest.raises(ValueError, match="3 similarities needed, got 2"):
        chain.moved((by, by))


def test_what_is_no_chain_is_refused():
    field = make((0.0, 0.0))
    with pytest.raises(ValueError, match="0 fields need 0 gates, got 0"):
        Chain(())
    with pytest.raises(ValueError, match="2 fields need 1 gates, got 0"):
        Chain((field, field))
    with pytest.raises(ValueError, match="goal of field 0 is not within its gate"):
        Chain((field, field), (GATE,))
