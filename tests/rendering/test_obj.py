"""OBJ text becomes the mesh it describes, or is refused by its line."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.rendering.obj import obj_shape

SQUARE = """# a square
mtllib none.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vn 0 0 2
vt 0 0
f 1/1/1 2/1/1 3//1 4//1
"""


def test_a_face_of_four_corners_is_two_triangles_with_unit_normals():
    shape = obj_shape(SQUARE)
    assert shape.triangles.shape == (2, 3)
    np.testing.assert_array_equal(shape.normals, np.tile([0.0, 0.0, 1.0], (6, 1)))
    np.testing.assert_array_equal(
        shape.vertices[shape.triangles[1]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]
    )


def test_negative_indices_count_from_the_newest():
    points = SQUARE[: SQUARE.index("f ")]
    newest = obj_shape(points + "f -4//-1 -3//-1 -2//-1 -1//-1\n")
    np.testing.assert_array_equal(newest.vertices, obj_shape(SQUARE).vertices)


def test_without_normals_every_triangle_is_flat():
    shape = obj_shape("v 0 0 0\nv 0 2 0\nv 2 0 0\nf 1 2 3\n")
    np.testing.assert_array_equal(shape.normals, np.tile([0.0, 0.0, -1.0], (3, 1)))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4.*index 4: allowed 1 to 3"),
        ("v 0 0\n", "line 1.*three finite numbers"),
        ("v 0 0 nan\n", "line 1.*three finite numbers"),
        ("v 0 0 0\nf 1 1\n", "line 2.*three corners"),
        ("v 0 0 0\nf 0 1 1\n", "line 2.*index 0"),
        ("", "no face"),
    ],
)
def test_what_is_no_mesh_is_refused_by_its_line(text, told):
    with pytest.raises(ValueError, match=told):
        obj_shape(text)


@given(st.text(alphabet="vnf 0123-./e\n", max_size=200))
def test_any_text_is_a_sound_mesh_or_a_value_error(text):
    try:
        shape = obj_shape(text)
    except ValueError:
        return
    assert shape.triangles.max() < len(shape.vertices) == len(shape.normals)
    assert np.isfinite(shape.vertices).all()
