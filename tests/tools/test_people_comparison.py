"""Two folders of a person are compared by their contents."""

import shutil

import numpy as np
import pytest
from person_maker.comparison import differences

from bath_drake.patient.gltf import Part, gltf_text, read_part
from bath_drake.patient.people import load_person


@pytest.fixture
def shipped():
    return load_person("f_old").folder


@pytest.fixture
def copy(tmp_path, shipped):
    folder = tmp_path / "f_old"
    shutil.copytree(shipped, folder)
    return folder


def change(path, **changes):
    with np.load(path) as archive:
        arrays = {key: archive[key] for key in archive.files}
    np.savez(path, **{k: changes.get(k, lambda a: a)(a) for k, a in arrays.items()})


def test_a_copy_does_not_differ(copy, shipped):
    assert differences(copy, shipped) == []


def test_other_bytes_of_the_same_arrays_do_not_differ(copy, shipped):
    change(copy / "mesh.npz", V=lambda v: v + np.float32(1e-6))
    assert (copy / "mesh.npz").read_bytes() != (shipped / "mesh.npz").read_bytes()
    assert differences(copy, shipped) == []


@pytest.mark.parametrize(
    ("file", "changes", "message"),
    [
        ("mesh.npz", {"V": lambda v: v + np.float32(1e-3)}, "mesh.npz: V: 0.001 apart"),
        ("mesh.npz", {"label": lambda la: la * 0}, "mesh.npz: label: "),
        ("mesh.npz", {"F": lambda f: f[1:]}, "mesh.npz: F: shape"),
        ("rig.npz", {"weights": lambda w: w[::-1]}, "rig.npz: weights: "),
        ("rig.npz", {"pose": lambda p: -p}, "rig.npz: pose: "),
    ],
)
def test_a_changed_array_is_named(copy, shipped, file, changes, message):
    change(copy / file, **changes)
    (found,) = differences(copy, shipped)
    assert found.startswith(message)


def test_another_skin_is_named(copy, shipped):
    path = copy / "back.gltf"
    part = read_part(path)
    other = Part(part.vertices, part.triangles, np.array([0.5, 0.4, 0.3, 1.0]))
    path.write_text(gltf_text(other, np.zeros_like(part.vertices)))
    (found,) = differences(copy, shipped)
    assert found.startswith("back.gltf: colour: ")


def test_another_decimation_is_named(copy, shipped):
    shutil.copy(copy / "body.gltf", copy / "body_low.gltf")
    found = differences(copy, shipped)
    assert found
    assert found[0].startswith("body_low.gltf: ")


def test_another_name_is_named(copy, shipped):
    path = copy / "person.yaml"
    path.write_text(path.read_text().replace("old", "young"))
    assert differences(copy, shipped) == ["person.yaml: another text"]
