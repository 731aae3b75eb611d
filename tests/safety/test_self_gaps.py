"""Near pairs of links: their distances and how these change, against differences."""

import numpy as np
import pytest

from bath_drake.safety.self_distance import self_distance
from bath_drake.safety.self_gaps import self_gaps
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.scene.config import ArmConfig

CHAIN = arm_chain(ArmConfig())
FAR = 10.0


def postures(count, seed=2):
    rng = np.random.default_rng(seed)
    return rng.uniform(CHAIN.low, CHAIN.high, (count, 7))


def test_the_least_of_them_is_the_arms_distance_from_itself():
    for q in postures(100):
        least = self_gaps(q, CHAIN, FAR)[:, 0].min()
        assert least == pytest.approx(self_distance(q, CHAIN), abs=1e-12)  # rounding


def test_only_near_pairs_are_told():
    for q in postures(100):
        every = self_gaps(q, CHAIN, FAR)
        assert len(every) == len(CHAIN.pairs)
        near = self_gaps(q, CHAIN, 0.2)
        np.testing.assert_array_equal(near, every[every[:, 0] <= 0.2])


def test_their_derivatives_are_those_of_their_differences():
    step, errors = 1e-6, []
    for q in postures(200):
        rows = self_gaps(q, CHAIN, FAR)
        ahead, behind = (
            np.stack([self_gaps(q + way * e, CHAIN, FAR)[:, 0] for e in np.eye(7)], 1)
            for way in (step, -step)
        )
        error = np.abs((ahead - behind) / (2.0 * step) - rows[:, 1:])
        # Where axes cross there is no direction apart; both ends of one may be as near.
        errors.append(error[rows[:, 0] > 0.0].ravel())
    # The differences' own error is 1e-9; at a segment's end there is a kink.
    assert np.quantile(np.concatenate(errors), 0.99) < 1e-6


def test_joints_that_move_both_links_do_not_move_them_apart():
    q = postures(1)[0]
    rows = self_gaps(q, CHAIN, FAR)
    for row, (i, j) in zip(rows, CHAIN.pairs, strict=True):
        first, last = CHAIN.capsules[[i, j], 0].astype(int)
        still = [k for k in range(7) if not first <= k < last]
        np.testing.assert_array_equal(row[1:][still], 0.0)


def test_a_wrong_shape_is_refused():
    with pytest.raises(ValueError, match="q must have shape"):
        self_gaps(np.zeros(6), CHAIN, FAR)
