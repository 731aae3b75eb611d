from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bath_drake.demonstrations.metadata import BodyBox, RecordingMetadata
from bath_drake.demonstrations.processing import (
    POINT_COUNT,
    arc_length_mean,
    canonical_demonstrations,
    resample_by_arc_length,
)
from bath_drake.demonstrations.recording import Recording, read_recording
from bath_drake.errors import DemonstrationError
from bath_drake.resources import models_folder

BOX = BodyBox(np.zeros(3), np.eye(3), np.array([0.4, 0.5]))
T = np.linspace(0.0, 6.0, 301)


def recording(points, name="a", box=None, frame="", t=T):
    metadata = RecordingMetadata(frame=frame, body_box=box)
    return Recording(Path(f"{name}.csv"), t, points, metadata, sha256=name)


def stroke(amplitude=0.08, shift=(0.0, 0.0), z=0.0):
    s = T / T[-1]
    s = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    x, y = 0.28 * s - 0.14, amplitude * np.sin(3.0 * np.pi * s)
    return np.stack([x + shift[0], y + shift[1], np.full_like(x, z)], axis=-1)


@settings(deadline=None)
@given(arrays(np.float64, (30, 2), elements=st.floats(-1.0, 1.0)), st.integers(2, 400))
def test_resampling_keeps_the_ends_and_stays_on_the_path(points, count):
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    if length == 0.0:
        with pytest.raises(ValueError, match="without length"):
            resample_by_arc_length(np.arange(30.0), points, count)
        return
    times, new = resample_by_arc_length(np.arange(30.0), points, count)
    assert new.shape == (count, 2)
    np.testing.assert_array_equal(new[[0, -1]], points[[0, -1]])
    assert (times[0], times[-1]) == (0.0, 29.0)
    assert np.all(np.diff(times) >= 0.0)
    # No chord is longer than its equal share of the arc, up to rounding.
    chords = np.linalg.norm(np.diff(new, axis=0), axis=1)
    assert np.max(chords) <= length / (count - 1) + 1e-12


def test_resampling_a_straight_path_spaces_points_equally_whatever_the_pace():
    s = np.linspace(0.0, 1.0, 40) ** 3
    _, new = resample_by_arc_length(s, np.stack([3 * s, 4 * s], axis=-1), 11)
    chords = np.linalg.norm(np.diff(new, axis=0), axis=1)
    np.testing.assert_allclose(chords, 0.5, rtol=1e-12)


def test_resampling_a_smooth_path_spaces_points_equally():
    (demonstration,), _ = canonical_demonstrations([recording(stroke(), box=BOX)])
    chords = np.linalg.norm(np.diff(demonstration.points, axis=0), axis=1)
    # A chord is shorter than its arc by (curvature x arc)^2 / 24 at most: here the
    # curvature in N is below 20 and the arc 0.0125, so 0.3 %.
    assert np.ptp(chords) < 0.003 * np.max(chords)
    assert demonstration.points.shape == (POINT_COUNT, 2)


def test_too_few_points_are_refused():
    with pytest.raises(ValueError, match="count must be at least 2"):
        resample_by_arc_length(np.arange(3.0), np.eye(3), 1)
    with pytest.raises(ValueError, match="no recordings"):
        canonical_demonstrations([])


def test_with_a_body_box_a_point_of_the_body_keeps_its_canonical_place():
    points = stroke(z=0.03)
    (demonstration,), frame = canonical_demonstrations([recording(points, box=BOX)])
    assert frame.kind == "body_box"
    np.testing.assert_allclose(
        demonstration.raw, points[:, :2] / [0.2, 0.25], atol=1e-15
    )
    np.testing.assert_array_equal(demonstration.goal_offset, np.zeros(2))


def test_the_same_stroke_on_two_bodies_is_one_in_canonical_space():
    large = BodyBox(np.array([1.0, 2.0, 3.0]), np.eye(3), 1.5 * BOX.extents)
    on_large = 1.5 * stroke() + large.centre
    pair, _ = canonical_demonstrations(
        [recording(stroke(), box=BOX), recording(on_large, "b", box=large)]
    )
    # The tolerance of the smoothing scales with the stroke: rounding only.
    np.testing.assert_allclose(pair[0].points, pair[1].points, atol=1e-9)


# A denoising takes 5 ms, but more than 200 ms now and then on a busy machine.
@settings(deadline=None, max_examples=15)
@given(st.integers(0, 2**32 - 1))
@pytest.mark.slow
def test_without_a_box_a_turned_and_moved_recording_gives_the_same_shape(seed):
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    (plain,), _ = canonical_demonstrations([recording(stroke())])
    moved = stroke() @ turn.T + rng.normal(size=3)
    (other,), frame = canonical_demonstrations([recording(moved)])
    assert frame.kind == "path_plane"
    # The axes' signs are a convention, the extents along them are not. The
    # tolerance allows for another cutoff frequency, which box sides decide.
    np.testing.assert_allclose(np.abs(plain.points), np.abs(other.points), atol=2e-3)


def test_planar_recordings_share_one_scale_and_are_not_turned():
    pair, frame = canonical_demonstrations(
        [recording(stroke()[:, :2]), recording(stroke(0.06)[:, :2], "b")]
    )
    assert frame.kind == "planar"
    joint = np.concatenate([d.points for d in pair])
    # The longest side spans 1.6; smoothing moves the far ends by micrometres.
    assert np.ptp(joint, axis=0)[0] == pytest.approx(1.6, abs=1e-3)
    assert pair[1].raw == pytest.approx(frame.to_canonical(stroke(0.06)[:, :2]))


def test_demonstrations_are_moved_to_their_mean_goal_and_say_by_how_much():
    shifts = [(0.004, 0.0), (-0.002, 0.006), (-0.002, -0.006)]
    recordings = [
        recording(stroke(shift=shift), name, box=BOX)
        for shift, name in zip(shifts, "abc", strict=True)
    ]
    demonstrations, frame = canonical_demonstrations(recordings)
    goals = np.array([d.points[-1] for d in demonstrations])
    np.testing.assert_array_equal(goals, goals[[0, 0, 0]])
    offsets = np.array([d.goal_offset for d in demonstrations])
    np.testing.assert_allclose(offsets, np.array(shifts) / frame.scales, atol=1e-12)
    # Moved as a whole: what is left of the offsets is nothing at all.
    for d in demonstrations[1:]:
        np.testing.assert_allclose(d.points, demonstrations[0].points, atol=1e-9)
    assert [d.sha256 for d in demonstrations] == ["a", "b", "c"]


def test_the_mean_of_strokes_up_and_down_is_the_stroke_between():
    recordings = [recording(stroke(a), str(a), box=BOX) for a in (0.07, 0.08, 0.09)]
    demonstrations, _ = canonical_demonstrations(recordings)
    mean = arc_length_mean(demonstrations)
    # Points at equal shares of arc length are not at equal x: second order.
    assert np.max(np.linalg.norm(mean - demonstrations[1].points, axis=1)) < 5e-3
    with pytest.raises(ValueError, match="one number of points"):
        arc_length_mean([])


@pytest.mark.parametrize(
    ("second", "message"),
    [
        (recording(stroke()[:, :2], "b"), "b.csv: 2-D points, but a.csv has 3-D"),
        (recording(stroke(), "b", box=BOX), "a.csv: no body_box, but b.csv has one"),
        (recording(stroke(), "b", frame="camera"), "b.csv: frame 'camera', but a.csv"),
    ],
)
def test_recordings_that_do_not_go_together_are_refused(second, message):
    with pytest.raises(DemonstrationError, match=message):
        canonical_demonstrations([recording(stroke(), frame="robot"), second])


def test_a_stroke_beside_the_body_is_refused():
    beside = recording(stroke(shift=(0.5, 0.0)), box=BOX)
    with pytest.raises(DemonstrationError, match=r"a.csv: the path reaches 3\.2 half"):
        canonical_demonstrations([beside])


def test_the_real_recording_fills_its_own_plane():
    path = models_folder() / "demonstrations" / "iiwa_cleaning_1.csv"
    (demonstration,), frame = canonical_demonstrations([read_recording(path)])
    assert frame.kind == "path_plane"
    assert np.max(np.ptp(demonstration.points, axis=0)) == pytest.approx(1.6, abs=1e-2)
    # It has no tremor to speak of: smoothing stays within 1 % of its size.
    distances = np.linalg.norm(
        demonstration.raw[:, None] - demonstration.points[None], axis=-1
    )
    assert np.max(np.min(distances, axis=1)) < 0.016
