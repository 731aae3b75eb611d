"""Normals at vertices: of a ball they point outward, however they are weighed."""

import numpy as np
import open3d as o3d
import pytest

from bath_drake.rendering.normals import vertex_normals


@pytest.mark.parametrize("by_area", [True, False])
def test_a_balls_normals_point_away_from_its_middle(by_area):
    ball = o3d.geometry.TriangleMesh.create_sphere(0.3, 40)
    vertices, triangles = np.asarray(ball.vertices), np.asarray(ball.triangles)
    normals = vertex_normals(vertices, triangles.astype(np.int64), by_area)
    # Facets of 4 degrees are of different sizes to both sides of a vertex.
    assert (normals * vertices).sum(axis=1).min() > 0.3 * np.cos(np.radians(3.0))
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-12)


def test_areas_count_only_where_they_are_to():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, -9]], float)
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    (x, _, z), *_ = vertex_normals(vertices, triangles, False)
    assert abs(x) == pytest.approx(z)
    (x, _, z), *_ = vertex_normals(vertices, triangles, True)
    assert abs(x) == pytest.approx(9.0 * z)


def test_a_vertex_of_no_triangle_has_none():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5]], float)
    normals = vertex_normals(vertices, np.array([[0, 1, 2]]), True)
    np.testing.assert_array_equal(normals[3], 0.0)
