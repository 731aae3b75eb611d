import numpy as np
import pytest

from bath_drake.report.point_cloud import Viewpoint, draw_points, shade


@pytest.fixture
def view() -> Viewpoint:
    eye, target = np.array([0.0, -2.0, 0.0]), np.zeros(3)
    return Viewpoint(eye, target, np.array([0.0, 0.0, 1.0]), 81, 61, 0.5)


def test_the_target_is_in_the_middle_and_up_is_up(view):
    places, depth = view.project(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]]))
    np.testing.assert_allclose(places[0], [40.5, 30.5], atol=1e-12)
    np.testing.assert_allclose(depth, 2.0)
    assert places[1, 1] < places[0, 1]


def test_a_near_point_hides_a_far_one_whatever_the_order(view):
    points = np.array([[0.0, -0.5, 0.0], [0.0, 0.5, 0.0]])
    colours = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for order in ([0, 1], [1, 0]):
        picture = draw_points(view, points[order], colours[order], size=0.03)
        np.testing.assert_array_equal(picture[30, 40], [1.0, 0.0, 0.0])


def test_points_behind_the_eye_or_not_finite_are_not_drawn(view):
    points = np.array([[0.0, -3.0, 0.0], [np.nan, 0.0, 0.0]])
    picture = draw_points(view, points, np.zeros((2, 3)), size=0.05)
    np.testing.assert_array_equal(picture, np.ones((61, 81, 3)))


def test_what_faces_the_lamp_is_brighter():
    colours = np.full((2, 3), 0.5)
    normals = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    lit = shade(colours, normals, np.array([0.0, 0.0, 2.0]))
    assert (lit[0] > lit[1]).all()
