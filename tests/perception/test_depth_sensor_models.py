"""The cameras one can buy: their numbers, and the errors that follow from them."""

from dataclasses import replace

import numpy as np
import pytest

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.depth_noise import noisy_depth
from bath_drake.perception.depth_sensor import (
    CAMERA_MODELS,
    KINECT_V2,
    REALSENSE_D435,
    DepthSensor,
    axial_deviation,
)

SMALL = PinholeCamera(200, 150, 424.0, 424.0, 100.0, 75.0)
STEP = 1e-3 / np.sqrt(12.0)  # deviation of rounding to millimetres, m


def flat(depth, camera=SMALL):
    return np.full(camera.shape, depth, dtype=np.float32)


def errors(depth, sensor, frames=8, camera=SMALL):
    true = flat(depth, camera)
    return np.stack(
        [
            noisy_depth(true, camera, seed=1, frame=k, sensor=sensor) - true
            for k in range(frames)
        ]
    ).astype(np.float64)


@pytest.mark.parametrize("name", CAMERA_MODELS)
@pytest.mark.parametrize("depth", [0.6, 1.2, 2.5])
def test_every_model_errs_by_its_formula(name, depth):
    sensor = CAMERA_MODELS[name].sensor
    # Straight ahead: the angle to the ray is small over so narrow an image.
    found = errors(depth, sensor)[:, 60:90, 80:120].std()
    expected = np.hypot(
        axial_deviation(np.array(depth), np.array(0.0), sensor, SMALL.fx), STEP
    )
    # 9,600 samples; where 25 share a grain, some 400, whose deviation is known to 4 %.
    assert found == pytest.approx(expected, rel=0.12 if sensor.grain > 1 else 0.03)


def test_the_error_of_stereo_grows_with_the_square_of_the_depth():
    near, far = (
        axial_deviation(np.array(z), np.array(0.0), REALSENSE_D435, 424.0)
        for z in (1.0, 2.0)
    )
    # 0.08 pixels of 21.2 at a metre.
    assert near == pytest.approx(0.08 / 21.2, rel=1e-12)
    assert far == pytest.approx(4.0 * near, rel=1e-12)
    longer = axial_deviation(np.array(1.0), np.array(0.0), REALSENSE_D435, 848.0)
    assert longer == pytest.approx(near / 2.0, rel=1e-12)


def test_microsofts_bound_on_the_random_error_holds_over_the_whole_range():
    sensor = CAMERA_MODELS["azure_kinect"].sensor
    z = np.linspace(sensor.near, sensor.far, 40)
    assert axial_deviation(z, np.zeros(40), sensor).max() < 17e-3


def test_grain_makes_neighbours_alike_and_leaves_the_deviation():
    def neighbours(grain, apart):
        error = errors(1.2, replace(REALSENSE_D435, grain=grain))[:, 20:-20, 20:-20]
        pair = error[..., :-apart].ravel(), error[..., apart:].ravel()
        return np.corrcoef(*pair)[0, 1], error.std()

    alike, deviation = neighbours(5, 1)
    # A box of five moved by one keeps four fifths; 0.05 is two grains' worth of noise.
    assert alike == pytest.approx(0.8, abs=0.05)
    assert abs(neighbours(5, 5)[0]) < 0.06
    own, single = neighbours(1, 1)
    assert abs(own) < 0.01
    assert deviation == pytest.approx(single, rel=0.06)


def test_what_the_right_eye_does_not_see_has_no_depth():
    near, far = 1.0, 2.0
    depth = flat(far)
    depth[:, 100:150] = near
    still = replace(REALSENSE_D435, disparity=0.0, lateral=0.0, flying=0.0, lost=0.0)
    seen = noisy_depth(depth, SMALL, seed=0, frame=0, sensor=still) > 0.0
    # f B (1 / near - 1 / far) columns left of what is near.
    shadow = SMALL.fx * REALSENSE_D435.baseline * (1.0 / near - 1.0 / far)
    hidden = np.flatnonzero(~seen[75])
    assert len(hidden) == pytest.approx(shadow, abs=1.0)
    assert hidden.max() == 99
    # With one eye, or none further right, nothing is hidden.
    alone = replace(still, baseline=0.0)
    assert (noisy_depth(depth, SMALL, seed=0, frame=0, sensor=alone) > 0.0).all()


@pytest.mark.parametrize("name", CAMERA_MODELS)
def test_every_model_sees_its_published_field_of_view(name):
    camera = CAMERA_MODELS[name].camera
    published = {
        "kinect_v2": (70.6, 60.0),
        "azure_kinect": (65.0, 59.5),  # 75 x 65 with its lens's distortion
        "realsense_d435": (90.0, 59.0),
    }[name]
    for size, focal, degrees in zip(
        (camera.width, camera.height), (camera.fx, camera.fy), published, strict=True
    ):
        found = np.rad2deg(2.0 * np.arctan(size / (2.0 * focal)))
        assert found == pytest.approx(degrees, abs=1.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"axial": (-1.0, 0.0, 0.0)}, "axial must not be negative"),
        ({"axial": (float("nan"), 0.0, 0.0)}, "axial must not be negative"),
        ({"tilt": -0.1}, "tilt must be >= 0"),
        ({"disparity": 0.1}, "disparity needs a baseline"),
        ({"grain": 2}, "grain must be odd"),
        ({"grain": 99}, "grain must be odd"),
    ],
)
def test_numbers_that_make_no_sensor_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        replace(KINECT_V2, **change)


def test_the_defaults_are_the_kinect():
    assert DepthSensor() == KINECT_V2
