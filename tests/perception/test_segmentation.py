import dataclasses

import numpy as np
import pytest

from bath_drake.patient.people import shipped_people
from bath_drake.perception.completion import Expectation
from bath_drake.perception.segmentation import (
    SegmentationConfig,
    segment_back,
    skin_mask,
)

# The axes of the drawn back: right, up, out towards the camera.
UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def _points(frame):
    p_C = frame.camera.deproject(frame.depth)
    return frame.p_WC + p_C @ frame.R_WC.T


def _segment(frame, expected=None):
    skin = skin_mask(frame.colour, frame.config)
    return segment_back(skin, _points(frame), frame.robot_mask, frame.config, expected)


def _overlap(a, b):
    return (a & b).sum() / max((a | b).sum(), 1)


def test_the_back_is_found_without_the_arm(draw_frame):
    frame = draw_frame()
    visible, completed = _segment(frame)
    # The corners are rounded by the torso's disc.
    assert _overlap(visible, frame.back) > 0.93
    np.testing.assert_array_equal(visible, completed)


@pytest.mark.parametrize(
    "skin",
    [(245, 220, 205), (224, 172, 140), (141, 85, 54), (90, 56, 38), (60, 38, 28)],
)
@pytest.mark.parametrize("light", [1.0, 0.6])
def test_every_skin_in_every_light_is_skin(draw_frame, skin, light):
    frame = draw_frame(skin=tuple(int(light * c) for c in skin))
    assert _overlap(_segment(frame)[0], frame.back) > 0.93


@pytest.mark.parametrize(
    "colour", [(200, 198, 195), (235, 235, 235), (40, 50, 110), (90, 90, 90), (3, 2, 2)]
)
def test_walls_trunks_robot_and_black_are_no_skin(colour):
    config = SegmentationConfig(box_low_W=np.zeros(3), box_high_W=np.ones(3))
    image = np.full((4, 4, 3), colour, dtype=np.uint8)
    assert not skin_mask(image, config).any()


def test_a_wound_belongs_to_the_back(draw_frame):
    frame = draw_frame(wound=(0.05, 0.05, 0.04, 0.03))
    visible, _ = _segment(frame)
    assert _overlap(visible, frame.back) > 0.93
    assert visible[(frame.colour == (25, 12, 12)).all(axis=-1)].all()


def test_pixels_that_the_sensor_lost_cost_the_back_nothing_else(draw_frame):
    whole = _segment(draw_frame())[0]
    frame = draw_frame()
    rng = np.random.default_rng(1)
    # One in two hundred, as at places that shine; each alone could keep a disc out.
    lost = frame.back & (rng.random(frame.depth.shape) < 0.005)
    frame.depth[lost] = np.nan
    visible, _ = _segment(frame)
    assert not (visible & lost).any()
    assert _overlap(visible | lost, whole | lost) > 0.98


def test_a_skin_coloured_wall_outside_the_box_is_no_back(draw_frame):
    frame = draw_frame()
    frame.colour[~frame.back & (frame.depth > 2.0)] = (200, 150, 120)
    assert _overlap(_segment(frame)[0], frame.back) > 0.9


def test_an_empty_room_shows_no_back(draw_frame):
    frame = draw_frame()
    frame.depth[:] = np.nan
    visible, completed = _segment(frame)
    assert not visible.any()
    assert not completed.any()


def test_the_robot_is_never_visible_back_but_is_completed(draw_frame):
    frame = draw_frame(robot=(-0.03, 0.03, -0.5, 0.0))
    visible, completed = _segment(frame)
    assert not (visible & frame.robot_mask).any()
    hidden = frame.back & frame.robot_mask
    assert (completed & hidden).sum() > 0.9 * hidden.sum()
    # Both sides of the robot stay: it must not cut the back in two.
    assert _overlap(visible, frame.back & ~frame.robot_mask) > 0.9


def test_what_was_expected_is_completed_even_at_the_edge(draw_frame):
    frame = draw_frame(robot=(0.1, 0.3, -0.5, 0.0))
    expected = Expectation(draw_frame().back, UPRIGHT, (0.77, 1.23))
    _, completed = _segment(frame, expected)
    assert _overlap(completed, frame.back) > 0.93


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("box_low_W", np.full(3, 2.0)),
        ("box_high_W", np.array([1.0, np.inf, 1.0])),
        ("torso_radius", 0.0),
        ("jump", -0.1),
        ("hole_area", -1.0),
        ("min_pixels", 100),
        ("min_saturation", 1.5),
    ],
)
def test_impossible_configurations_are_refused(name, value):
    good = {"box_low_W": np.zeros(3), "box_high_W": np.ones(3)}
    with pytest.raises(ValueError, match=name):
        SegmentationConfig(**{**good, name: value})


def test_configurations_can_be_varied():
    config = SegmentationConfig(box_low_W=np.zeros(3), box_high_W=np.ones(3))
    assert dataclasses.replace(config, jump=0.05).jump == 0.05


@pytest.mark.render
def test_the_backs_of_all_people_are_found(render_person):
    overlaps = []
    for person in shipped_people():
        frame = render_person(person)
        overlaps.append(_overlap(_segment(frame)[0], frame.back))
    # Measured 0.91 to 0.94.
    assert np.mean(overlaps) >= 0.9
    assert min(overlaps) >= 0.85


def test_a_hole_with_a_pixel_without_depth_is_survived(draw_frame):
    frame = draw_frame()
    found = frame.observe()
    rows, columns = np.nonzero(found.mask)
    row, column = int(np.median(rows)), int(np.median(columns))
    # A wound of 15 by 15 pixels, of which one has no depth.
    frame.colour[row - 7 : row + 8, column - 7 : column + 8, :3] = (40, 200, 40)
    frame.depth[row, column] = 0.0
    again = frame.observe()
    assert again.found
    assert np.isfinite(again.points_W).all()
