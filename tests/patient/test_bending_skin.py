"""A skin that bends: as the rig says, smooth, and at rest exactly the mesh."""

import shutil

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.errors import ScenarioError
from bath_drake.patient.bending import BendingSkin, body_transforms
from bath_drake.patient.motion import Bend, MotionConfig, trunk_bend
from bath_drake.patient.people import LABEL_BACK, load_person, shipped_people
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.skin_parts import follow
from bath_drake.resources import models_folder

BENDING = MotionConfig(
    flexion_amplitude=0.14,
    side_bend_amplitude=0.087,
    spine_twist_amplitude=0.21,
    chest_amplitude=0.006,
)
angles = st.floats(-0.3, 0.3)


@pytest.fixture(scope="module", params=shipped_people())
def person(request):
    return load_person(request.param)


@pytest.fixture(scope="module")
def skin(person):
    return bending_skin(person)


def heights(person):
    back = person.labels == LABEL_BACK
    z = person.vertices[back, 2]
    return back, (z - z.min()) / np.ptp(z)


def test_at_rest_the_skin_is_the_mesh(person, skin):
    # Sums of six terms of order one.
    np.testing.assert_allclose(skin.points(Bend()), person.vertices, atol=1e-14)


def test_the_pelvis_stays_while_the_shoulders_go(person, skin):
    moved = np.linalg.norm(skin.points(Bend(flexion=0.14)) - person.vertices, axis=1)
    back, height = heights(person)
    assert moved[person.vertices[:, 2] < 0.05].max() < 1e-9  # the feet
    # Half a metre of back, 8 degrees spread over it: some 4 cm at its top.
    assert np.median(moved[back][height > 0.9]) > 0.025
    assert np.median(moved[back][height < 0.1]) < 0.01


@pytest.mark.parametrize(
    ("bend", "axis", "sign"),
    [
        (Bend(flexion=0.1), 1, -1.0),  # forwards is -y
        (Bend(side_bend=0.1), 0, 1.0),  # the person's left is +x
    ],
)
def test_the_shoulders_go_where_the_bend_says(person, skin, bend, axis, sign):
    back, height = heights(person)
    moved = (skin.points(bend) - person.vertices)[back][height > 0.9]
    assert sign * np.median(moved[:, axis]) > 0.015


def test_a_twist_to_the_left_takes_the_right_shoulder_forward(person, skin):
    back, height = heights(person)
    x = person.vertices[back, 0]
    moved = (skin.points(Bend(twist=0.2)) - person.vertices)[back]
    right = (height > 0.7) & (x < x.mean() - 0.08)
    assert np.median(moved[right, 1]) < -0.005


def test_the_breath_lifts_the_back_along_its_normals_and_no_arm(person, skin):
    moved = skin.points(Bend(swell=0.006)) - person.vertices
    _, _, normals = TrueSkin(person).nearest(person.vertices)
    along = (moved * normals).sum(axis=1)
    back, height = heights(person)
    assert np.median(along[back][(height > 0.4) & (height < 0.8)]) > 0.004
    assert along.max() <= 0.006 + 1e-9
    hands = np.abs(person.vertices[:, 0]) > np.abs(person.vertices[back, 0]).max() + 0.1
    assert not hands.any() or np.abs(moved[hands]).max() < 1e-3


@given(flexion=angles, side=angles, twist=angles)
def test_each_body_of_the_spine_turns_about_a_point_it_shares_with_the_last(
    flexion, side, twist
):
    pivots = np.array([[0.0, 0.0, 0.1], [0.0, 0.03, 0.2], [0.01, 0.02, 0.3]])
    R, p = body_transforms(pivots, Bend(flexion=flexion, side_bend=side, twist=twist))
    for k, pivot in enumerate(pivots):
        np.testing.assert_allclose(
            R[k] @ pivot + p[k], R[k + 1] @ pivot + p[k + 1], atol=1e-14
        )
        np.testing.assert_allclose(R[k + 1] @ R[k + 1].T, np.eye(3), atol=1e-14)


@given(weights=st.lists(st.floats(0.0, 1.0), min_size=3, max_size=3), twist=angles)
def test_what_follows_three_points_stays_between_them(weights, twist):
    # Sums below a hundredth make no weights worth the name.
    total = sum(weights)
    if total < 0.01:
        return
    rng = np.random.default_rng(3)
    shares = rng.dirichlet(np.ones(3), 4)
    moments = shares[..., None] * rng.normal(size=(4, 1, 3))
    skin = BendingSkin(
        rng.normal(size=(2, 3)), shares, moments, rng.normal(size=(4, 3))
    )
    w = np.array(weights)[None] / total
    bend = Bend(twist=twist, swell=0.01)
    corners = np.array([[0, 1, 3]])
    follower = skin.follower(corners, w)
    # The blend is linear but for the swelling, which is a product of two of the sums.
    still = Bend(twist=twist)
    expected = w[0] @ skin.points(still)[corners[0]]
    np.testing.assert_allclose(follower.points(still)[0], expected, atol=1e-12)
    assert np.isfinite(follower.points(bend)).all()


def test_points_on_the_skin_stay_on_it_while_it_bends(person, skin):
    true = TrueSkin(person)
    back = np.flatnonzero(person.labels == LABEL_BACK)[::40]
    _, _, normals = true.nearest(person.vertices[back])
    lifted = person.vertices[back] + 0.001 * normals
    bend = trunk_bend(6.0, BENDING)
    now = TrueSkin(person, skin.points(bend))
    distance, _, _ = now.nearest(follow(skin, true, lifted).points(bend))
    # Laid 1 mm above it; the blend stretches little.
    np.testing.assert_allclose(distance, 0.001, atol=2e-4)


def test_the_bend_starts_from_rest_and_reaches_its_amplitudes():
    assert trunk_bend(0.0, BENDING) == Bend()
    bends = [trunk_bend(t, BENDING) for t in np.arange(10.0, 200.0, 0.02)]
    for name, amplitude in (
        ("flexion", BENDING.flexion_amplitude),
        ("side_bend", BENDING.side_bend_amplitude),
        ("twist", BENDING.spine_twist_amplitude),
        ("swell", BENDING.chest_amplitude),
    ):
        most = max(abs(getattr(bend, name)) for bend in bends)
        # Sampled every 20 ms, no crest is missed by more.
        assert most == pytest.approx(amplitude, rel=1e-3)


def test_a_person_without_bending_is_rigid():
    assert not MotionConfig().bends
    assert BENDING.bends


def damaged(folder, **changes):
    with np.load(folder / "rig.npz") as archive:
        arrays = {key: archive[key] for key in archive.files}
    arrays |= {key: change(arrays[key].copy()) for key, change in changes.items()}
    np.savez(folder / "rig.npz", **arrays)


def other_joint(names):
    names[names == "spine03"] = "tail"
    return names


def not_finite(rest):
    rest[7, 1] = np.nan
    return rest


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"names": other_joint}, "spine03 is missing"),
        ({"rest": not_finite}, "rest: is not finite"),
        ({"rest": lambda a: a[:-1]}, "rest: found float32"),
        ({"joints": lambda a: a + 100}, "joints: allowed indices"),
        ({"offset": lambda a: a + 0.1}, "mm off mesh.npz"),
        ({"weights": lambda a: a * 0}, "weights: allowed"),
        ({"parent": lambda a: a + 50}, "parent: a joint"),
    ],
)
def test_a_damaged_rig_is_refused_by_key(tmp_path, changes, message):
    folder = tmp_path / "somebody"
    shutil.copytree(models_folder() / "people" / "f_avg", folder)
    damaged(folder, **changes)
    with pytest.raises(ScenarioError, match=message):
        bending_skin(load_person(folder))


def test_a_person_without_rig_cannot_bend(tmp_path):
    folder = tmp_path / "somebody"
    shutil.copytree(models_folder() / "people" / "f_avg", folder)
    (folder / "rig.npz").unlink()
    with pytest.raises(ScenarioError, match="without a rig"):
        bending_skin(load_person(folder))
