"""Branches: a chain for any start and goal, and the branch whose starts are nearest."""

import numpy as np
import pytest
from chains import gate_at, make

from bath_drake.composition.branch import Branch, nearest_branch
from bath_drake.composition.chain import Chain
from bath_drake.composition.conditioning import Conditioning

START, GOAL = np.array([-0.8, 0.2]), np.array([1.0, 0.0])
STARTS = START + np.array([[0.0, 0.1], [0.0, -0.1]])
FIELDS = (make((0.0, 0.0)), make((1.0, 0.0), [0.5, 0.6, 0.2, 0.2, 0.0]))
CHAIN = Chain(FIELDS, (gate_at(FIELDS[0].goal, 0.0),))


def branch(**changes):
    mean = np.stack([START, GOAL])
    values = {"chain": CHAIN, "start": START, "starts": STARTS, "mean": mean}
    return Branch(**(values | changes))


def test_without_conditioning_only_the_last_goal_moves():
    assert branch().chain_for([0.0, 1.0]) is CHAIN
    moved = branch().chain_for(START, [1.0, 0.3])
    np.testing.assert_array_equal(moved.goal, [1.0, 0.3])
    assert moved.fields[0] is FIELDS[0]
    assert moved.gates == CHAIN.gates
    assert moved.fields[1].obstacles is FIELDS[1].obstacles


def test_with_conditioning_the_stages_move_and_the_mean_s_chain_is_the_one_learned():
    coefficients = np.zeros((2, 4, 6))
    coefficients[0, 2, 0] = 1.0  # the first stage shifts in x with the start
    moving = Conditioning(START, GOAL, STARTS, 0.2, 0.5, np.zeros((2, 2)), coefficients)
    chain = branch(conditioning=moving).chain_for(np.add(START, [0.1, 0.0]))
    np.testing.assert_allclose(chain.fields[0].goal, [0.1, 0.0], atol=1e-15)
    assert chain.fields[1] is FIELDS[1]
    same = branch(conditioning=moving).chain_for(START)
    assert all(a is b for a, b in zip(same.fields, FIELDS, strict=True))


def test_the_branch_with_the_nearest_demonstration_is_taken():
    left = branch(starts=np.array([[-1.0, 0.0], [-0.2, 0.0]]))
    right = branch(starts=np.array([[0.1, 0.0], [3.0, 0.0]]))
    assert nearest_branch((left, right), [-0.1, 0.0]) is left
    assert nearest_branch((left, right), [0.0, 0.0]) is right
    assert nearest_branch((left,), [9.0, 9.0]) is left


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"start": np.zeros(3)}, "start must be two numbers"),
        ({"start": np.full(2, np.inf)}, "start must be finite"),
        ({"starts": np.zeros((0, 2))}, r"starts has shape \(0, 2\), not \(n >= 1, 2\)"),
        ({"mean": np.zeros((1, 2))}, r"mean has shape \(1, 2\), not \(n >= 2, 2\)"),
        (
            {
                "conditioning": Conditioning(
                    START, GOAL, STARTS, 0.2, 0.5, np.zeros((1, 2)), np.zeros((1, 4, 6))
                )
            },
            "conditioning is for 1 stages, the chain has 2",
        ),
    ],
)
def test_what_is_no_branch_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        branch(**changes)
