"""The wound lies on the true skin where it was asked for."""

import numpy as np
import pytest

from bath_drake.patient.people import load_person
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.wound import wound_patch

CENTRE, SEMI_AXES, ANGLE = np.array([-0.2, 0.1]), np.array([0.25, 0.15]), 0.4


@pytest.fixture(scope="module")
def person():
    return load_person("m_heavy")


@pytest.fixture(scope="module")
def patch(person):
    return wound_patch(person, CENTRE, SEMI_AXES, ANGLE)


@pytest.fixture(scope="module")
def skin(person):
    return TrueSkin(person)


def test_the_outline_is_the_ellipse_in_true_canonical_coordinates(skin, patch):
    offset = skin.canonical_map.canonical_from_world(patch.outline) - CENTRE
    c, s = np.cos(ANGLE), np.sin(ANGLE)
    u, v = offset @ [c, s], offset @ [-s, c]
    # The skin is met by rays in single precision, some 1e-6 of the extents.
    np.testing.assert_allclose(
        (u / SEMI_AXES[0]) ** 2 + (v / SEMI_AXES[1]) ** 2, 1.0, atol=1e-4
    )


def test_the_outline_lies_on_the_skin(skin, patch):
    # 1e-5 m: single precision, a metre from the origin.
    np.testing.assert_allclose(skin.nearest(patch.outline)[0], 0.0, atol=1e-5)


def test_the_patch_covers_the_skin_by_less_than_a_millimetre(skin, patch):
    centroids = patch.vertices[patch.triangles].mean(axis=1)
    distance, nearest, normals = skin.nearest(centroids)
    # The camera must see the patch, never the skin.
    assert (((centroids - nearest) * normals).sum(axis=1) > 0.0).all()
    # 0.8 mm along the normal, and less where the patch cuts the corner of a bulge.
    assert distance.max() < 0.0015


def test_its_triangles_face_out_of_the_body(person, patch):
    a, b, c = patch.vertices[patch.triangles].transpose(1, 0, 2)
    faces = np.cross(b - a, c - a)
    normals = patch.normals[patch.triangles].mean(axis=1)
    assert (np.einsum("ij,ij->i", faces, normals) > 0.0).all()


def test_canonical_x_is_to_the_persons_right_and_y_to_the_head(skin):
    points, met = skin.under(np.array([[0.5, 0], [0, 0.5], [0, 0]]))
    right, up, middle = points
    assert met.all()
    assert right[0] < middle[0] - 0.05
    assert up[2] > middle[2] + 0.05


def test_beside_the_body_there_is_no_skin(skin):
    _, met = skin.under(np.array([[4.0, 0.0], [0.0, 0.0]]))
    assert met.tolist() == [False, True]


@pytest.mark.parametrize("centre", [[3.0, 0.0], [0.9, 0.9], [0.0, -1.4]])
def test_a_wound_beside_the_back_is_refused(person, centre):
    with pytest.raises(ValueError, match="does not lie on the back"):
        wound_patch(person, np.array(centre), SEMI_AXES, ANGLE)
