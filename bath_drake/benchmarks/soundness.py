"""Does the proof's test of a box ever say what is not so?

Random boxes of all sizes are laid on and beside the places where a mistake would
show: critical points, boundaries, the goal. Each verdict is held against numerical
evidence.
"""

from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
from numba import njit

from bath_drake.benchmarks import numpy_field
from bath_drake.benchmarks.evidence import Evidence
from bath_drake.benchmarks.random_worlds import disjoint_world, overlapping_world
from bath_drake.certificate.box_test import box_test
from bath_drake.certificate.evaluation import new_table
from bath_drake.certificate.isolation import enclose
from bath_drake.certificate.world import Uncertainty, World, interval_world
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import FloatArray, IntArray

_INNER: Final = 2


def wrong_boxes(
    rng: np.random.Generator,
    field: NavigationField,
    count: int,
    uncertainty: Uncertainty | None = None,
) -> int:
    """How many of `count` random boxes about a field get a wrong verdict.

    With an uncertainty, verdicts on the uncertain field are held against one of its
    realisations, drawn at random.
    """
    uncertain = field
    if uncertainty is not None:
        field = realisation(rng, field, uncertainty)
    evidence = Evidence.of(field)
    boxes = random_boxes(rng, field, evidence.roots, count)
    q = points_of(rng, boxes)
    # One box in three is asked about a level it holds; the others about free space.
    level = numpy_field.psi(q[:, -1], field)
    levels = np.where(rng.uniform(size=count) < 1 / 3, level, np.inf)
    verdicts, kinds = judge(uncertain, boxes, levels, uncertainty)
    wrong = evidence.against_verdicts(boxes, verdicts, levels, q)
    wrong |= evidence.against_enclosures(boxes, kinds, q)
    return int(wrong.sum())


def varied_world(
    rng: np.random.Generator, kind: int
) -> tuple[NavigationField, Uncertainty | None]:
    """A random field, and by how much its obstacles are uncertain; kappa in 2..150.

    Every other kind is of 12 disjoint ellipses, the others of 20 overlapping ones. Of
    each four of them two are plain, one has exponents in 0.5..3 and a workspace of
    power 4, and one obstacles that are uncertain by up to 0.01.
    """
    make = partial(overlapping_world, count=20)
    if kind % 2 == 0:
        make = partial(disjoint_world, count=12)
    field = make(rng, kappa=rng.uniform(2.0, 150.0))
    variant = kind // 2 % 4
    if variant == 2:
        exponents = rng.uniform(0.5, 3.0, len(field.obstacles))
        rim = field.workspace
        field = replace(
            field,
            workspace=Workspace(rim.centre, rim.semi_axes, 4),
            obstacles=ObstacleSet(field.obstacles.theta, exponents),
        )
    if variant == 3:
        half = 10.0 ** rng.uniform(-5.0, -2.0, 2)
        return field, Uncertainty(centres=half[0], semi_axes=half[1])
    return field, None


def realisation(
    rng: np.random.Generator, field: NavigationField, uncertainty: Uncertainty
) -> NavigationField:
    """A field whose obstacles differ by no more than the uncertainty, one by one."""
    theta = field.obstacles.theta.copy()
    count = len(theta)
    for columns, given in (
        (slice(0, 2), uncertainty.centres),
        (slice(2, 4), uncertainty.semi_axes),
    ):
        half = np.broadcast_to(np.asarray(given, dtype=np.float64), count)[:, None]
        # Just short of the ends: adding rounds.
        theta[:, columns] += (1.0 - 1e-9) * half * rng.uniform(-1.0, 1.0, (count, 2))
    return replace(field, obstacles=ObstacleSet(theta, field.obstacles.powers))


def random_boxes(
    rng: np.random.Generator, field: NavigationField, roots: FloatArray, count: int
) -> FloatArray:
    """Rows x low, x high, y low, y high, shape (count, 4).

    Six in ten about a critical point, three about a boundary, one about the goal
    (all about the goal if there is nothing else). Half sides are log-uniform in
    1e-7..0.3 of the workspace's size, their ratio in 0.1..10; the place itself is in
    the box in four of nine.
    """
    size = float(field.workspace.semi_axes.max())
    t = np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)
    rim = np.stack([np.cos(t), np.sin(t)], axis=-1)
    power = field.workspace.power
    rim /= (np.abs(rim) ** power).sum(axis=-1, keepdims=True) ** (1.0 / power)
    rim *= field.workspace.semi_axes
    ellipses = field.obstacles.boundary(64).reshape(-1, 2)
    boundary = np.concatenate([ellipses, field.workspace.centre + rim])
    goal = field.goal[None]
    places = [roots if len(roots) else goal, boundary, goal]
    kinds = rng.choice(3, size=count, p=[0.6, 0.3, 0.1])
    about = np.empty((count, 2))
    for kind, choices in enumerate(places):
        mine = np.flatnonzero(kinds == kind)
        about[mine] = choices[rng.integers(len(choices), size=len(mine))]
    half = size * 10.0 ** rng.uniform(-7.0, np.log10(0.3), (count, 1))
    half = half * 10.0 ** rng.uniform(-0.5, 0.5, (count, 2))
    middle = about + half * rng.uniform(-1.5, 1.5, (count, 2))
    low, high = middle - half, middle + half
    return np.stack([low[:, 0], high[:, 0], low[:, 1], high[:, 1]], axis=-1)


def points_of(rng: np.random.Generator, boxes: FloatArray) -> FloatArray:
    """The corners of boxes (n, 4) and two random points of each, shape (n, 6, 2).

    Where F is nearly linear, its values at the corners surround zero just when the
    box holds a root: corners show most.
    """
    low, high = boxes[:, None, ::2], boxes[:, None, 1::2]
    corners = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    share = rng.uniform(size=(len(boxes), _INNER, 2))
    inner = np.clip(low + share * (high - low), low, high)
    return np.concatenate([np.where(corners, high, low), inner], axis=1)


def judge(
    field: NavigationField,
    boxes: FloatArray,
    levels: FloatArray,
    uncertainty: Uncertainty | None = None,
) -> tuple[IntArray, IntArray]:
    """What `box_test` and `enclose` say of each box, twice shape (n,)."""
    verdicts, kinds = _judge(interval_world(field, uncertainty), boxes, levels)
    return verdicts, kinds


@njit(cache=True)
def _judge(
    world: World, boxes: FloatArray, levels: FloatArray
) -> tuple[IntArray, IntArray]:
    table = new_table(world)
    verdicts = np.empty(boxes.shape[0], dtype=np.int64)
    kinds = np.empty(boxes.shape[0], dtype=np.int64)
    for i in range(boxes.shape[0]):
        x = (boxes[i, 0], boxes[i, 1])
        y = (boxes[i, 2], boxes[i, 3])
        verdicts[i] = box_test(x, y, world, levels[i], table)
        kinds[i] = enclose(x, y, world, table)
    return verdicts, kinds
