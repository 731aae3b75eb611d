"""What the simulated sensor does to planes and edges, against its formula."""

import numpy as np
import pytest

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.depth_noise import noisy_depth
from bath_drake.perception.depth_sensor import KINECT_V2, DepthSensor, axial_deviation

CAMERA = PinholeCamera()
MILLIMETRE = 1e-3


def plane(distance, angle=0.0):
    """Depth of a plane through the axis at a distance, turned by an angle, rad."""
    normal = np.array([np.sin(angle), 0.0, -np.cos(angle)])
    with np.errstate(divide="ignore"):
        depth = -np.cos(angle) * distance / (CAMERA.rays @ normal)
    return np.where(depth > 0.0, depth, np.inf).astype(np.float32)


def rays_to_normal(angle):
    normal = np.array([np.sin(angle), 0.0, -np.cos(angle)])
    lengths = np.linalg.norm(CAMERA.rays, axis=-1)
    return np.arccos(np.abs(CAMERA.rays @ normal) / lengths)


def step(near=1.0, far=2.0):
    """The left half of the image nearer than the right one."""
    depth = np.full(CAMERA.shape, far, dtype=np.float32)
    depth[:, : CAMERA.width // 2] = near
    return depth


def measured(depth, **options):
    return noisy_depth(depth, CAMERA, **({"seed": 3, "frame": 5} | options))


@pytest.mark.parametrize("distance", [0.7, 1.2, 2.0, 3.5])
@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 60.0, 75.0])
def test_the_error_has_the_published_deviation(distance, angle_deg):
    angle = np.deg2rad(angle_deg)
    true = plane(distance, angle)
    # A strip, in which depth and angle are nearly constant.
    strip = np.zeros(CAMERA.shape, dtype=bool)
    strip[:, 242:268] = True
    found = measured(true)
    assert (found[strip] > 0.0).all()
    error = (found - true)[strip].astype(np.float64)
    expected = np.hypot(
        axial_deviation(true[strip], rays_to_normal(angle)[strip]),
        MILLIMETRE / np.sqrt(12.0),  # of the rounding
    )
    # 11,000 samples: a deviation is known to 0.7 %; 4 % are six times that.
    assert (error / expected).std() == pytest.approx(1.0, abs=0.04)
    # The rounding's own mean is nothing; the noise's is known to a hundredth.
    assert abs((error / expected).mean()) < 0.04


def test_the_published_figures_are_met_by_hand():
    """1.5 - 0.5 + 0.3 mm at a metre straight on; 0.1 mm (pi/4)^2 / (pi/4)^2 more."""
    np.testing.assert_allclose(
        axial_deviation(np.ones(2), np.array([0.0, np.pi / 4])), [1.3e-3, 1.4e-3]
    )
    clamped = axial_deviation(np.ones(2), np.deg2rad([85.0, 89.9]))
    assert clamped[0] == clamped[1]


def test_every_value_is_a_whole_millimetre():
    found = measured(step())
    # A float32 at 4.5 m is good to 0.5 um.
    np.testing.assert_allclose(found, np.round(found, 3), atol=5e-7)


def test_a_frame_is_the_same_again_and_unlike_all_others():
    depth = plane(1.2)
    first = measured(depth)
    np.testing.assert_array_equal(first, measured(depth))
    for other in ({"frame": 6}, {"seed": 4}, {"seed": 5, "frame": 3}):
        errors = np.stack([first - depth, measured(depth, **other) - depth])
        # 217,000 pixels: independent errors correlate by 0.002.
        assert abs(np.corrcoef(errors.reshape(2, -1))[0, 1]) < 0.01


def test_neighbouring_pixels_have_independent_errors():
    error = measured(plane(1.2)) - np.float32(1.2)
    for shifted in (np.roll(error, 1, axis=0), np.roll(error, 1, axis=1)):
        assert abs(np.corrcoef(error.ravel(), shifted.ravel())[0, 1]) < 0.01


def test_nothing_is_measured_out_of_range():
    for distance in (0.2, 4.8):
        assert not measured(plane(distance)).any()
    found = measured(plane(1.5, np.deg2rad(75.0)))
    seen = found[found > 0.0]
    assert seen.min() >= KINECT_V2.near
    assert seen.max() <= KINECT_V2.far + 1e-6  # float32


@pytest.mark.parametrize("nothing", [0.0, np.inf, np.nan])
def test_no_depth_stays_no_depth(nothing):
    depth = plane(1.2)
    depth[100:200, 100:200] = nothing
    found = measured(depth)
    # The rim may jitter by two pixels.
    assert not found[104:196, 104:196].any()
    assert (found[:90] > 0.0).all()
    assert not measured(np.full(CAMERA.shape, nothing, dtype=np.float32)).any()


def test_grazing_surfaces_return_nothing():
    steep = np.deg2rad(82.0)
    true = plane(1.2, steep)
    beyond = rays_to_normal(steep) > KINECT_V2.grazing + 0.01
    assert beyond.sum() > 10_000
    assert not measured(true)[beyond].any()


def test_pixels_fly_at_a_jump_and_nowhere_else():
    found = measured(step())
    middle = CAMERA.width // 2
    beside = found[:, middle - 1 : middle + 1]
    flying = (beside > 1.05) & (beside < 1.95)
    lost = beside == 0.0
    # 848 pixels: shares are known to 0.017; a tenth of the mixed depths are within
    # 0.05 m of either side.
    assert flying.mean() == pytest.approx(0.9 * KINECT_V2.flying, abs=0.07)
    assert lost.mean() == pytest.approx(KINECT_V2.lost, abs=0.05)
    away = np.delete(found, slice(middle - 5, middle + 5), axis=1)
    sides = np.delete(step(), slice(middle - 5, middle + 5), axis=1)
    assert (away > 0.0).all()
    # Seven deviations of the noise at 2 m.
    assert np.abs(away - sides).max() < 0.012


def test_the_edge_jitters_by_the_lateral_deviation():
    still = DepthSensor(flying=0.0, lost=0.0, lateral=0.0)
    jittery = DepthSensor(flying=0.0, lost=0.0, lateral=0.5)
    middle = CAMERA.width // 2
    near = step() < 1.5
    np.testing.assert_array_equal(measured(step(), sensor=still) < 1.5, near)
    crossed = (measured(step(), sensor=jittery) < 1.5) != near
    # Half a pixel or more, one deviation, to the other side: 16 %; 4 % steeper by 848.
    assert crossed[:, middle - 1 : middle + 1].mean() == pytest.approx(0.159, abs=0.04)
    assert not crossed[:, : middle - 4].any()


def test_a_slope_is_no_edge():
    """Else far floors would fly: 60 degrees at 4 m differ by 19 mm a pixel."""
    true = plane(3.5, np.deg2rad(60.0))
    inside = (true > 1.0) & (true < 4.3)
    error = np.abs(measured(true) - true)[inside]
    deviation = axial_deviation(true[inside], rays_to_normal(np.deg2rad(60.0))[inside])
    # No outliers: the quantiles' table ends at four deviations.
    assert (error < 4.2 * deviation + MILLIMETRE).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: measured(np.ones((4, 4), dtype=np.float32)), "depth must have shape"),
        (lambda: measured(plane(1.0), seed=-1), "seed and frame must be >= 0"),
        (lambda: DepthSensor(near=0.0), "near must be positive"),
        (lambda: DepthSensor(far=0.4), "far must be beyond near"),
        (lambda: DepthSensor(lateral=float("nan")), "lateral must be in"),
        (lambda: DepthSensor(flying=0.9, lost=0.2), "shares of at most 1"),
        (lambda: DepthSensor(grazing=2.0), "grazing must be in"),
    ],
)
def test_what_makes_no_sensor_is_refused_by_name(call, message):
    with pytest.raises(ValueError, match=message):
        call()
