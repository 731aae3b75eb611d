"""The shell SceneGraph wants: positive volumes, whatever the skin."""

import numpy as np
import pytest

from bath_drake.errors import ScenarioError
from bath_drake.patient.gltf import gltf_text, read_part
from bath_drake.patient.people import PARTS, load_person
from bath_drake.patient.shell import (
    THICKNESS_M,
    foldable,
    shell_tetrahedra,
    volumes,
    with_inside,
)
from bath_drake.rendering.normals import vertex_normals


@pytest.mark.parametrize("part", PARTS)
def test_every_part_of_a_person_gets_a_shell_of_positive_volumes(part):
    read = read_part(load_person("m_heavy").part_path(part, for_camera=True))
    vertices, triangles = foldable(read.vertices, read.triangles)
    shell = with_inside(vertices, triangles)
    assert volumes(shell, shell_tetrahedra(triangles, len(vertices))).min() > 0.0
    # Nothing one can see has gone: the area is that of the part.
    before, after = (
        np.linalg.norm(
            np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]), axis=1
        ).sum()
        for v, f in ((read.vertices, read.triangles), (vertices, triangles))
    )
    assert after == pytest.approx(before, rel=1e-6)


def test_a_sheet_folded_on_itself_gets_one_too():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, 0.9, 0.01]], float)
    triangles = np.array([[0, 1, 2], [1, 0, 3]])
    points, faces = foldable(vertices, triangles)
    tetrahedra = shell_tetrahedra(faces, len(points))
    assert volumes(with_inside(points, faces), tetrahedra).min() > 0.0
    assert len(faces) == 2


def test_a_triangle_without_area_is_left_out():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], float)
    _, faces = foldable(vertices, np.array([[0, 1, 2], [0, 1, 3]]))
    assert len(faces) == 1


def test_the_tetrahedra_of_a_prism_fill_it():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    for turn in range(3):
        triangles = np.roll(np.array([[0, 1, 2]]), turn, axis=1)
        shell = with_inside(vertices, triangles)
        total = volumes(shell, shell_tetrahedra(triangles, 3)).sum()
        assert total == pytest.approx(0.5 * THICKNESS_M, rel=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"meshes"', '"nothing"', "not a glTF mesh"),
        ("base64,", "base64,!", "not a glTF mesh"),
        ('"baseColorFactor":[0.', '"baseColorFactor":[7.', "baseColorFactor"),
    ],
)
def test_a_damaged_part_is_refused_by_name(tmp_path, old, new, message):
    text = load_person("f_avg").part_path("back").read_text().replace(" ", "")
    assert old in text
    path = tmp_path / "back.gltf"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ScenarioError, match=message):
        read_part(path)


def test_a_part_that_is_written_is_read_again(tmp_path):
    part = read_part(load_person("f_avg").part_path("back"))
    normals = vertex_normals(part.vertices, part.triangles, True)
    path = tmp_path / "back.gltf"
    path.write_text(gltf_text(part, normals))
    again = read_part(path)
    # What was read is in single precision already.
    np.testing.assert_array_equal(again.vertices, part.vertices)
    np.testing.assert_array_equal(again.triangles, part.triangles)
    np.testing.assert_array_equal(again.rgba, part.rgba)
