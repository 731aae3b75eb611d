"""The carer's hand and arm on every shipped person."""

import numpy as np
import pytest

from bath_drake.carer.arm import FOREARM, GRIP, HAND, PARTS, UPPER_ARM
from bath_drake.carer.config import CarerConfig
from bath_drake.carer.shapes import limbs
from bath_drake.carer.skin_path import lay_on_skin
from bath_drake.carer.stroke import waypoint_stroke
from bath_drake.errors import ScenarioError
from bath_drake.patient.people import load_person, shipped_people
from bath_drake.patient.skin import TrueSkin
from bath_drake.rendering.solids import capsule, ellipsoid
from bath_drake.scene.carer import carer_arm
from bath_drake.scene.config import SceneConfig
from bath_drake.scene.studio import true_person_pose

PEOPLE = shipped_people()
MOMENTS = np.linspace(0.0, 8.0, 33)


def made_up(person, side="right", **options):
    scene = SceneConfig(person=person, carer=CarerConfig(side=side, **options))
    skin = TrueSkin(load_person(person))
    path = lay_on_skin(waypoint_stroke(scene.carer), skin)
    arm = carer_arm(scene, skin, path)

    def pose(t):
        X_WM = true_person_pose(scene, skin.person, t)
        return np.array(X_WM.rotation().matrix()), np.array(X_WM.translation())

    return skin, arm, pose


@pytest.fixture(
    scope="module", params=[(p, "right") for p in PEOPLE] + [("f_avg", "left")]
)
def carer(request):
    return made_up(*request.param)


def test_the_marker_touches_the_skin_where_the_stroke_says(carer):
    skin, arm, _ = carer
    stroke = waypoint_stroke(CarerConfig())
    for t in MOMENTS:
        contact = arm.path.contact(t)
        distance, _, _ = skin.nearest(contact[None])
        # Linear between samples of 10 ms on a skin of 25 mm facets.
        assert distance[0] < 2e-4
        p_N = skin.canonical_map.canonical_from_world(contact)
        np.testing.assert_allclose(p_N, stroke.at(np.array([t]))[0], atol=1e-3)


def test_no_part_of_hand_and_forearm_is_in_the_body(carer):
    skin, arm, pose = carer
    shapes = limbs(arm.marker_radius)
    for t in MOMENTS:
        R_WM, p_WM = pose(t)
        parts = arm.poses(t, (R_WM, p_WM))
        for part in ("marker", "hand", "forearm", "upper_arm"):
            R, p = parts[part]
            for shape in shapes[part].values():
                p_M = (shape.vertices @ R.T + p - p_WM) @ R_WM
                distance, points, normals = skin.nearest(p_M)
                inside = ((p_M - points) * normals).sum(axis=1) < 0.0
                assert not (inside & (distance > 0.003)).any(), (part, t)


def test_the_bones_keep_their_lengths_and_meet(carer):
    _, arm, pose = carer
    for t in MOMENTS:
        parts = arm.poses(t, pose(t))
        assert set(parts) == set(PARTS)
        for R, _ in parts.values():
            np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
            assert np.linalg.det(R) > 0.0
        ends = {name: p for name, (_, p) in parts.items()}
        lengths = [
            np.linalg.norm(ends[a] - ends[b])
            for a, b in (
                ("marker", "hand"),
                ("hand", "forearm"),
                ("forearm", "upper_arm"),
                ("upper_arm", "trunk"),
            )
        ]
        np.testing.assert_allclose(lengths, [GRIP, HAND, FOREARM, UPPER_ARM])


def test_the_arm_comes_from_the_carers_side_and_hangs(carer):
    _, arm, pose = carer
    for t in MOMENTS:
        parts = arm.poses(t, pose(t))
        p = {name: position for name, (_, position) in parts.items()}
        assert (p["trunk"] - p["marker"]) @ arm.aside_W > 0.2
        # The elbow is lower than the line from the wrist to the shoulder.
        middle = (p["forearm"] + p["trunk"]) / 2.0
        assert p["upper_arm"][2] < middle[2]


def test_nothing_moves_faster_than_a_hand_can(carer):
    _, arm, pose = carer
    t = np.arange(0.0, 8.0, 1.0 / 30.0)
    tracks = [[p for _, p in arm.poses(s, pose(s)).values()] for s in t]
    speeds = np.linalg.norm(np.diff(tracks, axis=0), axis=2) * 30.0
    assert speeds.max() < 1.0  # m/s; washing hands make 0.1 to 0.5


def test_a_stroke_beside_the_back_is_refused_with_its_place():
    with pytest.raises(ScenarioError, match=r"leaves the back of .* at .* s"):
        made_up("m_avg", waypoints=[[0.0, 0.0], [1.0, -1.0]])


@pytest.mark.parametrize(
    "shape",
    [
        ellipsoid([0.1, 0.0, -0.2], [0.05, 0.1, 0.2]),
        capsule([0.0, 0.1, 0.0], [0.2, 0.0, 0.1], 0.03),
    ],
)
def test_a_shape_is_closed_and_faces_outward(shape):
    v, f = shape.vertices, shape.triangles
    facets = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
    large = np.linalg.norm(facets, axis=1) > 1e-9
    outward = (facets * shape.normals[f].mean(axis=1)).sum(axis=1)
    assert (outward[large] > 0.0).all()
    # The facets' vectors of a closed surface sum up to nothing.
    np.testing.assert_allclose(facets.sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(shape.normals, axis=1), 1.0)


def test_a_capsule_has_its_radius():
    shape = capsule([0.0, 0.0, 0.0], [0.0, 0.3, 0.0], 0.03)
    across = np.hypot(shape.vertices[:, 0], shape.vertices[:, 2])
    assert across.max() == pytest.approx(0.03)
    assert shape.vertices[:, 1].min() == pytest.approx(-0.03)
    assert shape.vertices[:, 1].max() == pytest.approx(0.33)
