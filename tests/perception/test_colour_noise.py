import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.perception.colour_noise import (
    ColourNoiseConfig,
    check_colour_noise,
    noisy_colour,
    white_balance,
)

STILL = ColourNoiseConfig(white_balance=0.0)


def grey(level, shape=(100, 120)):
    return np.full((*shape, 3), level, dtype=np.uint8)


def taken(image, config=STILL, **options):
    return noisy_colour(image, config, **({"seed": 2, "frame": 7, "t": 0.0} | options))


def light(level):
    return (level / 255.0) ** 2.2


@pytest.mark.parametrize("level", [60, 128, 200])
def test_the_light_has_the_deviation_of_its_electrons_and_of_the_reading(level):
    found = light(taken(grey(level)).astype(np.float64))
    electrons = STILL.full_well * light(level)
    expected = np.sqrt(electrons + STILL.read**2) / STILL.full_well
    # Rounding to a byte: one step of it in light is this much.
    step = 2.2 * light(level) / level / np.sqrt(12.0)
    # 36,000 samples and a table of 4096 steps of light.
    assert found.std() == pytest.approx(np.hypot(expected, step), rel=0.05)
    # No brighter, no darker; the deviation of the mean is a 190th of the noise's.
    assert found.mean() == pytest.approx(light(level), abs=0.05 * expected)


def test_a_frame_is_the_same_again_and_unlike_all_others():
    image = grey(128)
    first = taken(image)
    np.testing.assert_array_equal(first, taken(image))
    for other in ({"frame": 8}, {"seed": 3}):
        pair = first.ravel(), taken(image, **other).ravel()
        assert abs(np.corrcoef(*pair)[0, 1]) < 0.03  # 36,000 samples: 0.005


def test_the_channels_err_on_their_own():
    noise = taken(grey(128)).reshape(-1, 3).T
    off_diagonal = np.corrcoef(noise)[np.triu_indices(3, 1)]
    assert np.abs(off_diagonal).max() < 0.04  # 12,000 samples: 0.009


@given(st.floats(0.5, 8.0))
def test_exposure_scales_the_light_until_it_is_white(exposure):
    config = ColourNoiseConfig(exposure=exposure, white_balance=0.0, full_well=1e7)
    found = taken(grey(128), config).mean()
    expected = 255.0 * min(exposure * light(128), 1.0) ** (1.0 / 2.2)
    assert found == pytest.approx(expected, abs=1.0)  # a byte's step


def test_the_white_balance_drifts_slowly_and_within_its_share():
    config = ColourNoiseConfig(white_balance=0.1, drift_period=20.0)
    times = np.arange(0.0, 60.0, 1.0 / 30.0)
    gains = np.array([white_balance(config, seed=1, t=t) for t in times])
    np.testing.assert_array_equal(gains[:, 1], 1.0)
    for channel in (0, 2):
        swing = gains[:, channel] - 1.0
        assert 0.09 < np.abs(swing).max() <= 0.1
        # 2 pi a / T a second is the fastest.
        assert np.abs(np.diff(swing)).max() < 1.01 * 0.1 * 2 * np.pi / 20.0 / 30.0
    apart = white_balance(config, seed=2, t=0.0) - gains[0]
    assert np.abs(apart[[0, 2]]).max() > 1e-3


def test_a_fourth_channel_stays_and_the_image_given_is_not_touched():
    image = np.dstack([grey(100), np.full((100, 120), 77, dtype=np.uint8)])
    before = image.copy()
    found = taken(image)
    np.testing.assert_array_equal(image, before)
    assert (found[..., 3] == 77).all()
    assert (found[..., :3] != image[..., :3]).mean() > 0.5


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("exposure", 0.0),
        ("full_well", float("nan")),
        ("read", -1.0),
        ("white_balance", 0.9),
        ("drift_period", 0.0),
    ],
)
def test_what_makes_no_camera_is_refused_by_name(name, value):
    with pytest.raises(ValueError, match=f"{name}: found"):
        check_colour_noise(ColourNoiseConfig(**{name: value}))
    with pytest.raises(ValueError, match="seed and frame"):
        taken(grey(1), seed=-1)
