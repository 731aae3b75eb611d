"""Gates are drawn in only where they must, and lie within what they were."""

import hypothesis.strategies as st
import numpy as np
from chains import make, random_chain
from hypothesis import given, settings

from bath_drake.composition.branch import Branch
from bath_drake.composition.certify import certify_chain
from bath_drake.composition.chain import Chain, Gate
from bath_drake.composition.clearing import CLEARANCE, cleared
from bath_drake.composition.conditioning import Conditioning
from bath_drake.field.navigation import min_beta

FORWARD = np.array([1.0, 0.0])
GATE = Gate(np.array([-0.05, 0.0]), FORWARD, 0.2)


def with_disc(x: float) -> Chain:
    """A disc of radius 0.3 of the next field, the gate reaching to x = 0.15."""
    return Chain((make((0.0, 0.0)), make((1.5, 0.3), [x, 0.0, 0.3, 0.3, 0.0])), (GATE,))


def test_gates_that_are_free_stay(rng):
    chain = random_chain(rng)
    assert cleared(chain) is chain
    assert cleared(with_disc(0.46)).gates == (GATE,)


@settings(max_examples=30)
@given(st.floats(0.32, 0.449))
def test_a_gate_in_an_obstacle_is_drawn_in_until_the_chain_is_proved(x):
    chain = with_disc(x)
    assert certify_chain(chain).verdict == "refuted"
    clear = cleared(chain)
    assert clear.fields == chain.fields
    found = certify_chain(clear)
    assert found.passed, found.reason
    assert found.handovers[0].clearance >= 0.9 * CLEARANCE
    (gate,) = clear.gates
    np.testing.assert_array_equal(gate.direction, FORWARD)
    # The corners and the tip lie in the old gate, to rounding, and so does all of it.
    middle = gate.outline().mean(axis=0)
    inner = middle + (1.0 - 1e-12) * (gate.outline() - middle)
    assert GATE.holds(inner).all()
    assert gate.holds(chain.fields[0].goal)


def test_a_goal_in_the_obstacle_cannot_be_helped():
    chain = with_disc(0.2)
    assert min_beta([0.0, 0.0], chain.fields[1]) < 0.0
    assert cleared(chain) is chain
    assert certify_chain(chain).verdict == "refuted"


def test_a_branch_clears_the_gates_of_its_moved_chains():
    chain = with_disc(0.47)
    coefficients = np.zeros((2, 4, 5))
    coefficients[1, 2, 2] = 1.0  # the last stage shifts in x with the goal
    start = np.array([-1.0, 0.0])
    branch = Branch(
        chain,
        start,
        start[None],
        np.stack([start, chain.goal]),
        Conditioning(
            start, chain.goal, start[None], 0.2, 0.5, np.zeros((2, 2)), coefficients
        ),
    )
    assert branch.chain_for(start).gates[0] == GATE
    moved = branch.chain_for(start, chain.goal - [0.1, 0.0])
    assert moved.gates[0].radius < GATE.radius
    assert certify_chain(moved).passed
