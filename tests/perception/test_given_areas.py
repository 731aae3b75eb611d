"""Areas that the carer gives are enclosed with their margin, and checked."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.given_areas import check_polygon, given_areas

BODY = CanonicalMap(np.eye(3), np.array([0.7, 0.0, 0.9]), np.array([0.17, 0.25]))
SQUARE = [[0.1, 0.1], [0.3, 0.1], [0.3, 0.3], [0.1, 0.3]]


def level(ellipse, points):
    """One on an ellipse (5,), less inside it."""
    x, y, a, b, angle = ellipse
    c, s = np.cos(angle), np.sin(angle)
    local = (points - [x, y]) @ np.array([[c, -s], [s, c]]) / [a, b]
    return (local**2).sum(axis=-1)


@given(
    st.floats(-0.8, 0.8), st.floats(-0.8, 0.8), st.floats(0.0, 0.04), st.integers(3, 9)
)
def test_every_place_within_the_margin_of_a_polygon_is_inside(x, y, margin, corners):
    turns = 2.0 * np.pi * np.arange(corners) / corners
    radii = np.where(np.arange(corners) % 2, 0.05, 0.2)  # a star, not convex
    polygon = check_polygon(
        np.column_stack([x + radii * np.cos(turns), y + radii * np.sin(turns)])
    )
    (ellipse,) = given_areas([polygon], BODY, margin).theta
    share = np.linspace(0.0, 1.0, 20)[:, None, None]
    sides = (1.0 - share) * polygon + share * np.roll(polygon, -1, axis=0)
    around = 2.0 * np.pi * np.arange(12) / 12
    disc = margin * np.column_stack([np.cos(around), np.sin(around)])
    near = sides[..., None, :] + disc / BODY.half_extents
    # The hull goes through single precision.
    assert level(ellipse, near).max() <= 1.0 + 1e-5


def test_a_squares_ellipse_is_no_larger_than_it_must_be():
    (ellipse,) = given_areas([check_polygon(SQUARE)], BODY, 0.0).theta
    np.testing.assert_allclose(ellipse[:2], [0.2, 0.2], atol=1e-3)
    # Of the least one the area is pi / 2 that of the square; Khachiyan stops at 1 %.
    assert np.pi * ellipse[2] * ellipse[3] == pytest.approx(
        np.pi / 2.0 * 0.04, rel=0.02
    )


def test_areas_that_meet_are_one_and_others_stay_apart():
    square = check_polygon(SQUARE)
    polygons = [square, square + np.array([0.15, 0.0]), square - np.array([0.9, 0.5])]
    areas = given_areas(polygons, BODY, 0.01)
    assert len(areas) == 2
    for polygon in polygons:
        assert min(level(row, polygon).max() for row in areas.theta) <= 1.0 + 1e-5
    assert len(given_areas([], BODY, 0.01)) == 0


@pytest.mark.parametrize(
    ("corners", "message"),
    [
        ([], "at least 3 corners"),
        ([[0.0, 0.0], [1.0, 0.0]], "at least 3 corners"),
        ([[0.0], [1.0], [2.0]], "at least 3 corners"),
        ([[0.0, 0.0], [1.0, "x"], [0.0, 1.0]], "at least 3 corners"),
        ([[0.0, 0.0], [1.6, 0.0], [0.0, 1.0]], r"corner 2: found \[1.6, 0.0\]"),
        ([[0.0, 0.0], [0.5, float("nan")], [0.0, 1.0]], "corner 2"),
        ([[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]], "around an area"),
        ([[0.0, 0.0], [0.4, 0.5], [0.5, 0.0], [0.0, 0.3]], "sides 2 and 4|1 and 3"),
    ],
)
def test_what_is_no_polygon_is_refused_with_what_is_allowed(corners, message):
    with pytest.raises(ValueError, match=message):
        check_polygon(corners)
