"""The slabs of skin that can be touched, against the true skin."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bath_drake.patient.motion import Bend, MotionConfig, person_pose, trunk_bend
from bath_drake.patient.people import load_person, shipped_people
from bath_drake.patient.segment_motion import segment_positions, yaw_pitch_roll
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.skin_segments import DEPTH, STEP, segmented_skin
from bath_drake.patient.touched_skin import touched_skin_error

# As in wash_contact.yaml, without the slow beginning.
MOTION = MotionConfig(
    flexion_amplitude=0.0698,
    side_bend_amplitude=0.0524,
    spine_twist_amplitude=0.1047,
    chest_amplitude=0.006,
    ramp=0.0,
)


@pytest.fixture(scope="module")
def person():
    return load_person("f_thin")


@pytest.fixture(scope="module")
def skin(person):
    return segmented_skin(person, bends=True)


def volumes(segment):
    a, b, c, d = (segment.nodes[segment.tetrahedra[:, k]] for k in range(4))
    return np.einsum("ni,ni->n", np.cross(b - a, c - a), d - a) / 6.0


def test_the_tetrahedra_fill_each_slab(skin):
    for segment in skin.segments:
        # A slanted prism's volume is that of the cell times the depth: two layers.
        cells = len(segment.triangles) / 2
        assert volumes(segment).min() > 0.0
        assert volumes(segment).sum() == pytest.approx(cells * STEP**2 * 2 * DEPTH)


def test_neighbours_agree_on_the_faces_between_tetrahedra(skin):
    for segment in skin.segments:
        t = segment.tetrahedra
        faces = np.concatenate([t[:, [1, 2, 3]], t[:, [0, 2, 3]], t[:, [0, 1, 3]]])
        faces = np.sort(np.concatenate([faces, t[:, :3]]), axis=1)
        _, shared = np.unique(faces, axis=0, return_counts=True)
        assert shared.max() == 2
        # The boundary of one piece without holes in it closes.
        outside = np.unique(faces, axis=0)[shared == 1]
        edges = np.sort(
            np.concatenate([outside[:, [0, 1]], outside[:, [1, 2]], outside[:, [0, 2]]])
        )
        edges = np.sort(edges, axis=1)
        assert (np.unique(edges, axis=0, return_counts=True)[1] % 2 == 0).all()


def test_at_rest_the_slabs_are_the_true_skin(person, skin):
    true = TrueSkin(person)
    R, p = skin.poses(Bend())
    np.testing.assert_allclose(R, np.tile(np.eye(3), (len(R), 1, 1)), atol=1e-9)
    for k, segment in enumerate(skin.segments):
        on_skin = segment.nodes[: len(segment.nodes) // 3] + p[k]
        # Open3D computes in single precision.
        assert true.nearest(on_skin)[0].max() < 1e-5


def test_neighbours_overlap_by_one_step(skin):
    for low, high in zip(skin.segments, skin.segments[1:], strict=False):
        above = low.nodes[: len(low.nodes) // 3] + low.centre
        below = high.nodes[: len(high.nodes) // 3] + high.centre
        common = (np.abs(above[:, None] - below).max(axis=2) < 1e-9).any(axis=1)
        width = len(np.unique(above[:, 0].round(6)))
        # Two rows of nodes, but for those past the body's outline.
        assert width < common.sum() <= 2 * width


@pytest.mark.parametrize("name", ["f_thin", "m_heavy"])
def test_bent_they_are_within_two_millimetres_of_the_true_skin(name):
    person = load_person(name)
    skin, true = segmented_skin(person, bends=True), TrueSkin(person)
    # Along a line across the back, at times without a pattern.
    p_N = np.column_stack([np.linspace(-0.6, 0.6, 9), np.linspace(-0.3, 0.3, 9)])
    places, _ = true.under(p_N)
    time = np.array([1.0, 4.3, 5.9, 8.1, 11.7, 15.2, 19.9, 23.3, 31.0])
    mean, most = touched_skin_error(person, skin, MOTION, time, places)
    assert mean.max() < 2e-3
    assert most.max() < 6e-3


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", shipped_people())
def test_everywhere_on_every_back_they_are_as_near_in_the_mean(name):
    person = load_person(name)
    skin, true = segmented_skin(person, bends=True), TrueSkin(person)
    x, y = np.meshgrid(np.linspace(-0.7, 0.7, 8), np.linspace(-0.5, 0.5, 8))
    places, _ = true.under(np.column_stack([x.ravel(), y.ravel()]))
    time = 0.71 * np.arange(1, len(places) + 1)
    mean, _ = touched_skin_error(person, skin, MOTION, time, places)
    assert mean.mean() < 2e-3


def test_a_person_that_does_not_bend_has_still_slabs(person):
    stiff = segmented_skin(person, bends=False)
    R, p = stiff.poses(Bend(flexion=0.3))
    np.testing.assert_array_equal(R[0], np.eye(3))
    np.testing.assert_array_equal(p, stiff.centres)


def test_yaw_pitch_and_roll_turn_back_into_the_rotation():
    angles = np.random.default_rng(2).uniform(-1.2, 1.2, (50, 3))
    R = Rotation.from_euler("ZYX", angles).as_matrix()
    np.testing.assert_allclose(yaw_pitch_roll(R), angles, atol=1e-12)


def pose(t):
    return person_pose(
        t, MOTION, np.array([0.75, 0.1, 0.2]), 1.4, np.zeros(3), np.array([0.0, 1, 0])
    )


def test_the_joints_put_the_slabs_where_the_person_has_them(skin):
    t, start = 7.3, pose(0.0)
    q = segment_positions(skin, MOTION, t, start=start, person=pose(t)).reshape(-1, 6)
    R_MS, p_MS = skin.poses(trunk_bend(t, MOTION))
    R_WM, p_WM = pose(t)
    for k, joints in enumerate(q):
        p = start[1] + start[0] @ (skin.centres[k] + joints[:3])
        R = start[0] @ Rotation.from_euler("ZYX", joints[3:]).as_matrix()
        np.testing.assert_allclose(p, p_WM + R_WM @ p_MS[k], atol=1e-12)
        np.testing.assert_allclose(R, R_WM @ R_MS[k], atol=1e-12)


def test_at_the_start_all_joints_are_at_zero(skin):
    q = segment_positions(skin, MOTION, 0.0, start=pose(0.0), person=pose(0.0))
    np.testing.assert_allclose(q, 0.0, atol=1e-9)
