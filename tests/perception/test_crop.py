"""Looking only where a body may be finds what looking everywhere does."""

import numpy as np
import pytest

from bath_drake.perception.completion import Expectation
from bath_drake.perception.crop import (
    Crop,
    boxed_pixels,
    crop_to_body,
    points_in_window,
    seen_points,
)
from bath_drake.perception.pixels import inside_box, pixel_areas, points_in_world
from bath_drake.perception.segmentation import segment_crop, skin_mask

ROBOTS = (
    None,
    (-0.02, 0.05, -0.5, 0.1),  # across the middle
    (-0.6, -0.1, -0.05, 0.05),  # from the side
    (-0.6, 0.6, -0.5, 0.5),  # all over it
)
UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@pytest.fixture
def rng():
    return np.random.default_rng(8)


def _looked_at(frame):
    """A frame's pose and all its points, as contiguous arrays."""
    R_WC = np.ascontiguousarray(frame.R_WC)
    points = points_in_world(frame.depth, frame.camera.rays, R_WC, frame.p_WC)
    return R_WC, points


def test_pixels_in_the_box_are_those_of_the_points(draw_frame, rng):
    frame = draw_frame(robot=ROBOTS[1])
    frame.depth += 0.2 * rng.standard_normal(frame.depth.shape)
    frame.depth[rng.random(frame.depth.shape) < 0.1] = np.nan
    frame.depth[rng.random(frame.depth.shape) < 0.1] = np.inf
    frame.depth[rng.random(frame.depth.shape) < 0.1] = 0.0
    R_WC, points = _looked_at(frame)
    low, high = frame.config.box_low_W, frame.config.box_high_W
    for depth in (frame.depth, frame.depth.astype(np.float32)):
        R_WC, points = _looked_at(frame)
        boxed = boxed_pixels(depth, frame.camera, R_WC, frame.p_WC, low, high)
        points = points_in_world(
            depth.astype(np.float64), frame.camera.rays, R_WC, frame.p_WC
        )
        np.testing.assert_array_equal(boxed, inside_box(points, low, high))
        window = slice(30, 200), slice(7, 411)
        near, near_W = points_in_window(depth, frame.camera, R_WC, frame.p_WC, window)
        np.testing.assert_array_equal(near, depth[window])
        np.testing.assert_array_equal(near_W, points[window])


def test_seen_points_are_the_masks_pixels_one_by_one(draw_frame, rng):
    frame = draw_frame()
    R_WC, points = _looked_at(frame)
    mask = frame.back & (rng.random(frame.back.shape) < 0.8)
    areas = pixel_areas(points, frame.depth, mask, frame.p_WC, 365.0**2)
    window = slice(40, 400), slice(60, 450)
    crop = Crop(window, (0, 0, 0, 0))
    np.testing.assert_array_equal(crop.placed(mask[window], mask.shape), mask)
    near, near_W = points_in_window(frame.depth, frame.camera, R_WC, frame.p_WC, window)
    seen, seen_areas, pixels = seen_points(
        near_W, near, mask[window], frame.p_WC, 365.0**2, crop.corner
    )
    rows, columns = np.nonzero(mask)
    np.testing.assert_array_equal(pixels, np.column_stack([columns, rows]))
    np.testing.assert_array_equal(seen, points[mask])
    np.testing.assert_array_equal(seen_areas, areas[mask])


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("expects", [False, True])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.5, 0.2), (-0.7, 0.0)])
def test_around_the_body_alone_the_same_back_is_found(
    draw_frame, rng, shift, expects, robot
):
    frame = draw_frame(robot=robot, shift=shift)
    # Pixels that fly and that the sensor lost, at edges and elsewhere.
    flies = rng.random(frame.depth.shape) < 0.01
    frame.depth[flies] = rng.uniform(0.7, 1.6, np.count_nonzero(flies))
    frame.depth[rng.random(frame.depth.shape) < 0.01] = np.nan
    _, points = _looked_at(frame)
    expected = Expectation(frame.back, UPRIGHT, (0.8, 1.2)) if expects else None
    boxed = inside_box(points, frame.config.box_low_W, frame.config.box_high_W)
    crop = crop_to_body(boxed, frame.robot_mask, expected and expected.mask)
    rows, columns = np.nonzero(boxed)
    # Two pixels to spare, as if the robot were body too.
    whole = (
        slice(max(rows.min() - 2, 0), rows.max() + 3),
        slice(max(columns.min() - 2, 0), columns.max() + 3),
    )
    skin = skin_mask(frame.colour, frame.config)
    found = []
    for one in (crop, Crop(whole, (0, 0, 0, 0))):
        masks = segment_crop(
            one,
            skin,
            points[one.window],
            boxed,
            frame.robot_mask,
            frame.config,
            expected,
        )
        found.append([one.placed(mask, boxed.shape) for mask in masks])
    np.testing.assert_array_equal(found[0], found[1])


def test_where_nothing_is_in_the_box_there_is_nothing_to_look_at():
    nothing = np.zeros((20, 30), dtype=bool)
    for robot in (nothing, ~nothing):
        crop = crop_to_body(robot & nothing, robot, nothing)
        assert crop.placed(np.zeros((0, 0), dtype=bool), (20, 30)).shape == (20, 30)
        assert crop.corner == (0, 0)
    crop = crop_to_body(~nothing, ~nothing, None)  # all of it is the robot
    assert nothing[crop.window].size == 0
