from dataclasses import replace

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from bath_drake.certificate.certify import certify
from bath_drake.certificate.result import Certificate
from bath_drake.certificate_file import content_checksum
from bath_drake.demonstrations.canonical import CanonicalFrame
from bath_drake.errors import SkillFileError
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.learning.skill import Skill
from bath_drake.resources import models_folder
from bath_drake.skill_file import (
    certified,
    field_from_mapping,
    field_to_mapping,
    is_skill_file,
    load_field,
    load_skill,
    save_skill,
    skill_to_mapping,
)
from bath_drake.yaml_io import dump_yaml, parse_yaml

NUMBER = st.floats(-1e6, 1e6)
POSITIVE = st.floats(1e-6, 1e6)
SHIPPED = sorted((models_folder() / "skills").glob("*.yaml"))
CERTIFICATE = Certificate("proved", "no trap", notes=("made up",), boxes=7)
FIELD_FILE = """
about: any YAML may hold a field
field:
  workspace: {centre: [0, 0], semi_axes: [5, 5], power: 2}
  goal: [3, 0]
  kappa: 4
  obstacles:
    - {centre: [0, 0], semi_axes: [1, 1], angle: 0, exponent: 1}
"""


@st.composite
def fields(draw):
    pair = st.lists(NUMBER, min_size=2, max_size=2)
    axes = st.lists(POSITIVE, min_size=2, max_size=2)
    rows = draw(st.lists(st.tuples(pair, axes, NUMBER, POSITIVE), max_size=4))
    theta = [[*centre, *semi_axes, angle] for centre, semi_axes, angle, _ in rows]
    obstacles = ObstacleSet(
        np.array(theta).reshape(-1, 5), np.array([row[3] for row in rows])
    )
    workspace = Workspace(
        np.array(draw(pair)), np.array(draw(axes)), draw(st.sampled_from([2, 4, 8]))
    )
    return NavigationField(workspace, np.array(draw(pair)), draw(POSITIVE), obstacles)


def make_skill(field=None, **changes):
    values = {
        "field": field or field_from_mapping(parse_yaml(FIELD_FILE)["field"]),
        "start": np.array([-0.1 - 0.2, 1e-17]),
        "seed": 2**63,
        "config": {"method": "auto", "obstacles": None, "margins": {"pair": 0.04}},
        "demonstration_hashes": ("ab" * 32, "cd" * 32),
        "canonical": CanonicalFrame(
            "path_plane",
            np.array([0.1, 0.2, 1 / 3]),
            np.array([[0.6, 0.8, 0.0], [0.0, 0.0, 1.0]]),
            np.array([0.2, 0.25]),
        ),
        "mean_demonstration": np.array([[-0.3, 1e-17], [0.1, 0.7], [1 / 3, 0.0]]),
        "scale": 4 / 3,
        "frechet": {"to_mean": 0.1 / 3, "cost": 0.02},
    }
    return certified(Skill(**(values | changes)), CERTIFICATE)


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "skill.yaml"
    save_skill(path, make_skill())
    return path


@settings(max_examples=50, deadline=None)
@given(fields())
def test_a_field_comes_back_from_text_to_the_last_bit(field):
    text = dump_yaml({"field": field_to_mapping(field)})
    assert field_from_mapping(parse_yaml(text)["field"]) == field


# Each example writes a file: slow disks take longer than 200 ms now and then.
@settings(max_examples=30, deadline=None)
@given(fields())
def test_a_skill_comes_back_from_its_file_to_the_last_bit(tmp_path_factory, field):
    path = tmp_path_factory.getbasetemp() / "round_trip.yaml"
    skill = make_skill(field)
    save_skill(path, skill)
    back = load_skill(path)
    assert back.field == skill.field
    assert back.canonical == skill.canonical
    np.testing.assert_array_equal(back.start, skill.start)
    for name in ("seed", "config", "demonstration_hashes", "scale", "frechet"):
        assert getattr(back, name) == getattr(skill, name)
    assert back.certificate == skill.certificate
    assert load_field(path) == skill.field


def test_the_same_skill_is_the_same_file(saved, tmp_path):
    save_skill(tmp_path / "again.yaml", load_skill(saved))
    assert (tmp_path / "again.yaml").read_bytes() == saved.read_bytes()


def test_numpy_values_and_tuples_in_the_config_are_kept_as_plain_ones(tmp_path):
    config = {"margins": (np.float64(0.5), np.int64(3)), "grid": np.arange(2.0)}
    save_skill(tmp_path / "s.yaml", make_skill(config=config))
    back = load_skill(tmp_path / "s.yaml")
    assert back.config == {"margins": [0.5, 3], "grid": [0.0, 1.0]}


def test_a_planar_skill_comes_back_too(tmp_path):
    frame = CanonicalFrame("planar", np.ones(2), np.eye(2), np.ones(2))
    save_skill(tmp_path / "s.yaml", make_skill(canonical=frame))
    assert load_skill(tmp_path / "s.yaml").canonical == frame


def test_a_field_is_found_in_any_yaml_file(tmp_path, saved):
    path = tmp_path / "world.yaml"
    path.write_text(FIELD_FILE)
    field = load_field(path)
    assert field.goal.tolist() == [3.0, 0.0]
    assert field.kappa == 4.0
    assert field.obstacles.theta.tolist() == [[0.0, 0.0, 1.0, 1.0, 0.0]]
    assert not is_skill_file(path)
    assert is_skill_file(saved)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("kappa: 4", "kappa: -4", "field: kappa must be positive"),
        ("kappa: 4", "kappa: four", "field.kappa: found 'four', expected a number"),
        ("kappa: 4", "kappa: .inf", "line 6: number .inf is not finite"),
        ("kappa: 4", "kapa: 4", "field.kappa: is missing"),
        ("kappa: 4", "kappa: 4\n  power: 2", "field.power: unknown key, allowed: work"),
        ("goal: [3, 0]", "goal: [3]", "field.goal: found 1 items, expected 2"),
        ("power: 2", "power: 3", "field.workspace: power must be even"),
        ("power: 2", "power: 2.0", "field.workspace.power: found 2.0, expected an int"),
        ("[5, 5]", "[5, 0]", "field.workspace: semi_axes must be positive"),
        ("[1, 1]", "[1, -1]", "field.obstacles: obstacle 0: semi-axes"),
        ("angle: 0, ", "", r"field.obstacles\[0\].angle: is missing"),
        ("exponent: 1", "exponent: 0", "field.obstacles: obstacle 0: the exponent"),
        ("- {", "- 5 #", r"field.obstacles\[0\]: found 5, expected a mapping"),
        ("field:", "feld:", "field: is missing, expected a mapping"),
    ],
)
def test_a_bad_field_is_refused_by_key(tmp_path, old, new, message):
    path = tmp_path / "world.yaml"
    path.write_text(FIELD_FILE.replace(old, new, 1))
    with pytest.raises(SkillFileError, match=message) as caught:
        load_field(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_a_composed_skill_is_refused_by_name(tmp_path):
    path = tmp_path / "composed.yaml"
    path.write_text("field:\n- {goal: [0, 0]}\n- {goal: [1, 0]}\n")
    with pytest.raises(SkillFileError, match=r"composed skill.*single field"):
        load_field(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(seed=3), "checksum: found 'sha256:.*changed or damaged"),
        (lambda d: d["field"].update(kappa=4.5), "checksum: .*changed or damaged"),
        (lambda d: d.update(extra=1), "checksum: .*changed or damaged"),
        (lambda d: d.pop("checksum"), "checksum: is missing"),
    ],
)
def test_a_skill_changed_by_hand_is_refused(saved, change, message):
    data = yaml.safe_load(saved.read_text())
    change(data)
    saved.write_text(dump_yaml(data))
    with pytest.raises(SkillFileError, match=message):
        load_skill(saved)


def test_a_checksum_holds_whatever_the_order_and_layout_of_keys(saved):
    data = yaml.safe_load(saved.read_text())
    turned = dict(reversed(data.items()))
    saved.write_text("# a remark\n" + dump_yaml(turned))
    assert load_skill(saved).field == make_skill().field


def test_a_field_in_a_damaged_skill_is_refused(saved):
    saved.write_text(saved.read_text().replace("kappa: 4.0", "kappa: 5.0"))
    with pytest.raises(SkillFileError, match="checksum"):
        load_field(saved)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(schema_version=3), "schema_version: found 3, .* reads 2$"),
        (lambda d: d.update(extra=1), "extra: unknown key, allowed: schema_version"),
        (lambda d: d.update(start=[1.0]), "start: found 1 items, expected 2"),
        (lambda d: d.update(scale=0.0), "file: scale must be positive"),
        (lambda d: d["frechet"].update(cost="low"), "frechet.cost: found 'low'"),
        (lambda d: d.update(frechet=3), "frechet: found 3, expected a mapping"),
        (lambda d: d["canonical"].update(kind="box"), "canonical.kind: found 'box'"),
        (
            lambda d: d["canonical"].update(scales=[1.0, 0.0]),
            "canonical: scales must be",
        ),
        (lambda d: d["canonical"].update(kind="planar"), "canonical.origin: found 3"),
        (lambda d: d["certificate"].pop("verdict"), "certificate.verdict: is missing"),
        (lambda d: d["certificate"].update(verdict="fine"), "verdict: found 'fine'"),
        (lambda d: d.update(certificate={}), "certificate.field_checksum: is missing"),
        (lambda d: d.update(demonstration_hashes=[1]), r"hashes\[0\]: found 1"),
    ],
)
def test_a_skill_with_a_right_checksum_but_wrong_content_is_refused(
    tmp_path, change, message
):
    data = skill_to_mapping(make_skill())
    change(data)
    path = tmp_path / "skill.yaml"
    path.write_text(dump_yaml(data | {"checksum": content_checksum(data)}))
    with pytest.raises(SkillFileError, match=message):
        load_skill(path)


def test_an_unwritable_skill_leaves_no_trace(tmp_path):
    with pytest.raises(SkillFileError, match="does not exist"):
        save_skill(tmp_path / "absent" / "s.yaml", make_skill())
    with pytest.raises(ValueError, match="cannot be written as YAML"):
        save_skill(tmp_path / "s.yaml", make_skill(config={"a": np.inf}))
    assert list(tmp_path.iterdir()) == []


def written(path, data):
    path.write_text(dump_yaml(data | {"checksum": content_checksum(data)}))
    return path


@pytest.mark.parametrize(
    "change",
    [
        lambda field: field.update(kappa=4.5),
        lambda field: field.update(goal=[2.0, 0.0]),
        lambda field: field["obstacles"].clear(),
        lambda field: field["workspace"].update(power=4),
    ],
)
def test_a_skill_whose_certificate_is_of_another_field_is_refused(tmp_path, change):
    data = skill_to_mapping(make_skill())
    certified_of = data["certificate"]["field_checksum"]
    change(data["field"])
    path = written(tmp_path / "skill.yaml", data)
    message = r"certificate.field_checksum: found 'sha256:.*another field.*--renew"
    with pytest.raises(SkillFileError, match=message) as caught:
        load_skill(path)
    assert certified_of[:20] in str(caught.value)


def test_a_skill_with_another_fields_certificate_is_not_even_saved(tmp_path):
    skill = make_skill()
    other = replace(skill, field=replace(skill.field, kappa=9.0))
    with pytest.raises(SkillFileError, match="about another field"):
        save_skill(tmp_path / "skill.yaml", other)
    with pytest.raises(SkillFileError, match="field_checksum: is missing"):
        save_skill(tmp_path / "skill.yaml", replace(skill, certificate={}))
    assert list(tmp_path.iterdir()) == []


def test_a_skill_of_version_1_is_refused_with_the_way_to_renew_it(tmp_path):
    skill = make_skill()
    old = skill_to_mapping(skill) | {
        "schema_version": 1,
        "certificate": {"verdict": "numeric-pass", "critical_points": []},
    }
    path = written(tmp_path / "skill.yaml", old)
    with pytest.raises(SkillFileError, match=r"found 1, .*reads 2; .* --renew"):
        load_skill(path)
    renewed = certified(load_skill(path, renew=True), CERTIFICATE)
    save_skill(path, renewed)
    assert load_skill(path).field == skill.field
    assert load_skill(path).certificate == skill.certificate


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_shipped_skill_is_proved_by_the_proof_of_today(path):
    skill = load_skill(path)
    certificate = certify(skill.field)
    assert skill.certificate["verdict"] == certificate.verdict == "proved"
    found = [[p["x"], p["y"]] for p in skill.certificate["critical_points"]]
    # Saddles to working precision: the last bits may differ between machines.
    np.testing.assert_allclose(
        found, [[p.x, p.y] for p in certificate.critical_points], atol=1e-9
    )


def test_there_is_a_shipped_skill():
    assert SHIPPED
