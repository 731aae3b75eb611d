"""How fast a body moves, and whether somebody else came near it."""

import numpy as np
import pytest

from bath_drake.perception.body_check import (
    SPEED_FRAMES,
    VOXEL,
    BodyCheck,
    check_body,
    filled_voxels,
)
from bath_drake.perception.canonical import CanonicalMap

FRAME = 1.0 / 30.0
LOW, HIGH = np.zeros(3), np.array([0.8, 1.2, 1.2])


def map_at(x=0.0):
    return CanonicalMap(np.eye(3), np.array([x, 0.0, 0.0]), np.array([0.18, 0.24]))


def blob(centre, size=0.2, area=0.1):
    """Voxels of a cube's points that stand for so much surface."""
    steps = np.linspace(-size / 2, size / 2, 8)
    points = np.stack(np.meshgrid(steps, steps, steps), -1).reshape(-1, 3) + centre
    return filled_voxels(points, np.full(len(points), area / len(points)), LOW, HIGH)


PERSON = blob([0.4, 0.5, 0.5])


def after(frames):
    """What is known after frames of (map, all voxels)."""
    check = BodyCheck()
    for k, (canonical_map, voxels, *more) in enumerate(frames):
        area = more[0] if more else 0.09
        check = check_body(check, k * FRAME, canonical_map, area, voxels, PERSON)
    return check


@pytest.mark.parametrize("speed", [0.0, 0.05, 0.3])
def test_the_speed_is_that_of_the_map(speed):
    frames = [(map_at(speed * k * FRAME), PERSON) for k in range(24)]
    assert after(frames).speed == pytest.approx(speed, abs=1e-9)


def test_the_first_map_is_still_on_its_way_and_no_moving_body():
    jump = [(map_at(), PERSON)] + [(map_at(0.02), PERSON)] * 30
    assert [after(jump[:k]).speed for k in range(1, 31)] == [0.0] * 30


def test_a_push_is_seen_within_the_frames_of_the_window():
    still = [(map_at(), PERSON)] * 19
    pushed = [(map_at(0.3 * k * FRAME), PERSON) for k in range(1, SPEED_FRAMES + 1)]
    assert after(still).speed == 0.0
    assert after(still + pushed).speed == pytest.approx(0.3)


def test_a_back_of_which_another_part_is_seen_has_not_moved():
    frames = [(map_at(), PERSON)] * 3 + [(map_at(0.1), PERSON, 0.06)]
    assert after(frames).speed == 0.0
    # Nor while its map is still on its way; but then it is watched again.
    on = [(map_at(0.1 + 0.3 * k * FRAME), PERSON, 0.06) for k in range(1, 24)]
    assert after(frames + on[:12]).speed == 0.0
    assert after(frames + on).speed == pytest.approx(0.3)


def test_without_a_map_there_is_no_speed_and_none_across_the_gap():
    frames = [(map_at(), PERSON), (None, PERSON), (map_at(0.5), PERSON)]
    assert after(frames).speed == 0.0


def test_who_comes_in_is_counted_and_who_was_there_is_not():
    visitor = blob([0.4, 1.05, 0.5])
    alone, both = (map_at(), PERSON), (map_at(), PERSON + visitor)
    assert after([alone, alone]).others == 0
    assert after([alone, both]).others == 1
    assert after([both, both]).others == 0


def test_specks_and_pieces_that_the_robot_cuts_off_are_nobody():
    speck = blob([0.4, 1.05, 0.5], size=0.02, area=0.002)
    cut = PERSON.copy()
    cut[4] = 0
    assert after([(map_at(), PERSON), (map_at(), PERSON + speck)]).others == 0
    assert after([(map_at(), PERSON), (map_at(), cut)]).others == 0


def test_a_frame_that_is_no_later_changes_nothing():
    check = after([(map_at(), PERSON)] * 2)
    assert check_body(check, FRAME, map_at(1.0), 0.09, PERSON, PERSON) is check


def test_points_out_of_the_box_and_no_points_fill_nothing():
    points = np.array([[-0.1, 0.5, 0.5], [0.4, 2.0, 0.5], [np.nan, 0.5, 0.5]])
    assert filled_voxels(points, np.ones(3), LOW, HIGH).sum() == 0
    one = filled_voxels(np.array([[0.5, 0.5, 0.5]]), np.array([0.01]), LOW, HIGH)
    assert one[tuple(int(0.5 / VOXEL) for _ in range(3))] == 100
