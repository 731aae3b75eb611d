"""A similarity moves points there and back, and a field with all known of it."""

import hypothesis.strategies as st
import numpy as np
import pytest
from chains import make, random_chain
from hypothesis import given, settings

from bath_drake.certificate.certify import certify
from bath_drake.composition.similarity import Similarity, identity
from bath_drake.field.navigation import NavigationField, flow_direction, min_beta, psi
from bath_drake.field.obstacles import ObstacleSet, Workspace

NUMBER = st.floats(-3.0, 3.0)


@st.composite
def similarities(draw):
    stretch = draw(st.floats(0.3, 3.0)) * np.exp(1j * draw(st.floats(-3.2, 3.2)))
    pivot, shift = draw(st.tuples(NUMBER, NUMBER)), draw(st.tuples(NUMBER, NUMBER))
    return Similarity(np.array(pivot), stretch, np.array(shift))


@given(similarities(), st.tuples(NUMBER, NUMBER))
def test_points_come_back(by, q):
    # Numbers of size 30 at most, a few roundings, then divided by 0.3 at least.
    np.testing.assert_allclose(by.back(by.points(q)), q, atol=1e-13)
    np.testing.assert_allclose(by.points(by.back(q)), q, atol=1e-13)


@given(similarities(), st.tuples(NUMBER, NUMBER), st.tuples(NUMBER, NUMBER))
def test_lengths_grow_by_the_scale_and_directions_turn_by_the_turn(by, p, q):
    moved = by.points(p) - by.points(q)
    way = np.subtract(p, q)
    assert np.hypot(*moved) == pytest.approx(by.scale * np.hypot(*way), abs=1e-12)
    np.testing.assert_allclose(moved, by.directions(way), atol=1e-12)
    c, s = np.cos(by.turn), np.sin(by.turn)
    turned = by.scale * np.array([[c, -s], [s, c]]) @ way
    np.testing.assert_allclose(moved, turned, atol=1e-12)


def free_points(field, rng, count=40):
    q = rng.uniform(-2.4, 2.4, (count, 2))
    return q[min_beta(q, field) > 0.01]


@settings(max_examples=25)
@given(similarities(), st.integers(0, 2**32 - 1))
def test_a_moved_field_s_psi_differs_by_a_constant_and_its_flow_turns_along(by, seed):
    rng = np.random.default_rng(seed)
    field = random_chain(rng, 1).fields[0]
    moved = by.field(field)
    q = free_points(field, rng)
    # beta >= 0.01 is a difference of numbers of order 1 to 200: 1e-13 off, so that
    # logarithms, times exponents, are 1e-10 off at worst.
    apart = psi(by.points(q), moved) - psi(q, field)
    np.testing.assert_allclose(apart, 2.0 * field.kappa * np.log(by.scale), atol=1e-9)
    flow = by.directions(flow_direction(q, field)) / by.scale
    # Directions are worse conditioned where forces balance.
    np.testing.assert_allclose(flow_direction(by.points(q), moved), flow, atol=1e-6)
    np.testing.assert_allclose(
        min_beta(by.points(q), moved), min_beta(q, field), rtol=1e-9
    )


@pytest.mark.parametrize("angle", [0.3, -2.0])
@pytest.mark.parametrize("b", [0.25, 1.0])
def test_the_verdict_moves_along(angle, b):
    # A disc is passed, a broadside ellipse at small kappa traps what comes from behind.
    field = make((1.5, 0.0), [0.0, 0.0, 0.25, b, 0.0], kappa=2.0)
    by = Similarity(np.array([0.3, -1.0]), 1.7 * np.exp(1j * angle), np.array([2, 3.0]))
    here, there = certify(field), certify(by.field(field))
    assert here.verdict == there.verdict == ("proved" if b == 0.25 else "refuted")
    assert len(here.critical_points) == len(there.critical_points)
    for p in here.critical_points:
        x, y = by.points([p.x, p.y])
        # Newton's method converges to some 1e-12 of the size.
        assert any(np.hypot(x - o.x, y - o.y) < 1e-9 for o in there.critical_points)


def test_the_identity_leaves_the_very_field():
    field = make((1.0, 0.0), [0.0, 0.0, 0.2, 0.3, 0.1])
    assert identity().is_identity
    assert identity().field(field) is field


def test_a_workspace_that_is_no_disc_is_not_moved():
    square = Workspace(np.zeros(2), np.ones(2), 4)
    by = Similarity(np.zeros(2), 1j, np.zeros(2))
    with pytest.raises(ValueError, match="round workspace"):
        by.field(NavigationField(square, np.zeros(2), 3.0, ObstacleSet()))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((np.zeros(3), 1.0, np.zeros(2)), "pivot must be two finite numbers"),
        ((np.zeros(2), 1.0, np.full(2, np.nan)), "shift must be two finite numbers"),
        ((np.zeros(2), 0.0, np.zeros(2)), "stretch must be finite and not zero"),
        ((np.zeros(2), complex(np.inf, 0), np.zeros(2)), "stretch must be finite"),
    ],
)
def test_what_is_no_similarity_is_refused(values, message):
    with pytest.raises(ValueError, match=message):
        Similarity(*values)
