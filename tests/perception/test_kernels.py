"""The compiled loops do what a line of numpy or OpenCV does, only sooner."""

import copy

import cv2
import numpy as np
import pytest

from bath_drake.perception import morphology
from bath_drake.perception.canonical import (
    CanonicalMap,
    edges_by_level,
)
from bath_drake.perception.offsets import less
from bath_drake.perception.pixels import (
    behind_jump,
    column_steps,
    facing_along,
    normals_at,
    pixel_normals,
)
from bath_drake.perception.principal import LEVEL
from bath_drake.perception.quantiles import median, ordered, trimmed_range
from bath_drake.perception.skin_colour import (
    BRIGHT_SHARE,
    DARK_SHARE,
    LEAST_BRIGHTNESS,
    OFF_COLOUR,
    SIGMAS,
    off_skin,
    skin_deviations,
)
from bath_drake.perception.surface import fit_surface

# Sums of some ten thousand numbers of order one, in another order.
ROUNDING = 1e-10


@pytest.fixture
def rng():
    return np.random.default_rng(6)


@pytest.mark.parametrize("radius", [0.5, 1.0, 1.5, 2.0, 3.0])
@pytest.mark.parametrize("density", [0.0, 0.01, 0.5, 0.99, 1.0])
def test_small_discs_grow_and_shrink_masks_as_distances_do(rng, radius, density):
    mask = rng.random((60, 70)) < density
    inside = cv2.distanceTransform(mask.view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
    assert (morphology.erode(mask, radius) == (inside > radius)).all()
    outside = cv2.distanceTransform(
        (~mask).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5
    )
    # OpenCV's distance to nothing at all is large, but no number to rely on.
    expected = (outside <= radius) & mask.any()
    assert (morphology.dilate(mask, radius) == expected).all()


@pytest.mark.parametrize("trim", [0.001, 0.01, 0.2])
@pytest.mark.parametrize("count", [2, 50, 5000])
def testtrimmed_ranges_are_the_weighted_quantiles(rng, count, trim):
    values, weights = rng.standard_normal(count), rng.random(count)
    values[0] = 40.0  # far out: most bins of a histogram are empty
    order = np.argsort(values)
    share = weights[order] / weights.sum()
    centred = np.cumsum(share) - 0.5 * share
    expected = np.interp((trim, 1.0 - trim), centred, values[order])
    assert np.abs(trimmed_range(values, weights, trim) - expected).max() < ROUNDING


def test_atrimmed_range_of_one_value_is_that_value():
    assert trimmed_range(np.full(9, 0.3), np.ones(9), 0.01) == (0.3, 0.3)


@pytest.mark.parametrize("count", [1, 2, 7, 1000])
def test_places_and_medians_are_those_of_the_order(rng, count):
    values = rng.standard_normal(count)
    values[0] = 40.0  # far out: most bins of a histogram are empty
    places = rng.integers(0, count, 4)
    np.testing.assert_array_equal(ordered(values, places), np.sort(values)[places])
    assert median(values) == np.median(values)
    assert (ordered(np.full(count, 0.3), places) == 0.3).all()


def test_edges_are_the_least_and_greatest_of_each_level(rng):
    along, across = rng.random(400) * 0.5, rng.standard_normal(400)
    along[(along > 0.2) & (along < 0.25)] = 0.4  # some levels without points
    level, left, right = edges_by_level(along, across)
    assert (np.abs((along - along.min()) / LEVEL - level - 0.5) <= 0.5 + 1e-9).all()
    for k in range(len(left)):
        inside = across[level == k]
        assert left[k] == inside.min(initial=np.inf)
        assert right[k] == inside.max(initial=-np.inf)


def test_steps_and_normals_are_those_of_neighbours(rng):
    rows, columns = np.mgrid[:12, :15].astype(np.float64)
    points = np.stack([columns, rows, 0.3 * columns - 0.2 * rows], axis=-1)
    mask = rng.random((12, 15)) < 0.7
    pairs = int((mask[:, 1:] & mask[:, :-1]).sum())
    assert column_steps(points, mask) == pytest.approx(np.full(pairs, np.hypot(1, 0.3)))
    normals = pixel_normals(points, np.ones((12, 15), dtype=bool), 2)
    expected = np.array([0.3, -0.2, -1.0]) / np.sqrt(1.13)
    assert np.abs(normals - expected).max() < ROUNDING


def test_skin_brightness_is_the_least_squares_quadratic(draw_frame):
    frame = draw_frame()
    shade = np.linspace(0.8, 1.0, frame.colour.shape[1])[:, None]
    frame.colour = (frame.colour * shade).astype(np.uint8)
    observation = frame.observe()
    value = observation.colours.max(axis=1).astype(np.float64)
    x, y = observation.pixels.T / 100.0
    basis = np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    around = basis @ np.linalg.lstsq(basis, value, rcond=None)[0]
    assert around.min() > LEAST_BRIGHTNESS
    found = skin_deviations(observation)[:, 0]
    assert np.abs(found - np.log(value / around)).max() < ROUNDING


@pytest.mark.parametrize("count", [1, 2, 101, 1000])
@pytest.mark.parametrize("noise", [0.0, 0.02, 0.0242, 0.1])
def test_off_skin_is_beyond_the_limit_or_the_medians_noise(rng, noise, count):
    deviations = noise * rng.standard_normal((count, 3))
    spread = np.median(np.abs(deviations[:, 1:]), axis=0) / 0.674
    limits = np.maximum(OFF_COLOUR, SIGMAS * spread)
    expected = (np.abs(deviations[:, 1:]) >= limits).any(axis=1)
    expected |= deviations[:, 0] <= np.log(DARK_SHARE)
    expected |= deviations[:, 0] >= np.log(BRIGHT_SHARE)
    np.testing.assert_array_equal(off_skin(deviations), expected)


def test_a_quadric_without_noise_is_found_to_rounding(rng):
    x, y = rng.uniform(-0.05, 0.05, (2, 3000))
    height = 2.0 * x * x - 1.0 * x * y + 0.5 * y * y
    patch = fit_surface(
        np.column_stack([x, y, height]),
        CanonicalMap(np.eye(3), np.zeros(3), np.ones(2)),
        np.zeros(2),
    )
    # Level at the origin: there the curvatures are the Hessian's eigenvalues.
    expected = -np.linalg.eigvalsh([[4.0, -1.0], [-1.0, 1.0]])
    # The plane fitted first leans a little, so the residual is not all rounding.
    assert np.abs(patch.normal_W - [0.0, 0.0, 1.0]).max() < 1e-3
    assert patch.curvatures == pytest.approx(expected, rel=0.02)
    assert patch.rms < 1e-5


def test_observations_are_shared_and_cannot_change(draw_frame):
    observation = draw_frame().observe()
    assert copy.deepcopy(observation) is observation
    with pytest.raises(ValueError, match="read-only"):
        observation.points_W[0, 0] = 1.0


def _slope(rows=12, columns=20):
    """A plane of points 4 mm apart that runs away to the right, and a mask of it."""
    v, u = np.mgrid[0:rows, 0:columns].astype(np.float64)
    return np.stack([4e-3 * u, 4e-3 * v, 4e-3 * u], axis=-1), np.full(v.shape, True)


@pytest.mark.parametrize("lost", [0, 1, 2, 3])
def test_jumps_are_looked_for_past_a_lost_pixel_or_two(lost):
    points, mask = _slope()
    points[:, 8 : 8 + lost] = np.nan
    mask[:, 8 : 8 + lost] = False
    jumps = behind_jump(points, mask, 0.02)
    assert jumps.any() == (lost > 2)
    # Where there is a real jump it is found all the same.
    points[:, 8 + lost :, 2] += 0.5
    jumps = behind_jump(points, mask, 0.02)
    assert jumps[:, 7].all()
    assert jumps[:, 8 + lost].all()
    assert not jumps[:, :7].any()


@pytest.mark.parametrize("limit", [-0.5, 0.0, 0.7, 0.95])
def test_pixels_facing_an_axis_are_those_whose_normals_do(rng, limit):
    points, _ = _slope(30, 40)
    points += 5e-4 * rng.standard_normal(points.shape)
    mask = rng.random(points.shape[:2]) < 0.9
    axis = np.array([0.6, 0.0, -0.8])
    expected = mask & (pixel_normals(points, mask, 3) @ axis > limit)
    some = np.flatnonzero(mask)[::4]
    whole = pixel_normals(points, mask, 3).reshape(-1, 3)
    np.testing.assert_array_equal(normals_at(points, mask, 3, some), whole[some])
    seen = np.linalg.norm(pixel_normals(points, mask, 3), axis=-1) > 0.0
    facing = facing_along(points, mask, 3, axis, limit)
    np.testing.assert_array_equal(facing[seen], expected[seen])


def test_specks_are_filled_and_larger_holes_are_not():
    mask = np.full((20, 20), True)
    mask[4, 4] = mask[10, 3:7] = False
    large = np.zeros_like(mask)
    large[8:12, 12:16] = True
    filled = morphology.without_specks(mask & ~large, 4)
    np.testing.assert_array_equal(filled, ~large)


@pytest.mark.parametrize("radius", [1.0, 2.0, 3.0, 7.0])
def test_masks_are_near_where_one_grown_meets_the_other(rng, radius):
    met = []
    for _ in range(40):
        mask, other = np.zeros((2, 30, 40), dtype=bool)
        mask[rng.integers(30), rng.integers(40)] = True
        other[rng.integers(30), rng.integers(40)] = True
        met.append(morphology.near(mask, other, radius))
        assert met[-1] == (morphology.dilate(mask, radius) & other).any()
        assert not morphology.near(mask & ~mask, other, radius)
    assert 0 < sum(met) < len(met) or radius < 3.0


@pytest.mark.parametrize("shape", [(3,), (0, 3), (50, 3), (4, 5, 3)])
def test_points_less_one_are_numpys(rng, shape):
    points, origin = rng.standard_normal(shape), rng.standard_normal(3)
    np.testing.assert_array_equal(less(points, origin), points - origin)
    np.testing.assert_array_equal(
        less(points[..., ::-1], origin), points[..., ::-1] - origin
    )
