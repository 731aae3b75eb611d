from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_skill import composed_skill, crossing_chain, stage

from bath_drake.composition.branch import Branch
from bath_drake.composition.chain import Chain
from bath_drake.learning.generalisation import (
    RINGS,
    corridor_distances,
    evaluate_generalisation,
    smoothness,
    turning,
)

START, GOAL = np.array([-0.6, 0.1]), np.array([0.5, -0.2])
STARTS = START + np.array([[0.0, 0.1], [0.0, -0.1], [0.06, 0.0]])


@pytest.fixture(scope="module")
def open_branch():
    """One field without obstacles: proved, and as proved with any other goal."""
    return Branch(Chain((stage(GOAL, []),)), START, STARTS, np.array([START, GOAL]))


@pytest.fixture(scope="module")
def astray():
    """A composed skill that moves its stages with its ends, the goal too: somehow."""
    return composed_skill(conditioned=True).branches


@pytest.fixture(scope="module")
def crossing(astray):
    """The same, but its goal moves as it is told to."""
    (branch,) = astray
    pivots, numbers = (
        getattr(branch.conditioning, name).copy() for name in ("pivots", "coefficients")
    )
    pivots[-1] = branch.chain.goal
    numbers[-1] = 0.0
    numbers[-1, 2:, 2:4] = np.eye(2)
    how = replace(branch.conditioning, pivots=pivots, coefficients=numbers)
    return (replace(branch, conditioning=how),)


def circle(count=400, radius=0.3):
    t = np.linspace(0.0, 2.0 * np.pi, count)
    return radius * np.stack([np.cos(t), np.sin(t)], axis=-1)


def test_a_proved_chain_arrives_from_everywhere(open_branch):
    found = evaluate_generalisation((open_branch,), count=8)
    assert tuple(ring.name for ring in found.rings) == RINGS
    for ring in found.rings:
        assert ring.free.all()
        assert ring.proved.all()
        assert ring.arrived.all()


def test_what_is_proved_arrives_whatever_the_ends(crossing):
    for ring in evaluate_generalisation(crossing, count=6).rings:
        assert (ring.arrived | ~ring.proved).all()
        assert (ring.free | ~ring.arrived).all()
        for at in np.flatnonzero(~ring.free):
            assert ring.verdicts[at] is None
            assert len(ring.paths[at]) == 1


def test_to_arrive_elsewhere_is_not_to_arrive(astray):
    for ring in evaluate_generalisation(astray, count=4).rings:
        assert ring.proved.any()
        assert not ring.arrived.any()
        assert np.isnan(ring.median(ring.distances))


def test_the_same_seed_makes_the_same_trials(crossing):
    first, again, other = (
        evaluate_generalisation(crossing, count=3, seed=seed) for seed in (4, 4, 5)
    )
    for a, b, c in zip(first.rings, again.rings, other.rings, strict=True):
        assert np.array_equal(a.starts, b.starts)
        assert np.array_equal(a.distances, b.distances, equal_nan=True)
        assert a.verdicts == b.verdicts
        assert not np.array_equal(a.starts, c.starts)


def test_each_ring_holds_its_ends(open_branch):
    found = evaluate_generalisation((open_branch,), count=20, spread=2.0)
    near, far, anywhere = found.rings
    (radius,) = found.radius
    # The farthest start from the mean start, which here is not their average.
    assert radius == pytest.approx(0.1)
    for ring, low, high in ((near, 0.0, radius), (far, radius, 2.0 * radius)):
        for ends, centre in ((ring.starts, START), (ring.goals, GOAL)):
            away = np.hypot(*(ends - centre).T)
            assert (away >= low - 1e-12).all()  # rounding of a sum
            assert (away <= high + 1e-12).all()
    assert (np.abs(anywhere.starts) <= 1.0).all()


def test_a_path_strays_no_less_than_its_ends_force_it_to(open_branch):
    for ring in evaluate_generalisation((open_branch,), count=8).rings:
        assert (ring.strays >= 0.0).all()
        # The flow without obstacles is all but straight, and so is the demonstration:
        # no point of a line is farther from another than one of its ends.
        assert ring.median(ring.strays) <= 0.02


def test_the_demonstrations_themselves_lie_in_their_corridor():
    paths = [circle(), circle(radius=0.4) + 0.1]
    for path in paths:
        # Rounding: a root of a difference of squares of order one.
        assert corridor_distances(path, paths) == pytest.approx(0.0, abs=1e-8)
        middles = 0.5 * (path[1:] + path[:-1])
        assert corridor_distances(middles, paths) == pytest.approx(0.0, abs=1e-8)


@given(x=st.floats(-1.0, 1.0), y=st.floats(0.0, 2.0))
@settings(max_examples=20, deadline=None)
def test_distances_are_to_the_lines_between_the_points(x, y):
    line = np.array([[-1.0, 0.0], [0.3, 0.0], [1.0, 0.0]])
    assert corridor_distances(np.array([[x, y]]), [line]) == pytest.approx(y, abs=1e-12)


def test_a_circle_turns_once_and_has_the_jerk_of_a_circle():
    # Chords of 6 % of the circle lose about as much of its turning at the ends.
    assert turning(circle()) == pytest.approx(2.0 * np.pi, rel=0.07)
    # (2 pi)^4 for third derivatives 1 / R^2 and a length of 2 pi R; differences over
    # an eighth of a radian are that exact.
    assert smoothness(circle()) == pytest.approx(-4.0 * np.log(2.0 * np.pi), abs=0.01)


def test_a_straight_path_is_perfectly_smooth_and_a_corner_is_not():
    line = np.array([[0.0, 0.0], [0.2, 0.1], [1.0, 0.5]])
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    assert smoothness(line) == 0.0
    assert turning(line) == pytest.approx(0.0, abs=1e-9)
    assert smoothness(corner) < smoothness(circle()) < 0.0


@given(angle=st.floats(-3.0, 3.0), scale=st.floats(0.01, 10.0))
@settings(max_examples=20, deadline=None)
def test_smoothness_and_turning_do_not_depend_on_place_and_size(angle, scale):
    path = circle()[:250] * [1.0, 0.6]
    c, s = np.cos(angle), np.sin(angle)
    moved = scale * path @ np.array([[c, s], [-s, c]]) + [0.3, -0.7]
    # Third differences of rounded points of order one, 1e-16 beside 1e-4 squared.
    assert smoothness(moved) == pytest.approx(smoothness(path), rel=1e-6)
    assert turning(moved) == pytest.approx(turning(path), rel=1e-6)


def test_bad_arguments_are_refused(open_branch):
    evaluate = partial(evaluate_generalisation, (open_branch,))
    for bad in (
        partial(evaluate_generalisation, ()),
        partial(evaluate, count=0),
        partial(evaluate, spread=1.0),
    ):
        with pytest.raises(ValueError, match="need branches"):
            bad()


def test_of_a_skill_alone_the_means_are_the_corridor(crossing):
    found = evaluate_generalisation(crossing, count=1)
    assert len(found.corridor) == len(crossing)
    assert np.array_equal(found.corridor[0], crossing[0].mean)
    given = evaluate_generalisation(crossing, [circle()], count=1)
    assert given.turning == turning(circle())
    assert len(crossing[0].chain) == len(crossing_chain())
