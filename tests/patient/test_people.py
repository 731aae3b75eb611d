"""People's folders: the shipped ones load, damaged ones are refused by name."""

import shutil

import numpy as np
import pytest

from bath_drake.errors import ScenarioError
from bath_drake.patient.gltf import read_part
from bath_drake.patient.people import (
    LABEL_BACK,
    PARTS,
    find_person,
    load_person,
    shipped_people,
)
from bath_drake.resources import models_folder

PEOPLE = shipped_people()


@pytest.fixture
def folder(tmp_path):
    copy = tmp_path / "somebody"
    shutil.copytree(models_folder() / "people" / "f_avg", copy)
    return copy


def rewrite_mesh(folder, **changes):
    with np.load(folder / "mesh.npz") as archive:
        arrays = {key: archive[key] for key in archive.files}
    for key, value in changes.items():
        if value is None:
            del arrays[key]
        else:
            arrays[key] = value(arrays[key].copy())
    np.savez(folder / "mesh.npz", **arrays)


@pytest.mark.parametrize("name", PEOPLE)
def test_every_shipped_person_loads(name):
    person = load_person(name)
    assert person.rigged
    assert 1.45 < person.stature < 2.0
    assert person.licence == "CC0-1.0"


@pytest.mark.parametrize("name", PEOPLE)
def test_a_seated_persons_parts_are_where_they_belong(name):
    person = load_person(name)
    low, high = person.back_extents
    assert person.vertices[:, 2].min() == pytest.approx(0.0, abs=0.01)  # feet
    assert person.seat[2] < low[2] < high[2]
    assert person.seat[2] < person.hips[2] < low[2] + 0.15
    # The back faces +y; slouching tilts its plane by less than 20 degrees.
    assert person.back_normal[1] > np.cos(np.radians(20.0))
    assert np.linalg.norm(person.back_normal) == pytest.approx(1.0)


@pytest.mark.parametrize("name", PEOPLE)
def test_the_cameras_parts_exist_and_are_smaller(name):
    person = load_person(name)
    for part in PARTS:
        assert person.part_path(part).is_file()
    low = person.part_path("body", for_camera=True)
    assert low.name == "body_low.gltf"
    assert low.stat().st_size < person.part_path("body").stat().st_size / 2


def test_a_person_without_rig_and_decimated_body_is_complete(folder):
    (folder / "rig.npz").unlink()
    (folder / "body_low.gltf").unlink()
    person = load_person(folder)
    assert not person.rigged
    assert person.part_path("body", for_camera=True) == folder / "body.gltf"


def test_the_mesh_cannot_be_changed():
    person = load_person("m_avg")
    with pytest.raises(ValueError, match="read-only"):
        person.vertices[0] = 0.0


def test_an_unknown_person_is_answered_with_the_known_ones():
    with pytest.raises(ScenarioError, match="nobody.*" + ", ".join(PEOPLE)):
        find_person("nobody")


def test_people_of_six_builds_or_more_ship():
    assert len(PEOPLE) >= 6
    people = [load_person(name) for name in PEOPLE]
    assert len({person.name for person in people}) == len(people)
    # Clearly different: 35 cm from the smallest to the tallest, 10 cm in the width of
    # the back, and skins from very dark to very fair, half the scale apart.
    assert np.ptp([person.stature for person in people]) > 0.35
    widths = [(high - low)[0] for low, high in (p.back_extents for p in people)]
    assert np.ptp(widths) > 0.1
    skins = [read_part(person.part_path("back")).rgba[:3].mean() for person in people]
    assert np.ptp(skins) > 0.5


@pytest.mark.parametrize(
    "file", ["body.gltf", "trunks.gltf", "mesh.npz", "person.yaml"]
)
def test_a_missing_file_is_named(folder, file):
    (folder / file).unlink()
    with pytest.raises(ScenarioError, match=file):
        load_person(folder)


def not_finite(vertices):
    vertices[17, 1] = np.nan
    return vertices


def out_of_range(triangles):
    triangles[5, 2] = 10**6
    return triangles


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"V": not_finite}, "V: row 17 is not finite"),
        ({"V": lambda v: v[:, :2]}, r"V: found float32 \(13718, 2\)"),
        ({"F": out_of_range}, "F: row 5: found .*1000000.*allowed indices 0 to"),
        ({"F": lambda f: -1 - f}, "F: row 0"),
        ({"F": lambda f: f.astype(float)}, "F: found float64"),
        ({"F": lambda f: f[:0]}, "no triangle"),
        ({"label": lambda la: la[:-1]}, "label: found"),
        ({"label": lambda la: la + 7}, "allowed are 0 other, 1 back, 2 head"),
        ({"label": lambda la: np.where(la == LABEL_BACK, 0, la)}, "of the back"),
        ({"label": None}, "label is missing, found F, V"),
        ({"V": lambda v: v.astype(object)}, "not a readable .npz"),
    ],
)
def test_a_damaged_mesh_is_refused_by_key(folder, changes, message):
    rewrite_mesh(folder, **changes)
    with pytest.raises(ScenarioError, match=message):
        load_person(folder)


@pytest.mark.parametrize("data", [b"", b"no archive at all", b"PK\x03\x04damaged"])
def test_an_unreadable_mesh_file_is_refused(folder, data):
    (folder / "mesh.npz").write_bytes(data)
    with pytest.raises(ScenarioError, match=r"mesh\.npz"):
        load_person(folder)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name: A\nstature: 1.7\n", "licence"),
        ("name: A\nstature: tall\nlicence: CC0\n", "stature"),
        ("name: A\nstature: 17.0\nlicence: CC0\n", r"stature.*17\.0.*allowed 0\.4"),
        ("name: A\nstature: 1.7\nlicence: CC0\nage: 3\n", "age"),
    ],
)
def test_person_yaml_is_strict(folder, text, message):
    (folder / "person.yaml").write_text(text)
    with pytest.raises(ScenarioError, match=message):
        load_person(folder)
