"""Solids are closed, their normals point outward, and they are as large as they say."""

from dataclasses import replace

import numpy as np
import pytest

from bath_drake.rendering.solids import (
    box,
    capsule,
    cylinder,
    ellipsoid,
    faceted,
    is_solid,
    subdivided,
)

_FINE = {"around": 120, "rings": 61}
SOLIDS = {
    "box": (box([0.2, 0.3, 0.5]), 0.03),
    "cylinder": (cylinder(0.2, 0.5, around=400), np.pi * 0.04 * 0.5),
    "ellipsoid": (
        ellipsoid([1.0, 2.0, 3.0], [0.1, 0.2, 0.3], **_FINE),
        4 / 3 * np.pi * 0.006,
    ),
    "capsule": (
        capsule([0.0, 0.0, 0.0], [0.3, 0.0, 0.4], 0.1, **_FINE),
        np.pi * 0.01 * 0.5 + 4 / 3 * np.pi * 0.001,
    ),
}


def volume(shape):
    a, b, c = (shape.vertices[shape.triangles[:, k]] for k in range(3))
    return (np.cross(a, b) * c).sum() / 6.0


@pytest.mark.parametrize("name", SOLIDS)
def test_a_solid_holds_its_volume(name):
    shape, expected = SOLIDS[name]
    # Signed, so that a facet turned inside out would be missed; a polyhedron inside of
    # a round solid holds a little less.
    assert volume(shape) == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("name", SOLIDS)
def test_a_solid_is_told_from_a_shell_and_from_one_inside_out(name):
    shape, _ = SOLIDS[name]
    assert is_solid(shape)
    assert is_solid(faceted(shape.vertices, shape.triangles))
    # Without a triangle that has an area.
    assert not is_solid(replace(shape, triangles=shape.triangles[10:]))
    assert not is_solid(replace(shape, triangles=shape.triangles[:, ::-1]))


@pytest.mark.parametrize("name", SOLIDS)
def test_the_normals_of_a_solid_point_outward(name):
    shape, _ = SOLIDS[name]
    a, b, c = (shape.vertices[shape.triangles[:, k]] for k in range(3))
    facets = np.cross(b - a, c - a)
    seen = np.linalg.norm(facets, axis=1) > 1e-12
    for corner in range(3):
        normals = shape.normals[shape.triangles[:, corner]]
        assert ((normals * facets).sum(axis=1)[seen] > 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(shape.normals, axis=1), 1.0, atol=1e-12)


def test_a_faceted_mesh_is_flat_in_every_triangle():
    shape, _ = SOLIDS["ellipsoid"]
    flat = faceted(shape.vertices, shape.triangles)
    assert volume(flat) == pytest.approx(volume(shape), rel=1e-12)
    corners = flat.normals[flat.triangles]
    assert (corners == corners[:, :1]).all()


@pytest.mark.parametrize("name", SOLIDS)
def test_a_subdivided_mesh_is_the_same_with_short_edges(name):
    shape, _ = SOLIDS[name]
    fine = subdivided(shape, 0.15)
    corners = fine.vertices[fine.triangles]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert edges.max() <= 0.15
    assert volume(fine) == pytest.approx(volume(shape), rel=1e-12)
