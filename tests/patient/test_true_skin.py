import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bath_drake.patient.people import LABEL_BACK, load_person, shipped_people
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.wound import signed_polygon_distance

PEOPLE = shipped_people()
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


@pytest.fixture(scope="module", params=PEOPLE)
def skin(request):
    return TrueSkin(load_person(request.param))


def test_the_skin_is_nowhere_further_than_its_vertices(skin):
    distance, points, normals = skin.nearest(skin.person.vertices[::97])
    # 1e-5 m: the queries are in single precision, people are a metre or two away.
    np.testing.assert_allclose(distance, 0.0, atol=1e-5)
    np.testing.assert_allclose(points, skin.person.vertices[::97], atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-9)


def test_a_ray_against_the_normal_comes_back_to_where_it_left(skin):
    back = np.flatnonzero(skin.person.labels == LABEL_BACK)[::23]
    _, points, normals = skin.nearest(skin.person.vertices[back])
    hits, met = skin.hit(points + 0.06 * normals, -normals)
    assert met.mean() > 0.99  # an arm may stand in the way of a ray or two
    error = np.linalg.norm(hits - points, axis=1)[met]
    # 0.1 mm: single precision; the median is blind to rays that meet an arm first.
    assert np.median(error) < 1e-4


def test_the_true_map_is_upright_and_as_large_as_a_back(skin):
    true_map = skin.canonical_map
    # Back faces +y of M, x is to the person's right: -x of M.
    assert true_map.R_WP[:, 0] @ [-1, 0, 0] > 0.99
    assert true_map.R_WP[:, 1] @ [0, 0, 1] > 0.9
    assert true_map.normal_W @ [0, 1, 0] > 0.9
    assert (true_map.half_extents > 0.1).all()
    assert (true_map.half_extents < 0.35).all()


@given(points=arrays(float, (7, 2), elements=st.floats(-3.0, 3.0)))
def test_the_distance_to_a_square_is_the_known_one(points):
    outside = np.maximum(np.abs(points) - 1.0, 0.0)
    inside = np.minimum(np.abs(points).max(axis=1) - 1.0, 0.0)
    expected = np.linalg.norm(outside, axis=1) + inside
    # 1e-12: a few operations on numbers near one.
    np.testing.assert_allclose(
        signed_polygon_distance(points, SQUARE), expected, atol=1e-12
    )
