import numpy as np
import pytest

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.self_filter import robot_silhouette

EYE, ORIGIN = np.eye(3), np.zeros(3)
CUBE = np.array(np.meshgrid(*[[-0.1, 0.1]] * 3)).reshape(3, -1).T
AHEAD = np.array([0.0, 0.0, 1.1])


@pytest.fixture
def rng():
    return np.random.default_rng(1)


def _inside(hull, rng, count=500):
    weights = rng.dirichlet(np.full(len(hull), 0.3), count)
    return weights @ hull


@pytest.mark.parametrize("centre", [(0, 0, 1.2), (0.5, -0.4, 1.0), (0.7, 0.0, 0.9)])
def test_every_point_of_a_link_lies_in_its_silhouette(centre, rng):
    camera = PinholeCamera()
    hull = CUBE + np.array(centre)
    mask = robot_silhouette([hull], camera, EYE, ORIGIN, dilation_px=1)
    pixels = np.floor(camera.project(_inside(hull, rng))).astype(int)
    seen = ((pixels >= 0) & (pixels < [camera.width, camera.height])).all(axis=1)
    columns, rows = pixels[seen].T
    assert mask[rows, columns].all()


def test_the_silhouette_is_not_much_larger_than_the_link():
    camera = PinholeCamera()
    mask = robot_silhouette([CUBE + AHEAD], camera, EYE, ORIGIN, dilation_px=0)
    # The near face, 0.2 m at 1 m, is all there is to see.
    assert mask.sum() == pytest.approx((0.2 * camera.fx) ** 2, rel=0.05)


def test_a_link_behind_the_camera_is_not_seen():
    camera = PinholeCamera()
    mask = robot_silhouette([CUBE - AHEAD], camera, EYE, ORIGIN)
    assert not mask.any()


def test_a_link_that_reaches_past_the_camera_is_cut_not_lost(rng):
    camera = PinholeCamera()
    hull = CUBE * [1.0, 1.0, 10.0] + [0.3, 0.0, 0.2]  # z from -0.8 to 1.2
    mask = robot_silhouette([hull], camera, EYE, ORIGIN, dilation_px=1)
    points = _inside(hull, rng)
    points = points[points[:, 2] > 0.3]
    pixels = np.floor(camera.project(points)).astype(int)
    seen = ((pixels >= 0) & (pixels < [camera.width, camera.height])).all(axis=1)
    columns, rows = pixels[seen].T
    assert seen.sum() > 50
    assert mask[rows, columns].all()


def test_no_links_no_silhouette():
    assert not robot_silhouette([], PinholeCamera(), EYE, ORIGIN).any()


def test_dilation_grows_the_silhouette():
    hull = CUBE + AHEAD
    thin = robot_silhouette([hull], PinholeCamera(), EYE, ORIGIN, dilation_px=0)
    thick = robot_silhouette([hull], PinholeCamera(), EYE, ORIGIN, dilation_px=4)
    assert (thick | thin).sum() == thick.sum() > thin.sum()
