"""The whole motion along a path: its ends, its pace, its room."""

import numpy as np
import pytest

from bath_drake.field.obstacles import ObstacleSet, Workspace, beta
from bath_drake.rhythm.limit_cycle import LimitCycle
from bath_drake.rhythm.superposition import Room
from bath_drake.rhythm.whole_motion import STEP_S, whole_motion

CYCLE = LimitCycle(np.array([[0.1, 0.0], [0.0, 0.06]]), period=0.8, pitch=0.12)
WIDE = Workspace(np.zeros(2), np.array([2.0, 2.0]))
HALF = np.array([0.2, 0.25])
PATH = np.stack(
    [np.linspace(-0.7, 0.7, 60), 0.2 * np.sin(np.linspace(0.0, 4.0, 60))], axis=-1
)


def whole(room=None, path=PATH):
    room = room or Room(ObstacleSet(), WIDE)
    return whole_motion(CYCLE, path, room, speed=0.07, half_extents=HALF)


def test_it_begins_and_ends_where_the_path_does():
    times, points = whole()
    np.testing.assert_array_equal(points[0], PATH[0])
    # The last millimetre of N is left out.
    np.testing.assert_allclose(points[-1], PATH[-1], atol=2e-3)
    np.testing.assert_allclose(np.diff(times), STEP_S)


def test_it_is_no_faster_than_allowed():
    _, points = whole()
    speed = np.linalg.norm(np.diff(points, axis=0) * HALF, axis=1) / STEP_S
    # The time of a step is found in a few rounds, and a path has corners.
    assert speed.max() <= 1.02 * 0.07


def test_it_has_a_cycle_a_pitch():
    _, points = whole()
    length = np.linalg.norm(np.diff(PATH, axis=0), axis=1).sum()
    # Off the path to either side, once a cycle each.
    across = points[:, 1] - np.interp(points[:, 0], *PATH.T)
    sides = np.sign(across[np.abs(across) > 0.02])
    turns = np.count_nonzero(np.diff(sides)) / 2.0
    assert turns == pytest.approx(length / CYCLE.pitch, abs=1.5)


def test_it_enters_no_area():
    areas = ObstacleSet(np.array([[0.1, 0.32, 0.15, 0.1, 0.4]]))
    assert beta(PATH, areas).min() > 0.0
    _, points = whole(Room(areas, WIDE))
    assert beta(points, areas).min() >= 0.0


def test_points_that_come_twice_do_not_matter():
    twice = np.repeat(PATH, 2, axis=0)
    np.testing.assert_allclose(whole(path=twice)[1], whole()[1], atol=1e-12)
