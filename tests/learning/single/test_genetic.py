"""Local descent, which cannot cross the path; crossover and mutation; the vector."""

import numpy as np
import pytest

from bath_drake.field.obstacles import Workspace
from bath_drake.field.rollout import rollout
from bath_drake.learning import genome
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.paper.descent import descend
from bath_drake.learning.single.genetic import crossover, mutate
from bath_drake.notation import FloatArray

_DISC = Workspace(np.zeros(2), np.array([2.0, 2.0]))
_START, _GOAL = np.array([0.0, 0.9]), np.array([0.0, -0.9])
_RADIUS, _KAPPA = 0.2, 3.0


def _member(x: float) -> FloatArray:
    """One disc on the x axis, between the start and the goal (the paper's Fig. 3)."""
    r = np.log(_RADIUS)
    return np.array([x, 0.0, r, r, 0.0, np.log(_KAPPA)])


def _path(x: float) -> FloatArray:
    field = genome.decode(_member(x), _DISC, _GOAL)
    return rollout(_START, field, step=0.02).path


def _deviation(path: FloatArray) -> float:
    """The paper's x_2: where the path passes the x axis."""
    return float(np.interp(0.0, path[::-1, 1], path[::-1, 0]))


def test_the_path_dodges_to_the_far_side_of_the_disc() -> None:
    # Fig. 4: the deviation switches its sign with the side of the disc, and
    # dies away with its distance.
    left, right = _deviation(_path(-0.1)), _deviation(_path(0.1))
    assert left > 0.1
    np.testing.assert_allclose(left, -right, atol=1e-9)  # a mirrored world
    far = [abs(_deviation(_path(x))) for x in (0.1, 0.4, 0.8, 1.2, 1.6)]
    assert (np.diff(far) < 0.0).all()
    assert far[-1] < 0.3 * left


class OneDisc:
    """The paper's Sec. III-B: find the disc's place on the x axis from a path."""

    def __init__(self) -> None:
        self.target = _path(0.1)

    def cost(self, xs: FloatArray) -> FloatArray:
        found = [discrete_frechet(_path(x), self.target) for x in xs[:, 0]]
        return np.array(found)

    def clip(self, xs: FloatArray) -> FloatArray:
        """Only the disc's x is free."""
        out = np.tile(_member(0.0), (len(xs), 1))
        out[:, 0] = np.clip(xs[:, 0], -1.5, 1.5)
        return out


def test_descent_alone_cannot_carry_an_obstacle_across_the_path() -> None:
    problem = OneDisc()
    first = np.stack([_member(x) for x in (-0.1, -0.4)])
    before = problem.cost(first)
    xs, costs = descend(
        problem.cost, first, genome.scales(1), iterations=30, clip=problem.clip
    )
    assert (costs < before).all()
    # It is pushed away to the left instead: the paper's "Final".
    assert (xs[:, 0] < first[:, 0]).all()
    assert (costs > 0.1).all()


def test_descent_goes_to_the_bottom_of_a_bowl_and_never_up() -> None:
    centre = np.array([0.3, -0.2, 0.1])

    def bowl(xs: FloatArray) -> FloatArray:
        return ((xs - centre) ** 2).sum(axis=1)

    rng = np.random.default_rng(1)
    first = rng.normal(size=(5, 3))
    xs, costs = descend(bowl, first, np.ones(3), iterations=40)
    assert (costs <= bowl(first)).all()
    np.testing.assert_allclose(costs, bowl(xs))
    # Steps shrink fourfold at most: 40 of them halve the distance ten times at least.
    np.testing.assert_allclose(xs, np.tile(centre, (5, 1)), atol=1e-2)


def test_a_child_of_twins_is_their_copy_whatever_the_order_of_obstacles() -> None:
    rng = np.random.default_rng(2)
    x = np.append(rng.normal(size=15), 1.0)
    twin = np.append(x[:-1].reshape(3, 5)[[2, 0, 1]].ravel(), 1.0)
    for _ in range(10):
        np.testing.assert_allclose(crossover(x, twin, rng), x, atol=1e-12)


def test_mutation_moves_whole_obstacles_or_leaves_them() -> None:
    rng = np.random.default_rng(3)
    x = np.zeros(21)
    moved = mutate(x, 0.5, 0.1, rng)[:-1].reshape(4, 5) != 0.0
    assert (moved.all(axis=1) | ~moved.any(axis=1)).all()
    np.testing.assert_array_equal(mutate(x, 0.0, 1.0, rng), x)


@pytest.mark.parametrize("count", [0, 1, 5])
def test_a_vector_decodes_to_the_field_it_encodes(count: int) -> None:
    rng = np.random.default_rng(count)
    x = genome.clip(rng.normal(size=5 * count + 1), _DISC)
    field = genome.decode(x, _DISC, _GOAL)
    again = genome.decode(genome.encode(field), _DISC, _GOAL)
    np.testing.assert_allclose(again.obstacles.theta, field.obstacles.theta, rtol=1e-12)
    np.testing.assert_allclose(again.kappa, field.kappa, rtol=1e-12)
    theta = field.obstacles.theta
    assert (theta[:, 2] >= theta[:, 3]).all()
    assert (np.abs(theta[:, 4]) <= 0.5 * np.pi + 1e-12).all()
