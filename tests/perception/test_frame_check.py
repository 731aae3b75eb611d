from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from bath_drake.perception.frame_check import (
    FROZEN_FRAMES,
    FrameCheck,
    stamp_is_new,
    with_frame,
    without_new_frame,
)

DEPTH = np.full((4, 5), 1.5, dtype=np.float32)
images = hnp.arrays(
    np.float32,
    (4, 5),
    elements=st.sampled_from([0.0, -1.0, nan, inf, -inf, 0.5, 1.0]).map(np.float32),
)


@given(images)
def test_the_share_is_of_pixels_that_are_not_positive_and_finite(depth):
    with np.errstate(invalid="ignore"):
        good = np.isfinite(depth) & (depth > 0.0)
    assert with_frame(FrameCheck(), depth, 0.0).invalid_share == np.mean(~good)


@given(images)
def test_frames_are_frozen_once_enough_of_them_are_the_same_bit_for_bit(depth):
    check = FrameCheck()
    for k in range(FROZEN_FRAMES + 2):
        check = with_frame(check, depth, float(k))
        assert check.frozen == (k >= FROZEN_FRAMES - 1)
    # One bit of one pixel is another measurement.
    other = depth.copy()
    other.view(np.int32)[3, 4] ^= 1
    assert not with_frame(check, other, 9.0).frozen


def test_what_the_camera_writes_later_is_another_frame():
    depth = DEPTH.copy()
    check = with_frame(with_frame(FrameCheck(), depth, 0.0), depth, 1.0)
    depth[0, 0] += 0.001
    assert with_frame(check, depth, 2.0).repeats == 0


def test_frozen_frames_are_not_told_where_they_are_not_watched():
    check = FrameCheck(stamp=1.0, invalid_share=0.1, repeats=9)
    np.testing.assert_array_equal(check.status(), [0.1, 1.0, 0.0])
    unwatched = check.status(watch_frozen=False)
    np.testing.assert_array_equal(unwatched, [0.1, 0.0, 0.0])


@pytest.mark.parametrize("stamp", [0.9, nan, inf, -inf, 3.0])
def test_a_stamp_that_is_back_or_of_the_future_or_none_is_bad_and_not_kept(stamp):
    check = with_frame(FrameCheck(), DEPTH, 1.0)
    assert not stamp_is_new(check, stamp, 2.0)
    after = without_new_frame(check, stamp)
    assert after.stamp_bad
    assert after.stamp == 1.0
    assert not with_frame(after, DEPTH, 2.0).stamp_bad


def test_the_same_stamp_again_is_no_new_frame_and_well():
    check = with_frame(FrameCheck(), DEPTH, 1.0)
    assert not stamp_is_new(check, 1.0, 2.0)
    after = without_new_frame(check, 1.0)
    np.testing.assert_array_equal(after.status(), check.status())


def test_before_the_first_frame_nothing_is_seen_and_no_stamp_is_bad():
    check = without_new_frame(FrameCheck(), -inf)
    np.testing.assert_array_equal(check.status(), [1.0, 0.0, 0.0])
    assert without_new_frame(FrameCheck(), nan).stamp_bad


@pytest.mark.parametrize("shape", [(0, 3), (3,), (3, 3, 1)])
def test_what_is_no_image_is_refused(shape):
    with pytest.raises(ValueError, match="depth must have shape"):
        with_frame(FrameCheck(), np.zeros(shape, dtype=np.float32), 0.0)
