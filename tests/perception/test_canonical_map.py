import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.canonical import (
    CanonicalMap,
    apply_homography,
    edges_by_level,
    fit_canonical_map,
    principal_frame,
)
from bath_drake.perception.quantiles import trimmed_range

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture
def rng():
    return np.random.default_rng(2)


@pytest.fixture
def canonical_map():
    R_WP = Rotation.from_euler("xyz", [1.2, 0.1, -0.3]).as_matrix()
    return CanonicalMap(R_WP, np.array([0.7, -0.1, 0.8]), np.array([0.17, 0.25]))


def _back(rng, half=(0.17, 0.25), turn=0.0, count=20_000):
    """Points of a bulging plate that faces -y of W; x is the person's right."""
    x, y = (rng.uniform(-1, 1, (count, 2)) * half).T
    z = 0.03 - 0.5 * x**2 - 0.2 * y**2
    c, s = np.cos(turn), np.sin(turn)
    return np.column_stack([c * x - s * y, -z, s * x + c * y + 1.0])


def test_world_and_canonical_are_inverse_on_the_plane(canonical_map, rng):
    p_N = rng.uniform(-1.5, 1.5, (50, 2))
    p_W = canonical_map.world_from_canonical(p_N)
    # Rounding at one metre.
    np.testing.assert_allclose(canonical_map.canonical_from_world(p_W), p_N, atol=1e-13)


def test_height_over_the_plane_does_not_change_the_canonical_point(canonical_map, rng):
    p_N = rng.uniform(-1, 1, (20, 2))
    lifted = canonical_map.world_from_canonical(p_N) + 0.3 * canonical_map.normal_W
    back = canonical_map.canonical_from_world(lifted)
    np.testing.assert_allclose(back, p_N, atol=1e-13)


def test_the_homography_draws_where_the_camera_sees(canonical_map, rng):
    camera = PinholeCamera()
    R_WC = Rotation.from_euler("xyz", [-2.0, 0.1, 0.2]).as_matrix()
    p_WC = canonical_map.p_WP - 1.4 * R_WC[:, 2]
    p_N = rng.uniform(-1, 1, (50, 2))
    p_C = (canonical_map.world_from_canonical(p_N) - p_WC) @ R_WC
    T_IN = canonical_map.image_transform(camera, R_WC, p_WC)
    # Rounding at 500 pixels.
    np.testing.assert_allclose(
        apply_homography(T_IN, p_N), camera.project(p_C), atol=1e-9
    )


@pytest.mark.parametrize("angle", [0.0, 0.4, -1.3, 2.0])
def test_an_ellipse_maps_to_the_ellipse_of_its_points(canonical_map, angle):
    ellipse = np.array([0.03, -0.05, 0.06, 0.02, angle])
    x, y, a, b, t = canonical_map.ellipse_to_canonical(ellipse)
    turn = np.linspace(0, 2 * np.pi, 40)
    c, s = np.cos(angle), np.sin(angle)
    on = np.column_stack([0.06 * np.cos(turn), 0.02 * np.sin(turn)])
    on = (ellipse[:2] + on @ [[c, s], [-s, c]]) / canonical_map.half_extents
    c, s = np.cos(t), np.sin(t)
    u, v = ((on - [x, y]) @ [[c, -s], [s, c]]).T
    # Exact but for rounding.
    np.testing.assert_allclose((u / a) ** 2 + (v / b) ** 2, 1.0, atol=1e-12)


def test_ellipses_go_there_and_back(canonical_map):
    ellipse = np.array([0.03, -0.05, 0.06, 0.02, 0.4])
    there = canonical_map.ellipse_to_canonical(ellipse)
    back = canonical_map.ellipse_from_canonical(there)
    back[4] = (back[4] - 0.4 + np.pi / 2) % np.pi - np.pi / 2 + 0.4  # an axis, no arrow
    np.testing.assert_allclose(back, ellipse, atol=1e-14)


def test_the_axes_are_right_up_and_out(rng):
    fitted = fit_canonical_map(_back(rng), UP, np.array([0.0, -1.3, 1.5]))
    # 20,000 random points: their moments are good to 1 %, angles to 0.5 degrees.
    np.testing.assert_allclose(
        fitted.R_WP, np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]), atol=0.01
    )
    # 98 % of a uniform plate.
    np.testing.assert_allclose(
        fitted.half_extents, 0.98 * np.array([0.17, 0.25]), rtol=0.01
    )


def test_the_map_moves_with_the_body(rng):
    points, eye = _back(rng), np.array([0.0, -1.3, 1.5])
    rest = fit_canonical_map(points, UP, eye)
    turn = Rotation.from_euler("xyz", [4, 5, -4], degrees=True).as_matrix()
    moved = fit_canonical_map(points @ turn.T + 0.02, UP, eye)
    # The same points: only the first guess differs, the midline's two rounds make
    # up for it to a hundredth of a degree and a tenth of a millimetre.
    np.testing.assert_allclose(moved.R_WP, turn @ rest.R_WP, atol=1e-3)
    np.testing.assert_allclose(moved.p_WP, turn @ rest.p_WP + 0.02, atol=2e-4)
    np.testing.assert_allclose(moved.half_extents, rest.half_extents, atol=2e-4)


@pytest.mark.parametrize("turn", [-0.08, 0.0, 0.08])
@pytest.mark.parametrize("height", [0.17, 0.2, 0.25])
def test_even_a_square_back_keeps_its_upright(rng, turn, height):
    points = _back(rng, half=(0.17, height), turn=turn)
    fitted = fit_canonical_map(points, UP, np.array([0.0, -1.3, 1.5]))
    y = fitted.R_WP[:, 1]
    # Half a degree: the edges of a random plate are ragged by millimetres.
    assert np.arctan2(-y[0], y[2]) == pytest.approx(turn, abs=0.01)


def test_one_odd_shoulder_does_not_turn_the_upright(rng):
    points = _back(rng)
    bump = _back(rng, half=(0.03, 0.04), count=500)
    bump += np.array([0.2, 0.0, 0.15])
    both = np.concatenate([points, bump])
    eye = np.array([0.0, -1.3, 1.5])
    y = fit_canonical_map(both, UP, eye).R_WP[:, 1]
    # Principal axes alone would turn by more than a degree.
    assert abs(np.arctan2(-y[0], y[2])) < np.radians(0.5)


def test_weights_undo_an_uneven_density(rng):
    points = _back(rng)
    crowd = points[points[:, 0] > 0.0]
    uneven = np.concatenate([points, crowd, crowd])
    weights = np.where(uneven[:, 0] > 0.0, 1.0 / 3.0, 1.0)
    eye = np.array([0.0, -1.3, 1.5])
    even = fit_canonical_map(points, UP, eye)
    weighted = fit_canonical_map(uneven, UP, eye, weights)
    # The same surface: quantiles differ by the gap between neighbouring points.
    np.testing.assert_allclose(weighted.p_WP, even.p_WP, atol=2e-4)
    np.testing.assert_allclose(weighted.half_extents, even.half_extents, atol=2e-4)


def test_too_few_points_and_points_on_a_line_are_refused():
    eye = np.array([0.0, -1.0, 0.0])
    with pytest.raises(ValueError, match="at least 50 points"):
        fit_canonical_map(np.zeros((3, 3)), UP, eye)
    line = np.linspace(0, 1, 100)[:, None] * np.ones(3)
    with pytest.raises(ValueError, match="line"):
        fit_canonical_map(line, UP, eye)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("R_WP", 2 * np.eye(3)),
        ("R_WP", np.diag([1.0, 1.0, -1.0])),
        ("p_WP", np.array([0.0, np.nan, 0.0])),
        ("half_extents", np.array([0.1, 0.0])),
        ("half_extents", np.ones(3)),
    ],
)
def test_impossible_maps_are_refused(name, value):
    good = {"R_WP": np.eye(3), "p_WP": np.zeros(3), "half_extents": np.ones(2)}
    with pytest.raises(ValueError, match=name):
        CanonicalMap(**{**good, name: value})


def _plain_frame(points, weights, eye):
    """The principal frame in lines of numpy."""
    weights = weights / weights.sum()
    mean = weights @ points
    offsets = points - mean
    variances, axes = np.linalg.eigh((offsets * weights[:, None]).T @ offsets)
    z = axes[:, 0] * np.sign(axes[:, 0] @ (eye - mean))
    up = UP - (UP @ z) * z
    up /= np.linalg.norm(up)
    right = np.cross(up, z)
    angle = np.arctan2(-axes[:, 2] @ right, axes[:, 2] @ up)
    angle = (angle + np.pi / 4) % (np.pi / 2) - np.pi / 4
    share = np.clip((variances[2] / variances[1] - 1.15) / 0.35, 0.0, 1.0)
    angle *= share**2 * (3.0 - 2.0 * share)
    y = np.cos(angle) * up - np.sin(angle) * right
    for _ in range(2):
        x = np.cross(y, z)
        along, across = offsets @ y, offsets @ x
        low, high = np.quantile(along, [0.03, 0.97])
        inner = (along >= low) & (along <= high)
        _, left, right = edges_by_level(along[inner], across[inner])
        middle = np.where(right > left, (left + right) / 2.0, np.nan)
        i, j = np.triu_indices(len(middle), 1)
        slopes = (middle[j] - middle[i]) / (0.01 * (j - i))
        slopes = slopes[np.isfinite(slopes) & (0.01 * (j - i) >= 0.1)]
        angle = np.arctan(np.median(slopes))
        y = np.cos(angle) * y + np.sin(angle) * x
    return mean, np.column_stack([np.cross(y, z), y, z])


@pytest.mark.parametrize("half", [(0.17, 0.25), (0.2, 0.22), (0.15, 0.3)])
@pytest.mark.parametrize("turn", [-0.2, 0.0, 0.1])
def test_the_compiled_frame_is_numpys_but_for_rounding(rng, half, turn):
    points, eye = _back(rng, half, turn), np.array([0.1, -1.4, 1.2])
    weights = rng.uniform(0.5, 1.5, len(points))
    mean, R_WP = principal_frame(points, UP, eye, weights)
    expected_mean, expected = _plain_frame(points, weights, eye)
    # Sums of 20 000 numbers of order one, in another order.
    np.testing.assert_allclose(mean, expected_mean, atol=1e-12)
    np.testing.assert_allclose(R_WP, expected, atol=1e-12)
    found = fit_canonical_map(points, UP, eye, weights)
    p_P = (points - mean) @ R_WP
    ends = np.array([trimmed_range(p_P[:, k], weights, 0.01) for k in (0, 1)])
    np.testing.assert_allclose(
        found.half_extents, (ends[:, 1] - ends[:, 0]) / 2.0, atol=1e-12
    )
