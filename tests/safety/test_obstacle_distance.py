"""How near links come to boxes."""

from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.safety.arm_chain import NOZZLE
from bath_drake.safety.obstacle_distance import (
    FAR,
    link_gaps,
    obstacle_distance_ahead,
)
from bath_drake.safety.obstacles import Boxes, upright_box
from bath_drake.safety.self_distance import capsule_ends
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.scene.config import ArmConfig

CHAIN = arm_chain(ArmConfig())
HOME = np.array(ArmConfig().home)
positions = st.tuples(
    *[st.floats(a, b) for a, b in zip(CHAIN.low, CHAIN.high, strict=True)]
).map(np.array)
places = st.tuples(*3 * [st.floats(-0.8, 0.8)]).map(np.array)
BOX = upright_box([-0.1, -0.1, -0.15], [0.1, 0.1, 0.15], (0, NOZZLE))


def at(centre):
    half = np.array([0.1, 0.1, 0.15])
    return upright_box(centre - half, centre + half, (0, NOZZLE))


def sampled(q, boxes):
    """Each capsule's distance by trying 2000 places along it, (n,), m."""
    share = np.linspace(0.0, 1.0, 2000)[:, None]
    (centre,), (half,) = boxes.centres, boxes.halves
    gaps = []
    ends = capsule_ends(q, CHAIN)
    for (a, b), radius in zip(ends, CHAIN.capsules[:, 7], strict=True):
        over = np.abs(a + share * (b - a) - centre) - half
        outside = np.linalg.norm(np.maximum(over, 0.0), axis=1)
        inside = np.minimum(over.max(axis=1), 0.0)
        gaps.append((outside + inside).min() - radius)
    return np.array(gaps)


@given(q=positions, centre=places)
def test_it_is_the_distance_or_a_bound_from_below_where_far(q, centre):
    rows = link_gaps(q, CHAIN, at(centre))
    expected = sampled(q, at(centre))
    near = expected < FAR
    # Sampling and thirds: half a millimetre of at most 0.4 m.
    np.testing.assert_allclose(rows[near, 0], expected[near], atol=5e-4)
    assert (rows[:, 0] <= expected + 5e-4).all()
    assert (rows[~near, 0] >= FAR - 5e-4).all()


def test_its_derivatives_are_those_of_its_differences():
    rng = np.random.default_rng(1)
    step, checked = 1e-6, 0
    for _ in range(200):
        q, boxes = rng.uniform(CHAIN.low, CHAIN.high), at(rng.uniform(-0.6, 0.6, 3))
        rows = link_gaps(q, CHAIN, boxes)
        differences = np.stack(
            [
                link_gaps(q + step * e, CHAIN, boxes)[:, 0]
                - link_gaps(q - step * e, CHAIN, boxes)[:, 0]
                for e in np.eye(7)
            ],
            axis=1,
        ) / (2.0 * step)
        # Outside, nearer than FAR, and not where two faces or ends are as near.
        smooth = (rows[:, 0] > 0.0) & (rows[:, 0] < FAR - 1e-3)
        error = np.abs(differences - rows[:, 1:])[smooth]
        checked += len(error)
        # Where the nearest place slides along a face the thirds leave it open.
        assert np.quantile(error, 0.9) < 1e-3 if len(error) else True
    assert checked > 50


def test_the_nozzle_does_not_keep_off_a_person():
    tip = capsule_ends(HOME, CHAIN)[CHAIN.capsules[:, 0] == NOZZLE].mean(axis=(0, 1))
    small = np.full(3, 0.01)
    minded = upright_box(tip - small, tip + small, (0, NOZZLE))
    spared = upright_box(tip - small, tip + small)
    assert link_gaps(HOME, CHAIN, minded)[:, 0].min() < 0.0
    assert link_gaps(HOME, CHAIN, spared)[:, 0].min() > 0.0


def test_where_there_is_nothing_all_is_far():
    assert (link_gaps(HOME, CHAIN, Boxes())[:, 0] == inf).all()
    assert obstacle_distance_ahead(HOME, np.zeros(7), CHAIN, Boxes()) == FAR


@given(q=positions, centre=places, v=st.tuples(*7 * [st.floats(-1, 1)]).map(np.array))
def test_ahead_is_the_least_on_the_way(q, centre, v):
    told = obstacle_distance_ahead(q, v, CHAIN, at(centre), 0.2)
    along = [
        min(FAR, link_gaps(q + s * 0.2 * v, CHAIN, at(centre))[:, 0].min())
        for s in (0.0, 0.5, 1.0)
    ]
    # A bound from below is no worse for being told earlier.
    assert told == pytest.approx(min(along), abs=1e-9)


@pytest.mark.parametrize("bad", [nan, inf])
def test_what_is_no_number_has_no_distance(bad):
    q = HOME.copy()
    q[3] = bad
    assert np.isnan(obstacle_distance_ahead(q, np.zeros(7), CHAIN, BOX))
    assert np.isnan(obstacle_distance_ahead(HOME, np.full(7, bad), CHAIN, BOX))


def test_shapes_and_the_lookahead_are_checked():
    with pytest.raises(ValueError, match="q must have shape"):
        link_gaps(np.zeros(6), CHAIN, BOX)
    with pytest.raises(ValueError, match="v must have shape"):
        obstacle_distance_ahead(HOME, np.zeros(6), CHAIN, BOX)
    with pytest.raises(ValueError, match="lookahead must be"):
        obstacle_distance_ahead(HOME, np.zeros(7), CHAIN, BOX, -0.1)
