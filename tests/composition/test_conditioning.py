"""How stages follow start and goal: not at all at the mean's, and never too far."""

import hypothesis.strategies as st
import numpy as np
import pytest
from chains import gate_at, make
from hypothesis import given

from bath_drake.composition.branch import Branch
from bath_drake.composition.chain import Chain
from bath_drake.composition.conditioning import MOST_STRETCH, Conditioning, bells

START, GOAL = np.array([-0.8, 0.2]), np.array([0.9, -0.1])
STARTS = START + np.array([[0.0, 0.1], [0.1, -0.1], [-0.1, 0.0]])
POINT = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
WIDTH, REACH = 0.2, 0.3


def conditioning(coefficients=None, stages=2, **changes):
    if coefficients is None:
        rng = np.random.default_rng(7)
        coefficients = 0.3 * rng.normal(size=(stages, 4, 4 + len(STARTS)))
    values = {
        "start": START,
        "goal": GOAL,
        "starts": STARTS,
        "width": WIDTH,
        "reach": REACH,
        "pivots": np.zeros((stages, 2)),
        "coefficients": coefficients,
    }
    return Conditioning(**(values | changes))


def goal_follows():
    """The last stage pivots on its goal and shifts as it does; the first stays."""
    coefficients = np.zeros((2, 4, 4 + len(STARTS)))
    coefficients[1, 2, 2] = coefficients[1, 3, 3] = 1.0
    coefficients[1, 0, 0] = 0.4  # it may be stretched too
    return conditioning(coefficients, pivots=np.stack([START, GOAL]))


def test_nothing_moves_at_the_mean_s_ends():
    features = conditioning().features(START, GOAL)
    assert features.shape == (4 + len(STARTS),)
    assert not features.any()
    assert all(by.is_identity for by in conditioning().similarities(START))
    assert all(by.is_identity for by in conditioning().similarities(START, GOAL))


def test_bells_are_one_at_their_centres_and_fall_off():
    near = bells(STARTS[1], STARTS, WIDTH)
    assert near[1] == 1.0
    assert (near[[0, 2]] < 1.0).all()
    at = np.exp(-0.5)
    assert bells(np.array([WIDTH, 0.0]), np.zeros((1, 2)), WIDTH) == pytest.approx(at)


@given(POINT)
def test_a_start_counts_no_farther_out_than_the_reach(offset):
    far = np.array(offset)
    length = float(np.hypot(*far))
    features = conditioning().features(START + far, GOAL)
    assert np.hypot(*features[:2]) <= REACH * (1.0 + 1e-12)
    if length > REACH:
        rim = START + far * (REACH / length)
        np.testing.assert_allclose(
            features, conditioning().features(rim, GOAL), atol=1e-12
        )
    else:
        np.testing.assert_allclose(features[:2], far, atol=1e-15)


@given(POINT, POINT)
def test_no_stage_is_stretched_beyond_the_most(start, goal):
    for by in conditioning(8.0 * np.ones((2, 4, 7))).similarities(start, goal):
        # A rounding or two of a number below two.
        assert abs(by.stretch - 1.0) <= MOST_STRETCH * (1.0 + 1e-12)
        assert by.scale >= 1.0 - MOST_STRETCH - 1e-12


@given(POINT, POINT)
def test_a_last_stage_that_follows_its_goal_moves_it_there(start, goal):
    fields = (make((0.0, 0.1)), make(tuple(GOAL)))
    chain = Chain(fields, (gate_at(fields[0].goal, 0.0),))
    branch = Branch(chain, START, STARTS, np.stack([START, GOAL]), goal_follows())
    moved = branch.chain_for(start, goal)
    # An offset is subtracted and added again.
    np.testing.assert_allclose(moved.goal, goal, atol=1e-15)
    assert moved.fields[0] is chain.fields[0]
    np.testing.assert_array_equal(branch.chain_for(start).goal, GOAL)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"start": np.zeros(3)}, r"start has shape \(3,\), not \(2,\)"),
        ({"goal": np.full(2, np.nan)}, "goal must be finite"),
        ({"starts": np.zeros((2, 2))}, r"coefficients has shape \(2, 4, 7\), not"),
        ({"pivots": np.zeros((3, 2))}, "coefficients has shape"),
        ({"width": 0.0}, "width must be positive and finite, got 0"),
        ({"reach": np.inf}, "reach must be positive and finite, got inf"),
    ],
)
def test_what_is_no_conditioning_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        conditioning(**changes)


@pytest.mark.parametrize("start", [[0.0], [np.nan, 0.0]])
def test_ends_that_are_no_points_are_refused(start):
    with pytest.raises(ValueError, match=r"inhomogeneous|two finite numbers"):
        conditioning().similarities(start)
