"""The wound lies on the true skin where it was asked for."""

import numpy as np
import pytest

from bath_drake.scene.people import load_person
from bath_drake.scene.wound import back_point, wound_patch

CENTRE, SEMI_AXES, ANGLE = np.array([-0.2, 0.1]), np.array([0.25, 0.15]), 0.4


@pytest.fixture(scope="module")
def person():
    return load_person("m_heavy")


@pytest.fixture(scope="module")
def patch(person):
    return wound_patch(person, CENTRE, SEMI_AXES, ANGLE)


def canonical(person, points):
    low, high = person.back_extents
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    scaled = (points - middle) / half
    return np.stack([-scaled[:, 0], scaled[:, 2]], axis=1)


def test_the_outline_is_the_ellipse_in_true_canonical_coordinates(person, patch):
    offset = canonical(person, patch.outline) - CENTRE
    c, s = np.cos(ANGLE), np.sin(ANGLE)
    u, v = offset @ [c, s], offset @ [-s, c]
    # Exact but for rounding: the outline is projected along y, x and z are kept.
    np.testing.assert_allclose(
        (u / SEMI_AXES[0]) ** 2 + (v / SEMI_AXES[1]) ** 2, 1.0, rtol=1e-9
    )


def test_the_outline_lies_on_the_skin(person, patch):
    skin = back_point(person, canonical(person, patch.outline))
    np.testing.assert_allclose(patch.outline, skin, atol=1e-9)


def test_the_patch_covers_the_skin_by_less_than_a_millimetre(person, patch):
    centroids = patch.vertices[patch.triangles].mean(axis=1)
    skin = back_point(person, canonical(person, centroids))
    above = centroids[:, 1] - skin[:, 1]
    assert above.min() > 0.0  # the camera must see the patch, never the skin
    # 0.8 mm along the normal; along y a little more where the back curves away.
    assert above.max() < 0.0015


def test_its_triangles_face_out_of_the_body(person, patch):
    a, b, c = patch.vertices[patch.triangles].transpose(1, 0, 2)
    faces = np.cross(b - a, c - a)
    normals = patch.normals[patch.triangles].mean(axis=1)
    assert (np.einsum("ij,ij->i", faces, normals) > 0.0).all()


def test_canonical_x_is_to_the_persons_right_and_y_to_the_head(person):
    right, up, middle = back_point(person, np.array([[0.5, 0], [0, 0.5], [0, 0]]))
    assert right[0] < middle[0] - 0.05
    assert up[2] > middle[2] + 0.05


def test_beside_the_body_there_is_no_skin(person):
    points = back_point(person, np.array([[4.0, 0.0], [0.0, 0.0]]))
    assert np.isnan(points[0, 1])
    assert np.isfinite(points[1]).all()


@pytest.mark.parametrize("centre", [[3.0, 0.0], [0.9, 0.9], [0.0, -1.4]])
def test_a_wound_beside_the_back_is_refused(person, centre):
    with pytest.raises(ValueError, match="does not lie on the back"):
        wound_patch(person, np.array(centre), SEMI_AXES, ANGLE)
