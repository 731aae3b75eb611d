"""Parts of the capture, each on pictures whose truth is known."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_carer import (
    CAMERA,
    DISTANCE,
    GREEN,
    RADIUS,
    Scene,
    contact,
    draw,
    write_recording,
)
from scipy.spatial.transform import Rotation

from bath_drake.demonstrations.capture.body import MAX_POINTS
from bath_drake.demonstrations.capture.clean_plate import clean_plate
from bath_drake.demonstrations.capture.contact import Skin
from bath_drake.demonstrations.capture.marker import find_blobs, locate
from bath_drake.demonstrations.capture.marker_colour import (
    colour_of_pixels,
    colour_of_rgb,
    detect_colour,
)
from bath_drake.demonstrations.capture.marker_search import find_marker
from bath_drake.demonstrations.capture.options import CaptureOptions
from bath_drake.demonstrations.capture.rigid_tracking import (
    AT_REST,
    RigidSurface,
    TrackedPose,
    track,
)
from bath_drake.demonstrations.capture.symmetry import sagittal_plane, symmetric_map
from bath_drake.demonstrations.capture.view import View
from bath_drake.demonstrations.rgbd.folder import open_rgbd
from bath_drake.errors import DemonstrationError

UP = np.array([0.0, -1.0, 0.0])
MARKER = colour_of_rgb(GREEN, "here")
BARE = Scene(marker=None)


def view():
    return View(CAMERA, np.array([-0.6, -0.6, 0.6]), np.array([0.6, 0.6, 1.4]), UP)


def seen_back(scene, rng):
    colour, depth = draw(scene, rng)
    return colour, depth, view().back(colour, depth)


def centre_of_marker(x, y):
    point, normal = contact(x, y)
    return point + RADIUS * normal + [0.0, 0.0, DISTANCE]


def test_a_turned_and_shifted_body_is_followed_behind_an_arm(rng):
    colour, depth, back = seen_back(BARE, rng)
    skin = view().surface(depth, view().skin(colour, depth, back))
    assert len(skin.points) < 4 * MAX_POINTS
    turn, shift = np.array([0.02, 0.05, -0.02]), np.array([0.006, -0.004, 0.008])
    moved = draw(replace(BARE, turn=turn, shift=shift, hand=(0.05, 0.05)), rng)[1]
    found = track(skin, moved, CAMERA, AT_REST)
    axis = np.array([0.0, 0.0, DISTANCE])
    R = Rotation.from_rotvec(turn).as_matrix()
    # Six numbers out of some thousand points of 1 mm noise and 7 mm pixels.
    np.testing.assert_allclose(found.to_camera(axis), axis + shift, atol=2e-3)
    np.testing.assert_allclose(found.R, R, atol=0.015)
    assert 0.5 < found.share < 1.0
    back_again = found.from_camera(found.to_camera(skin.points))
    np.testing.assert_allclose(back_again, skin.points, atol=1e-12)


def test_an_empty_picture_holds_no_body(rng):
    colour, depth, back = seen_back(BARE, rng)
    skin = view().surface(depth, view().skin(colour, depth, back))
    assert track(skin, np.zeros(CAMERA.shape), CAMERA, AT_REST).share == 0.0


def test_the_clean_plate_shows_the_body_without_what_moves_before_it(rng):
    places = [(x, y) for x in (-0.08, 0.0, 0.08) for y in (-0.12, 0.0, 0.12)]
    frames = [(*draw(replace(BARE, hand=place), rng), AT_REST) for place in places]
    plate = clean_plate(
        frames, CAMERA, len(frames), np.array([-1, -1, 0.3]), np.array([1, 1, 1.5])
    )
    colour, depth = draw(BARE)
    skin = view().back(colour, depth)
    assert np.mean(plate.depth[skin] > 0.0) > 0.99
    # The mean of eight or nine pictures of 1 mm noise; at the rim a few mix.
    error = np.abs(plate.depth - depth)[skin & (plate.depth > 0.0)]
    assert np.quantile(error, 0.99) < 3e-3
    assert np.all(plate.seen <= len(frames))


def test_under_a_hand_that_lingers_the_plate_shows_the_skin_all_the_same(rng):
    free, hand = replace(BARE, hand=(0.1, 0.15)), replace(BARE, hand=(-0.05, 0.0))
    scenes = [free] * 4 + [hand] * 16
    frames = [(*draw(scene, rng), AT_REST) for scene in scenes]
    low, high = np.array([-1, -1, 0.3]), np.array([1, 1, 1.5])
    plate = clean_plate(frames, CAMERA, len(frames), low, high)
    _, there = draw(BARE)
    _, before = draw(hand)
    hidden = (before > 0.0) & (before < there - 0.03) & view().back(*draw(BARE))
    assert hidden.sum() > 50
    # At its own edge a hand's pixels mix with the skin's.
    right = np.abs(plate.depth - there)[hidden] < 4e-3
    assert right.mean() > 0.9


def test_a_pose_that_is_not_at_rest_is_undone_in_the_plate(rng):
    shift = np.array([0.02, 0.0, 0.0])
    pose = TrackedPose(np.eye(3), shift, 1.0, 0.0)
    frames = [(*draw(BARE, rng), AT_REST)] * 2 + [
        (*draw(replace(BARE, shift=shift), rng), pose)
    ] * 2
    low, high = np.array([-1, -1, 0.3]), np.array([1, 1, 1.5])
    plate = clean_plate(frames, CAMERA, 4, low, high)
    _, depth = draw(BARE)
    middle = np.s_[60:100, 80:112]
    np.testing.assert_allclose(plate.depth[middle], depth[middle], atol=3e-3)


@pytest.mark.parametrize("place", [(0.0, 0.0), (-0.08, 0.1), (0.11, -0.1)])
def test_the_ball_is_found_where_it_is(place, rng):
    colour, depth = draw(Scene(marker=place), rng)
    blobs = find_blobs(colour, depth, MARKER, CAMERA)
    sight = locate(blobs, depth, CAMERA, RADIUS, None)
    # 18 pixels of 1 mm noise at 7 mm a pixel.
    np.testing.assert_allclose(sight.p_C, centre_of_marker(*place), atol=3e-3)


def test_two_balls_are_ambiguous_unless_one_is_where_the_marker_just_was(rng):
    colour, depth = draw(Scene(marker=(-0.08, 0.0), second=(0.08, 0.0)), rng)
    blobs = find_blobs(colour, depth, MARKER, CAMERA)
    assert locate(blobs, depth, CAMERA, RADIUS, None).reason == "ambiguous"
    truth = centre_of_marker(-0.08, 0.0)
    sight = locate(blobs, depth, CAMERA, RADIUS, truth + 0.02)
    np.testing.assert_allclose(sight.p_C, truth, atol=3e-3)


def test_no_ball_is_hidden_and_a_ball_without_depth_says_so(rng):
    colour, depth = draw(BARE, rng)
    assert find_blobs(colour, depth, MARKER, CAMERA) == []
    assert locate([], depth, CAMERA, RADIUS, None).reason == "hidden"
    colour, depth = draw(Scene(), rng)
    blind = np.zeros_like(depth)
    blobs = find_blobs(colour, blind, MARKER, CAMERA)
    assert locate(blobs, blind, CAMERA, RADIUS, None).reason == "no depth"


def test_a_wall_of_the_markers_colour_is_no_marker(rng):
    colour, depth = draw(Scene(marker=(0.05, 0.05), wall=GREEN), rng)
    blobs = find_blobs(colour, depth, MARKER, CAMERA)
    sight = locate(blobs, depth, CAMERA, RADIUS, None)
    np.testing.assert_allclose(sight.p_C, centre_of_marker(0.05, 0.05), atol=3e-3)


@pytest.mark.parametrize("rgb", [(20, 190, 40), (230, 20, 40), (30, 60, 220)])
def test_a_colour_is_known_again_in_another_light(rgb):
    marker = colour_of_rgb(rgb, "here")
    shades = np.array([[np.array(rgb) * light for light in (0.4, 0.7, 1.0)]])
    assert marker.mask(shades.astype(np.uint8)).all()
    others = {(20, 190, 40), (230, 20, 40), (30, 60, 220), (205, 150, 120)} - {rgb}
    assert not marker.mask(np.array([list(others)], dtype=np.uint8)).any()


def test_a_box_around_the_marker_may_hold_its_surroundings():
    pixels = np.array([GREEN] * 6 + [(200, 150, 120)] * 5, dtype=np.uint8)
    assert colour_of_pixels(pixels, "here").rgb == GREEN


def test_a_pale_colour_is_refused():
    with pytest.raises(DemonstrationError, match=r"--marker-colour: .* too pale"):
        colour_of_rgb((200, 200, 210), "--marker-colour")


def test_a_marker_that_nobody_described_is_the_one_vivid_blob(rng):
    pictures = [draw(Scene(marker=(0.02 * k, 0.0)), rng)[0] for k in range(4)]
    found = detect_colour(pictures, (5.0, 500.0), "here")
    assert found.mask(np.array([[GREEN]], dtype=np.uint8)).all()
    bare = [draw(BARE, rng)[0]] * 4
    with pytest.raises(DemonstrationError, match=r"no vivid blob .*--marker-colour"):
        detect_colour(bare, (5.0, 500.0), "here")


def test_the_foot_of_a_ball_on_a_round_back_is_its_contact(rng):
    colour, depth, back = seen_back(BARE, rng)
    skin = Skin(view().points_C(depth)[view().skin(colour, depth, back)])
    for place in [(0.0, 0.0), (0.09, 0.05), (-0.09, -0.1)]:
        foot, height = skin.under(centre_of_marker(*place))
        truth = contact(*place)[0] + [0.0, 0.0, DISTANCE]
        # A quadric of some forty points of 1 mm noise.
        np.testing.assert_allclose(foot, truth, atol=4e-3)
        assert height == pytest.approx(RADIUS, abs=3e-3)
    assert Skin(np.zeros((3, 3))).under(np.ones(3)) is None


@pytest.mark.parametrize("turn", [-0.25, 0.0, 0.2])
def test_a_back_seen_from_one_side_has_the_box_of_the_whole(turn, rng):
    scene = replace(BARE, turn=np.array([0.0, turn, 0.0]))
    colour, depth, back = seen_back(scene, rng)
    guess = view().first_map(depth, back)
    skin = view().surface(depth, view().skin(colour, depth, back))
    plane = sagittal_plane(skin, depth, view(), guess)
    assert plane is not None
    n, d = plane
    R = Rotation.from_rotvec(scene.turn).as_matrix()
    spine = R @ contact(0.0, 0.0)[0] + [0.0, 0.0, DISTANCE]
    # A pixel, 7 mm, where what is seen alone is up to 20 mm and 6 degrees off.
    assert n @ R[:, 0] > np.cos(np.radians(2.5))
    assert d == pytest.approx(n @ spine, abs=7.5e-3)
    if turn:
        assert abs(d - n @ spine) < 0.5 * abs(guess.plane_from_world(spine)[0])
    fitted = symmetric_map(depth, back, view(), n, d)
    front = seen_back(BARE, rng)
    middle = np.array([1.0, 0.0, 0.0]), 0.0
    whole = symmetric_map(*front[1:], view(), *middle)
    # A pixel is 7 mm, and a flank is one more or less.
    np.testing.assert_allclose(fitted.half_extents, whole.half_extents, atol=9e-3)


def test_an_arbitrary_surface_has_no_plane_of_symmetry(rng):
    colour, depth, back = seen_back(BARE, rng)
    guess = view().first_map(depth, back)
    skin = view().surface(depth, view().skin(colour, depth, back))
    aside = RigidSurface(skin.points - np.array([0.0, 0.0, 0.3]), skin.normals)
    assert sagittal_plane(aside, depth, view(), guess) is None


def test_a_named_colour_is_learned_again_in_the_light_of_the_recording(tmp_path):
    pale = (95, 190, 105)  # the named green with a lamp on it
    folder = write_recording(tmp_path, frames=6, colour=pale)
    recording = open_rgbd(folder)
    frames = {k: (f.colour, f.depth) for k, f in enumerate(recording)}
    options = CaptureOptions(marker_colour=GREEN)
    colour, radius, places = find_marker(recording, options, frames)
    np.testing.assert_allclose(colour.rgb, pale, atol=3)
    # A ball of five pixels' width.
    assert radius == pytest.approx(RADIUS, abs=4e-3)
    assert places.shape == (6, 3)
