"""Circles on a moving point: they enter nothing, keep the pace and fade."""

import numpy as np
import pytest

from bath_drake.field.obstacles import ObstacleSet, Workspace, beta
from bath_drake.rhythm.limit_cycle import LimitCycle
from bath_drake.rhythm.superposition import Pace, Rhythm, Room, advance, offset

WIDE = Workspace(np.zeros(2), np.array([2.0, 2.0]))
FREE = Room(ObstacleSet(), WIDE)
HALF = np.array([0.2, 0.25])
DT = 0.01


def circles(radius=0.12, **lengths):
    rows = np.array([[radius, 0.0], [0.0, radius]])
    return LimitCycle(rows, **{"period": 1.0, "pitch": 0.15, **lengths})


def random_room(rng):
    """What is in the way, and where in free space the discrete motion is."""
    while True:
        u = rng.random((4, 5))
        theta = np.column_stack(
            [2.0 * u[:, :2] - 1.0, 0.02 * 25.0 ** u[:, 2:4], 7.0 * u[:, 4]]
        )
        power = int(rng.choice([2, 4, 8]))
        workspace = Workspace(rng.normal(0.0, 0.1, 2), rng.uniform(0.8, 2.0, 2), power)
        room = Room(ObstacleSet(theta), workspace, rng.choice([1.0, np.inf]))
        for q in rng.uniform(-1.0, 1.0, (4, 2)):
            if free(q, room):
                return room, q


def random_rhythm(rng):
    """A cycle, and where it is: on it or off."""
    count = int(rng.integers(1, 4))
    cycle = LimitCycle(rng.normal(0.0, 0.15, (2 * count, 2)), 1.0, 0.1)
    off = rng.normal(0.0, 0.1, 2) * rng.integers(0, 2)
    return cycle, Rhythm(phase=rng.uniform(0.0, 7.0), deviation=off, share=1.0)


def free(q, room):
    """Whether q is in no area, in the workspace and, if there is one, in the box."""
    return (
        bool((beta(q, room.areas) >= 0.0).all())
        and float(room.workspace.beta(q)) >= 0.0
        and float(np.abs(q).max()) <= room.half_box
    )


@pytest.mark.parametrize(
    "worlds", [2_000, pytest.param(10_000, marks=pytest.mark.exhaustive)]
)
def test_in_thousands_of_worlds_the_sum_enters_nothing(worlds):
    rng = np.random.default_rng(7)
    gave_way = 0
    for _ in range(worlds):
        (room, q), (cycle, rhythm) = random_room(rng), random_rhythm(rng)
        o = offset(cycle, rhythm, q, room)
        assert free(q + o, room), (cycle, rhythm, q, room)
        whole = cycle.offset(rhythm.phase) + rhythm.deviation
        gave_way += bool(np.linalg.norm(o) < 0.999 * np.linalg.norm(whole))
    # In most of the worlds the cycle has to, and not in all.
    assert 0.5 * worlds < gave_way < worlds


def walk(cycle, room, start, goal, speed=0.07, steps=6000, rhythm=None):
    """Straight to the goal with circles; discrete points, sums and phases."""
    length = float(np.linalg.norm(goal - start))
    pace = Pace(speed, HALF, length)
    q, rhythm = start, rhythm or Rhythm()
    discrete, sums, rhythms = [], [], []
    for _ in range(steps):
        d = goal - q
        away = float(np.hypot(*d))
        if away < 0.005:
            break
        velocity = d * (speed * min(1.0, away / 0.1) / np.hypot(*(d * HALF)))
        discrete.append(q)
        sums.append(q + offset(cycle, rhythm, q, room))
        rhythms.append(rhythm)
        rhythm, velocity = advance(cycle, rhythm, q, velocity, away, room, pace, DT)
        q = q + DT * velocity
    return np.array(discrete), np.array(sums), rhythms


START, GOAL = np.array([-0.7, -0.2]), np.array([0.7, 0.2])


def test_a_walk_round_areas_enters_none_of_them():
    areas = ObstacleSet(
        np.array([[0.0, 0.2, 0.1, 0.15, 0.3], [-0.4, -0.3, 0.1, 0.1, 0.0]])
    )
    room = Room(areas, WIDE, margin=0.02)
    _, sums, _ = walk(circles(), room, START, GOAL)
    # Outside by the margin: the ellipses grown by 0.02 are still outside the path.
    grown = areas.theta + np.array([0.0, 0.0, 0.019, 0.019, 0.0])
    assert beta(sums, ObstacleSet(grown)).min() > 0.0


def test_the_sum_is_never_faster_than_allowed():
    areas = ObstacleSet(np.array([[0.0, 0.2, 0.1, 0.15, 0.3]]))
    _, sums, _ = walk(circles(), Room(areas, WIDE), START, GOAL)
    speed = np.linalg.norm(np.diff(sums, axis=0) * HALF, axis=1) / DT
    # The time of a step is found in a few rounds: within a hundredth.
    assert speed.max() <= 1.01 * 0.07
    # Where nothing fades or shrinks it is no slower either.
    assert np.quantile(speed, 0.5) >= 0.98 * 0.07


def test_there_are_as_many_circles_a_length_as_shown():
    discrete, _, rhythms = walk(circles(), FREE, START, GOAL)
    turns = np.unwrap([rhythm.phase for rhythm in rhythms]) / (2.0 * np.pi)
    lengths = np.linalg.norm(discrete - START, axis=1)
    # Grown after one pitch, fading in the last.
    whole = (lengths > 0.3) & (lengths < 1.2)
    slope = np.polyfit(lengths[whole], turns[whole], 1)[0]
    assert slope == pytest.approx(1.0 / 0.15, rel=0.01)


def test_circles_come_and_go_within_a_period_of_the_ends():
    discrete, sums, _ = walk(circles(), FREE, START, GOAL)
    size = np.linalg.norm(sums - discrete, axis=1)
    assert size[0] == 0.0
    # 0.005 and a step from the goal, where it fades over the pitch of 0.15.
    assert size[-1] <= 0.12 * 0.006 / 0.15
    lengths = np.linalg.norm(discrete - START, axis=1)
    whole = (lengths > 0.3) & (lengths < 1.2)
    np.testing.assert_allclose(size[whole], 0.12, rtol=1e-6)


def test_circles_in_the_middle_are_nowhere_else():
    discrete, sums, _ = walk(circles(begin=0.4, end=0.5), FREE, START, GOAL)
    size = np.linalg.norm(sums - discrete, axis=1)
    lengths = np.linalg.norm(discrete - START, axis=1)
    assert size[lengths < 0.4].max() == 0.0
    # The whole way is 1.456 long; steps are rounded up at the end.
    assert size[lengths > 1.456 - 0.5 + 0.01].max() == 0.0
    assert size.max() == pytest.approx(0.12, rel=1e-6)


def test_pushed_off_the_cycle_it_is_back_after_one_period():
    cycle = circles()
    pace = Pace(10.0, np.ones(2), 1e3)
    rhythm = Rhythm(share=1.0, deviation=np.array([0.06, -0.08]))
    for _ in range(round(cycle.period / DT)):
        rhythm, _ = advance(
            cycle, rhythm, np.zeros(2), np.zeros(2), np.inf, FREE, pace, DT
        )
    off = offset(cycle, rhythm, np.zeros(2), FREE) - cycle.offset(rhythm.phase)
    assert np.linalg.norm(off) <= 0.01 * 0.1


def test_an_area_that_appears_shrinks_the_cycle_at_once_and_it_grows_again_slowly():
    cycle, rhythm = circles(), Rhythm(share=1.0)
    pace = Pace(0.07, HALF, 1e3)
    areas = ObstacleSet(np.array([[0.15, 0.0, 0.1, 0.1, 0.0]]))
    near = Room(areas, WIDE)
    at_once = offset(cycle, rhythm, np.zeros(2), near)
    # The radius is known to 1.1e-4 of itself.
    assert np.linalg.norm(at_once) == pytest.approx(0.05, rel=2e-4)
    rhythm, _ = advance(cycle, rhythm, np.zeros(2), np.zeros(2), np.inf, near, pace, DT)
    sizes = []
    for _ in range(100):
        sizes.append(np.linalg.norm(offset(cycle, rhythm, np.zeros(2), FREE)))
        rhythm, _ = advance(
            cycle, rhythm, np.zeros(2), np.zeros(2), np.inf, FREE, pace, DT
        )
    # A period from nothing to the whole: a hundredth of it a step.
    assert np.diff(sizes).min() >= 0.0
    assert np.diff(sizes).max() <= 0.12 * DT + 1e-9


def test_where_there_are_no_circles_the_discrete_motion_is_as_it_was():
    velocity = np.array([0.3, 0.1])
    pace = Pace(10.0, HALF, 2.0)
    _, moved = advance(
        circles(begin=1.0), Rhythm(), np.zeros(2), velocity, 2.0, FREE, pace, DT
    )
    np.testing.assert_array_equal(moved, velocity)
