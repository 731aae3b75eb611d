"""A person's mesh whose numbers are of the wrong kind is refused, not read."""

import base64
import json

import numpy as np
import pytest

from bath_drake.errors import ScenarioError
from bath_drake.patient.gltf import Part, gltf_text, read_part

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
PART = Part(CORNERS, np.array([[0, 1, 2]]), np.ones(4))


def written(path, change=None):
    gltf = json.loads(gltf_text(PART, np.tile([0.0, 0.0, 1.0], (3, 1))))
    if change is not None:
        change(gltf)
    path.write_text(json.dumps(gltf), "utf-8")
    return path


def test_a_part_comes_back_as_it_was_written(tmp_path):
    part = read_part(written(tmp_path / "back.gltf"))
    np.testing.assert_allclose(part.vertices, CORNERS)
    np.testing.assert_array_equal(part.triangles, PART.triangles)


@pytest.mark.parametrize(
    ("which", "kind", "message"),
    [
        ("indices", 5126, "found float32, allowed unsigned integers"),
        ("POSITION", 5125, "found uint32, allowed float32"),
    ],
)
def test_numbers_of_another_kind_are_refused(tmp_path, which, kind, message):
    def change(gltf):
        primitive = gltf["meshes"][0]["primitives"][0]
        places = {**primitive["attributes"], "indices": primitive["indices"]}
        gltf["accessors"][places[which]]["componentType"] = kind

    with pytest.raises(ScenarioError, match=message):
        read_part(written(tmp_path / "back.gltf", change))


@pytest.mark.parametrize(
    ("name", "values", "allowed"),
    [
        ("translation", [0.0, 0.1, 0.0], False),
        ("rotation", [0.0, 1.0, 0.0, 0.0], False),
        ("scale", [2.0, 2.0, 2.0], False),
        ("matrix", (2.0 * np.eye(4)).ravel().tolist(), False),
        ("translation", [0, 0, 0], True),
        ("matrix", np.eye(4).ravel().tolist(), True),
    ],
)
def test_a_node_that_would_move_the_mesh_is_refused(tmp_path, name, values, allowed):
    path = written(
        tmp_path / "back.gltf", lambda gltf: gltf["nodes"][0].update({name: values})
    )
    if allowed:
        np.testing.assert_allclose(read_part(path).vertices, CORNERS)
    else:
        with pytest.raises(ScenarioError, match=f"found a {name} at a node"):
            read_part(path)


def test_a_nan_that_signals_is_refused_without_a_warning(tmp_path):
    def change(gltf):
        uri = gltf["buffers"][0]["uri"]
        head, data = uri.split("base64,")
        raw = bytearray(base64.b64decode(data))
        # The first vertex follows three indices of four bytes.
        raw[12:16] = bytes([1, 0, 0x80, 0x7F])
        gltf["buffers"][0]["uri"] = f"{head}base64,{base64.b64encode(raw).decode()}"

    with pytest.raises(ScenarioError, match="not finite"):
        read_part(written(tmp_path / "back.gltf", change))
