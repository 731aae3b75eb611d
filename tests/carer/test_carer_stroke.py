"""The stroke over time: from rest to rest, with or without something on top."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from bath_drake.carer.config import CarerConfig, RubbingConfig, check_carer
from bath_drake.carer.stroke import demonstrated_stroke, waypoint_stroke
from bath_drake.demonstrations.processing import canonical_demonstrations
from bath_drake.demonstrations.recording import read_recording
from bath_drake.scenario import find_demonstration

CONFIG = CarerConfig(waypoints=[[-0.5, 0.4], [0.5, 0.3], [0.4, -0.5]], pause=0.6)
CIRCLES = RubbingConfig(kind="circles", amplitude=0.1, frequency=1.5)
COORDINATE = st.floats(-1.0, 1.0)


def times(stroke, step=0.01):
    return np.arange(0.0, stroke.duration, step)


def test_the_hand_rests_at_both_ends_and_passes_every_way_point():
    stroke = waypoint_stroke(CONFIG)
    assert stroke.duration == pytest.approx(CONFIG.seconds + 2 * CONFIG.pause)
    for t, point in ((0.0, 0), (0.59, 0), (stroke.duration - 0.5, -1), (99.0, -1)):
        np.testing.assert_allclose(
            stroke.at(np.array([t]))[0], CONFIG.waypoints[point], atol=1e-12
        )
    path = stroke.at(times(stroke))
    for point in CONFIG.waypoints:
        # Samples are 10 ms apart, 0.003 of N at this speed.
        assert np.linalg.norm(path - point, axis=1).min() < 0.004


def test_its_speed_is_one_but_for_start_and_end():
    stroke = waypoint_stroke(CONFIG)
    t = np.linspace(0.6 + 0.2 * 7.0, 0.6 + 0.8 * 7.0, 200)
    speed = np.linalg.norm(np.diff(stroke.at(t), axis=0), axis=1) / np.diff(t)
    # Chords of a curve of 400 samples.
    np.testing.assert_allclose(speed, speed.mean(), rtol=0.02)
    start = stroke.at(np.array([0.6, 0.61]))
    assert np.linalg.norm(np.diff(start, axis=0)) < 1e-4


@given(st.lists(st.tuples(COORDINATE, COORDINATE), min_size=2, max_size=8))
@example([(0.0, 0.0), (0.0, 1.0), (2.225073858507e-311, 0.0)])
def test_a_stroke_never_leaves_the_box_of_its_way_points(points):
    config = CarerConfig(waypoints=[list(p) for p in points])
    try:
        check_carer(config)
    except ValueError:
        return  # two equal points in a row
    path = waypoint_stroke(config).discrete(np.linspace(0.0, 8.0, 300))
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    # Way-points are taken to nine digits.
    assert (path >= low - 2e-9).all()
    assert (path <= high + 2e-9).all()


def test_a_demonstration_keeps_its_own_timing():
    recording = read_recording(find_demonstration("back_sinusoid_1.csv"))
    (demonstration,), _ = canonical_demonstrations([recording])
    stroke = demonstrated_stroke(demonstration, CONFIG)
    np.testing.assert_allclose(
        stroke.at(demonstration.times + CONFIG.pause), demonstration.points, atol=1e-9
    )


def test_circles_have_their_size_and_their_frequency():
    stroke = waypoint_stroke(replace(CONFIG, rubbing=CIRCLES))
    t = times(stroke)
    moving = (t > CONFIG.pause) & (t < stroke.duration - CONFIG.pause)
    periodic = stroke.periodic(t)
    np.testing.assert_allclose(
        np.linalg.norm(periodic[moving], axis=1), CIRCLES.amplitude, atol=1e-12
    )
    np.testing.assert_allclose(periodic[0], 0.0)
    # 1.5 turns a second over 7 s.
    crossings = np.sum(np.diff(np.sign(periodic[moving, 1])) > 0)
    assert crossings == pytest.approx(1.5 * 7.0, abs=1.0)
    np.testing.assert_allclose(stroke.at(t), stroke.discrete(t) + periodic)


def test_scrubbing_goes_to_and_fro_along_its_direction():
    rubbing = RubbingConfig(kind="scrubbing", amplitude=0.2, angle=np.pi / 2)
    periodic = waypoint_stroke(replace(CONFIG, rubbing=rubbing)).periodic(
        np.linspace(0.6, 7.6, 2000)
    )
    np.testing.assert_allclose(periodic[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(
        [periodic[:, 1].min(), periodic[:, 1].max()], [-0.2, 0.2], atol=1e-4
    )


def test_a_wandering_frequency_stays_within_its_share():
    rubbing = RubbingConfig(frequency=1.0, drift=0.2)
    stroke = waypoint_stroke(replace(CONFIG, rubbing=rubbing))
    t = times(stroke)
    frequency = np.gradient(stroke.phase(t), t) / (2.0 * np.pi)
    # Differences over 10 ms of a sine of 7 s.
    assert frequency.min() == pytest.approx(0.8, abs=2e-3)
    assert frequency.max() == pytest.approx(1.2, abs=2e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"waypoints": [[0.0, 0.0]]}, "waypoints: found 1"),
        ({"waypoints": [[0.0, 0.0], [0.0, 1.5]]}, r"waypoints\[1\]: found"),
        ({"waypoints": [[0.0, 0.0], [0.1]]}, r"waypoints\[1\]: found"),
        ({"waypoints": [[0.1, 0.1], [0.1, 0.1]]}, "twice in a row"),
        ({"seconds": float("nan")}, "seconds: found nan"),
        ({"pause": -1.0}, "pause: found"),
        ({"side": "above"}, "side: found 'above', allowed: left or right"),
        ({"swing": 4.0}, "swing: found 4.0, allowed 0 to 3.2"),
        ({"marker_colour": [0.0, 2.0, 0.0]}, "marker_colour: found"),
        ({"marker_radius": 0.2}, "marker_radius: found"),
        ({"rubbing": RubbingConfig(kind="waving")}, "rubbing.kind: found 'waving'"),
        ({"rubbing": RubbingConfig(frequency=0.0)}, "rubbing.frequency: found"),
        ({"rubbing": RubbingConfig(drift=0.9)}, "rubbing.drift: found"),
    ],
)
def test_what_makes_no_carer_is_refused_by_name(change, message):
    with pytest.raises(ValueError, match=message):
        check_carer(replace(CONFIG, **change))
