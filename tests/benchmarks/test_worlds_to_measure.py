import numpy as np
import pytest

from bath_drake.benchmarks.random_worlds import (
    GAP,
    RADIUS,
    disjoint_world,
    free_points,
    overlapping_world,
)
from bath_drake.field.navigation import min_beta
from bath_drake.field.obstacles import beta, pair_gaps

SEEDS = range(20)
# The slits are measured along a fourth of the directions, so that these find more.
ROUNDING = 1e-12


def a_world(make, seed, count=12, kappa=20.0):
    return make(np.random.default_rng(seed), count, kappa)


@pytest.mark.parametrize("seed", SEEDS)
def test_disjoint_ellipses_lie_apart_and_off_the_rim(seed):
    field = a_world(disjoint_world, seed)
    assert len(field.obstacles) == 12
    assert pair_gaps(field.obstacles).min() >= GAP - ROUNDING
    outline = field.obstacles.boundary(720)
    # 180 directions miss the farthest point by at most 2e-4 of the radius.
    assert np.hypot(outline[..., 0], outline[..., 1]).max() < RADIUS - 0.98 * GAP


@pytest.mark.parametrize("make", [disjoint_world, overlapping_world])
@pytest.mark.parametrize("seed", SEEDS)
def test_the_goal_is_free_and_off_every_boundary(make, seed):
    field = a_world(make, seed)
    assert min_beta(field.goal, field) > 0.0
    outline = field.obstacles.boundary(720).reshape(-1, 2)
    assert np.linalg.norm(outline - field.goal, axis=-1).min() >= GAP - ROUNDING


@pytest.mark.parametrize("seed", SEEDS)
def test_overlapping_ellipses_overlap_each_other_and_the_rim(seed):
    field = a_world(overlapping_world, seed, count=20)
    assert len(field.obstacles) == 20
    outline = field.obstacles.boundary(720)
    assert (beta(outline, field.obstacles) < 0.0).any()
    rim = field.workspace.beta(outline)
    assert (rim < 0.0).any()
    # Every centre is in the workspace: no ellipse is wasted outside.
    assert (field.workspace.beta(field.obstacles.theta[:, :2]) >= 0.0).all()


@pytest.mark.parametrize("make", [disjoint_world, overlapping_world])
def test_the_same_seed_gives_the_same_world(make):
    assert a_world(make, 3) == a_world(make, 3)
    assert a_world(make, 3) != a_world(make, 4)


@pytest.mark.parametrize("count", [0, 1, 2, 40])
def test_any_number_of_disjoint_ellipses_can_be_had(count, rng):
    field = disjoint_world(rng, count, 5.0)
    assert len(field.obstacles) == count
    assert field.kappa == 5.0


def test_counts_that_cannot_be_are_refused(rng):
    with pytest.raises(ValueError, match=r"count must be in 0\.\.200, got 201"):
        disjoint_world(rng, 201, 5.0)
    with pytest.raises(ValueError, match="count must be at least 2"):
        overlapping_world(rng, 1, 5.0)


def test_free_points_are_free_and_all_over_the_workspace(rng):
    field = disjoint_world(rng, 12, 20.0)
    q = free_points(rng, field, 1000)
    assert q.shape == (1000, 2)
    assert (min_beta(q, field) > 0.0).all()
    # Uniform over the disc: a quadrant has a fourth, give or take the obstacles.
    assert min((q > 0.0).mean(axis=0)) > 0.3
    assert max((q > 0.0).mean(axis=0)) < 0.7
