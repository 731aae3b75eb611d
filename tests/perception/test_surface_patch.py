import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.surface import (
    desired_nozzle_pose,
    fit_path,
    fit_surface,
)


@pytest.fixture
def rng():
    return np.random.default_rng(3)


@pytest.fixture
def body():
    """A map whose plane is z = 0 of its own frame, put somewhere in W."""
    R_WP = Rotation.from_euler("xyz", [1.0, 0.2, -0.4]).as_matrix()
    return CanonicalMap(R_WP, np.array([0.7, 0.1, 0.8]), np.array([0.17, 0.25]))


def _points(body, height, rng, count=25_000, noise=0.0):
    x, y = (rng.uniform(-1, 1, (count, 2)) * body.half_extents).T
    z = height(x, y) + noise * rng.standard_normal(count)
    return body.p_WP + np.column_stack([x, y, z]) @ body.R_WP.T


def _ball(radius):
    return lambda x, y: np.sqrt(radius**2 - x**2 - y**2) - radius


@pytest.mark.parametrize("p_NQ", [(0.0, 0.0), (0.5, 0.3), (-0.7, -0.6)])
def test_a_balls_point_normal_and_curvature(body, rng, p_NQ):
    radius = 0.4
    patch = fit_surface(_points(body, _ball(radius), rng), body, np.array(p_NQ))
    p_P = np.append(np.array(p_NQ) * body.half_extents, 0.0)
    p_P[2] = _ball(radius)(*p_P[:2])
    centre = np.array([0.0, 0.0, -radius])
    assert patch.valid
    # A quadric leaves terms of fourth order: r^4 / (8 R^3), a micrometre.
    np.testing.assert_allclose(patch.p_WS, body.p_WP + body.R_WP @ p_P, atol=3e-6)
    normal = body.R_WP @ (p_P - centre) / radius
    np.testing.assert_allclose(patch.normal_W, normal, atol=1e-3)
    np.testing.assert_allclose(patch.curvatures, 1 / radius, rtol=0.03)


def test_a_hollow_bends_inward(body, rng):
    patch = fit_surface(_points(body, lambda x, y: 2 * x**2, rng), body, np.zeros(2))
    # z = 2 x^2 has curvature 4 across and none along; outward is positive.
    np.testing.assert_allclose(patch.curvatures, [0.0, -4.0], atol=0.05)


def test_the_point_is_on_the_line_through_the_canonical_point(body, rng):
    points = _points(body, lambda x, y: 0.8 * x - 0.5 * y, rng)
    p_NQ = np.array([0.3, -0.4])
    patch = fit_surface(points, body, p_NQ)
    np.testing.assert_allclose(body.canonical_from_world(patch.p_WS), p_NQ, atol=1e-9)


def test_the_sensors_noise_is_averaged_out(body, rng):
    # 1.5 mm of noise at one point in 14 mm^2, as of a camera at 1.3 m.
    errors, angles = [], []
    for _ in range(50):
        points = _points(body, _ball(0.4), rng, count=12_000, noise=1.5e-3)
        patch = fit_surface(points, body, np.zeros(2))
        errors.append((patch.p_WS - body.p_WP) @ body.normal_W)
        angles.append(np.arccos(min(patch.normal_W @ body.normal_W, 1.0)))
    # Standard error of the height: noise times sqrt(3 / n), n = 200 points.
    assert np.std(errors) < 3e-4
    assert np.degrees(np.median(angles)) < 1.5
    assert patch.rms == pytest.approx(1.5e-3, rel=0.3)


def test_the_edge_of_the_back_is_no_patch(body, rng):
    points = _points(body, _ball(0.4), rng)
    assert not fit_surface(points, body, np.array([1.05, 0.0])).valid


def test_a_hole_is_bridged_by_a_wider_radius(body, rng):
    points = _points(body, _ball(0.4), rng)
    away = np.linalg.norm(points - body.p_WP, axis=1) > 0.0295
    patch = fit_surface(points[away], body, np.zeros(2), radius=0.03)
    assert patch.valid
    assert patch.radius > 0.03
    # r^4 / (8 R^3) at 60 mm: 25 micrometres.
    np.testing.assert_allclose(patch.p_WS, body.p_WP, atol=5e-5)


def test_quality_is_how_often_the_normal_is_within_three_degrees(body, rng):
    # Waves of skin that no quadric follows, 60 mm long and half a millimetre high,
    # and noise: the crests' curvature changes by some 5 per metre within a radius.
    def wavy(x, y):
        return _ball(0.4)(x, y) + 5e-4 * np.sin(2 * np.pi * (x + 0.5 * y) / 0.06)

    good, predicted = [], []
    for _ in range(20):
        points = _points(body, wavy, rng, count=3000, noise=4e-3)
        p_NQ = rng.uniform(-0.8, 0.8, (20, 2))
        for p_N, patch in zip(p_NQ, fit_path(points, body, p_NQ), strict=True):
            if not patch.valid:
                continue
            x, y = p_N * body.half_extents
            step = 1e-6
            slopes = [
                (wavy(x + step, y) - wavy(x - step, y)) / (2 * step),
                (wavy(x, y + step) - wavy(x, y - step)) / (2 * step),
            ]
            normal = body.R_WP @ np.array([-slopes[0], -slopes[1], 1.0])
            cosine = patch.normal_W @ normal / np.linalg.norm(normal)
            good.append(np.arccos(min(cosine, 1.0)) < np.deg2rad(3.0))
            predicted.append(patch.quality)
    # Some 400 fits: the share's own standard error is 0.025; the rest is the model.
    assert 0.4 < np.mean(predicted) < 0.95
    assert np.mean(good) == pytest.approx(np.mean(predicted), abs=0.12)


def test_quality_falls_with_noise_and_towards_an_edge(body, rng):
    def mean_quality(noise, p_N):
        clouds = [_points(body, _ball(0.4), rng, 8000, noise) for _ in range(8)]
        return np.mean([fit_surface(c, body, np.array(p_N)).quality for c in clouds])

    middle = [mean_quality(noise, (0.0, 0.0)) for noise in (1e-4, 4e-3, 2e-2)]
    assert middle[0] > 0.99  # a tenth of a millimetre is nothing
    assert middle[0] > middle[1] > middle[2]
    assert mean_quality(4e-3, (0.9, 0.0)) < middle[1]


def test_a_patch_that_cannot_be_trusted_is_none(body, rng):
    points = _points(body, _ball(0.4), rng, count=2500, noise=2e-2)
    patch = fit_surface(points, body, np.zeros(2), radius=0.02)
    assert not patch.valid
    assert patch.quality == 0.0
    np.testing.assert_array_equal(patch.normal_W, body.normal_W)


def test_too_few_points_are_no_patch(body, rng):
    patch = fit_surface(_points(body, _ball(0.4), rng, count=200), body, np.zeros(2))
    assert not patch.valid
    assert patch.count < 40
    np.testing.assert_array_equal(patch.normal_W, body.normal_W)


def test_no_points_are_no_patch(body):
    assert not fit_surface(np.zeros((0, 3)), body, np.zeros(2)).valid


@pytest.mark.parametrize("radius", [0.0, -1.0, 0.1, np.nan])
def test_impossible_radii_are_refused(body, radius):
    with pytest.raises(ValueError, match="radius"):
        fit_surface(np.zeros((0, 3)), body, np.zeros(2), radius)


def test_a_point_that_is_none_is_refused(body):
    with pytest.raises(ValueError, match="p_NQ"):
        fit_surface(np.zeros((0, 3)), body, np.array([0.0, np.nan]))


@pytest.mark.parametrize("roll", [0.0, 0.7, -2.0])
def test_the_nozzle_stands_off_square_to_the_skin(body, rng, roll):
    patch = fit_surface(_points(body, _ball(0.4), rng), body, np.array([0.4, -0.3]))
    R_WE, p_WE = desired_nozzle_pose(patch, 0.06, body, roll)
    np.testing.assert_allclose(R_WE.T @ R_WE, np.eye(3), atol=1e-12)
    assert np.linalg.det(R_WE) > 0.0
    np.testing.assert_allclose(R_WE[:, 2], -patch.normal_W, atol=1e-12)
    # Along its own axis the nozzle meets the skin at the stand-off.
    np.testing.assert_allclose(p_WE + 0.06 * R_WE[:, 2], patch.p_WS, atol=1e-12)
    up = body.R_WP[:, 1]
    level = up - (up @ R_WE[:, 2]) * R_WE[:, 2]
    cosine = level @ R_WE[:, 0] / np.linalg.norm(level)
    assert cosine == pytest.approx(np.cos(roll), abs=1e-12)


def test_a_path_is_fitted_as_its_points_are_one_by_one(body, rng):
    points = _points(body, lambda x, y: x * y + 0.5 * x**2, rng, 6000, noise=1e-3)
    # Beyond the square there is nothing to fit; at its edges one side is missing.
    p_NQ = rng.uniform(-1.2, 1.2, (60, 2))
    valid = 0
    for p_N, patch in zip(p_NQ, fit_path(points, body, p_NQ), strict=True):
        single = fit_surface(points, body, p_N)
        valid += patch.valid
        assert (patch.valid, patch.count) == (single.valid, single.count)
        assert patch.radius == single.radius
        # The points are summed in another order.
        np.testing.assert_allclose(patch.p_WS, single.p_WS, atol=1e-10)
        np.testing.assert_allclose(patch.normal_W, single.normal_W, atol=1e-8)
        np.testing.assert_allclose(patch.curvatures, single.curvatures, atol=1e-6)
        np.testing.assert_allclose(patch.rms, single.rms, atol=1e-9)
        assert patch.quality == pytest.approx(single.quality, abs=1e-6)
    assert 10 < valid < 60


def test_without_points_a_path_has_no_valid_patch(body):
    patches = fit_path(np.zeros((0, 3)), body, np.zeros((3, 2)))
    assert [patch.valid for patch in patches] == [False] * 3
    np.testing.assert_array_equal(patches[0].normal_W, body.normal_W)


@pytest.mark.parametrize("p_NQ", [np.zeros(2), np.full((3, 2), np.nan)])
def test_a_path_of_no_points_of_the_plane_is_refused(body, p_NQ):
    with pytest.raises(ValueError, match="p_NQ must be finite with shape"):
        fit_path(np.zeros((5, 3)), body, p_NQ)
