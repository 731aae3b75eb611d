from dataclasses import replace

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_skill import (
    FRAME,
    composed_skill,
    crossing_chain,
    old_mapping,
    single_branch,
    with_branch,
)

from bath_drake.certificate.result import Certificate
from bath_drake.certificate_file import content_checksum
from bath_drake.composition.certify import certify_chain
from bath_drake.composition.chain import Chain
from bath_drake.composition.result import ChainCertificate, Handover, whole_verdict
from bath_drake.demonstrations.canonical import CanonicalFrame
from bath_drake.errors import SkillFileError
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field_file import field_from_mapping, field_to_mapping
from bath_drake.learning.skill import Skill
from bath_drake.resources import models_folder
from bath_drake.skill_file import (
    certified,
    is_skill_file,
    load_chains,
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


def made_up_branch(field=None):
    field = field or field_from_mapping(parse_yaml(FIELD_FILE)["field"])
    start = np.array([-0.1 - 0.2, 1e-17])
    return single_branch(field, start, np.array([start, [0.1, 0.7], [1 / 3, 0.0]]))


def make_skill(field=None, **changes):
    values = {
        "branches": (made_up_branch(field),),
        "seed": 2**63,
        "config": {"method": "auto", "obstacles": None, "margins": {"pair": 0.04}},
        "demonstration_hashes": ("ab" * 32, "cd" * 32),
        "canonical": FRAME,
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
    names = ("seed", "config", "demonstration_hashes", "scale", "frechet", "finished")
    for name in (*names, "certificate"):
        assert getattr(back, name) == getattr(skill, name)
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


@pytest.fixture(params=[False, True], ids=["fixed", "conditioned"])
def composed(request, tmp_path):
    """A skill of two branches, of three fields and of one, and its file."""
    loop = crossing_chain()
    skill = composed_skill([loop, Chain(loop.fields[:1])], conditioned=request.param)
    skill = certified(replace(skill, finished=False), *proofs(skill))
    path = tmp_path / "composed.yaml"
    save_skill(path, skill)
    return skill, path


def proofs(skill):
    gate = Handover("proved", "free", clearance=0.1 + 0.2)
    return [
        ChainCertificate((CERTIFICATE,) * len(chain), (gate,) * (len(chain) - 1))
        for chain in skill.chains
    ]


def test_a_composed_skill_comes_back_to_the_last_bit(composed, tmp_path):
    skill, path = composed
    back = load_skill(path)
    assert back.chains == load_chains(path) == skill.chains
    assert skill_to_mapping(back) == skill_to_mapping(skill)
    assert not back.finished
    save_skill(tmp_path / "again.yaml", back)
    assert (tmp_path / "again.yaml").read_bytes() == path.read_bytes()
    # What is read moves as what was written.
    start, goal = skill.start + 0.03, skill.chain.goal + 0.02
    assert back.chain_for(start, goal) == skill.chain_for(start, goal)


def test_a_composed_skill_is_no_single_field(composed):
    skill, path = composed
    assert not skill.is_single
    assert skill.obstacle_count == 4
    with pytest.raises(ValueError, match="4 fields has no single field"):
        _ = skill.field
    with pytest.raises(SkillFileError, match="field: found 4 fields, expected one"):
        load_field(path)


def test_the_branch_that_was_shown_nearest_to_the_start_is_taken():
    skill = make_skill()
    far = single_branch(skill.field, np.array([2.0, 2.0]))
    skill = replace(skill, branches=(*skill.branches, far))
    assert skill.branch_for([1.9, 1.0]) is far
    assert skill.branch_for(skill.start) is skill.branches[0]
    assert skill.chain_for([1.9, 1.0]) == far.chain


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda d: d["field"][1].pop("gate"),
            r"field\[2\].branch: found 0, expected 1",
        ),
        (lambda d: d["field"].pop(), r"branches: found 2, the fields make up 1"),
        (
            lambda d: d["field"][0].update(kappa=3.0),
            r"certificate.field_checksum: .* another field",
        ),
        (
            lambda d: d["branches"][0].update(start=d["branches"][1]["start"][::-1]),
            "start: found .*, the first branch has",
        ),
    ],
)
def test_a_composed_skill_that_does_not_fit_together_is_refused(
    composed, tmp_path, change, message
):
    data = skill_to_mapping(composed[0])
    change(data)
    path = written(tmp_path / "changed.yaml", data)
    with pytest.raises(SkillFileError, match=message):
        load_skill(path)


@pytest.mark.parametrize("composed", [True], indirect=True)
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c.pop("width"), "width: is missing"),
        (lambda c: c.update(width=0.0), "width must be positive"),
        (lambda c: c.update(width=1, more=2), "more: unknown key"),
        (lambda c: c["pivots"].pop(), "pivots: found 2 items, expected 3"),
        (lambda c: c["coefficients"].pop(), "coefficients: found 11 items, expected"),
        (lambda c: c["coefficients"][3].pop(), r"\[3\]: found 5 items, expected 6"),
        (lambda c: c["starts"].pop(), r"\[0\]: found 6 items, expected 5"),
    ],
)
def test_a_bad_conditioning_is_refused_by_key(composed, tmp_path, change, message):
    data = skill_to_mapping(composed[0])
    change(data["branches"][0]["conditioning"])
    path = written(tmp_path / "changed.yaml", data)
    message = r"branches\[0\].conditioning.*" + message
    with pytest.raises(SkillFileError, match=message):
        load_skill(path)


def test_a_skill_needs_a_branch_and_a_certificate_for_each():
    skill = make_skill()
    with pytest.raises(ValueError, match="at least one branch"):
        replace(skill, branches=())
    for wrong in ([], [CERTIFICATE] * 2, proofs(composed_skill())):
        with pytest.raises(ValueError, match="not of the skill's branches"):
            certified(skill, *wrong)


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
        (lambda d: d.update(schema_version=4), "schema_version: found 4, .* 2 and 3$"),
        (lambda d: d.update(extra=1), "extra: unknown key, allowed: schema_version"),
        (lambda d: d.update(start=[1.0]), "start: found 1 items, expected 2"),
        (lambda d: d.update(start=[1.0, 2.0]), "start: found .* first branch has"),
        (lambda d: d.update(finished="yes"), "finished: found 'yes', expected true"),
        (lambda d: d.update(branches=[]), "branches: found 0, the fields make up 1"),
        (lambda d: d["branches"][0].pop("starts"), r"branches\[0\].starts: is missing"),
        (
            lambda d: d["branches"][0].update(mean_demonstration=[[0, 1]]),
            r"branches\[0\]: mean has shape",
        ),
        (
            lambda d: d["branches"][0].update(conditioning=1),
            r"branches\[0\].conditioning: found 1, expected a mapping",
        ),
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
    other = with_branch(skill, field=replace(skill.field, kappa=9.0))
    with pytest.raises(SkillFileError, match="about another field"):
        save_skill(tmp_path / "skill.yaml", other)
    with pytest.raises(SkillFileError, match=r"field_checksum: is missing"):
        save_skill(tmp_path / "skill.yaml", replace(skill, certificate={}))
    assert list(tmp_path.iterdir()) == []


def test_a_skill_of_version_1_is_refused_with_the_way_to_renew_it(tmp_path):
    skill = make_skill()
    old = old_mapping(skill, version=1)
    old["certificate"] = {"verdict": "numeric-pass", "critical_points": []}
    path = written(tmp_path / "skill.yaml", old)
    with pytest.raises(SkillFileError, match=r"found 1, .*reads 2 and 3; .* --renew"):
        load_skill(path)
    renewed = certified(load_skill(path, renew=True), CERTIFICATE)
    save_skill(path, renewed)
    assert load_skill(path).field == skill.field
    assert load_skill(path).certificate == skill.certificate


def test_a_skill_of_version_2_is_read_as_it_is(tmp_path):
    skill = make_skill()
    back = load_skill(written(tmp_path / "skill.yaml", old_mapping(skill)))
    assert skill_to_mapping(back) == skill_to_mapping(skill)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_shipped_skill_is_proved_by_the_proof_of_today(path):
    skill = load_skill(path)
    chains = [certify_chain(chain) for chain in skill.chains]
    assert whole_verdict(chains)[0] == skill.certificate["verdict"] == "proved"
    blocks = [skill.certificate] if skill.is_single else skill.certificate["stages"]
    stages = [stage for chain in chains for stage in chain.stages]
    for block, stage in zip(blocks, stages, strict=True):
        found = np.array([[p["x"], p["y"]] for p in block["critical_points"]])
        expected = np.array([[p.x, p.y] for p in stage.critical_points])
        # To working precision: the last bits may differ between machines.
        np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_shipped_skill_is_proved_from_its_demonstrated_starts(path):
    for branch in load_skill(path).branches:
        for start in branch.starts:
            assert certify_chain(branch.chain_for(start)).passed


def test_there_is_a_shipped_skill():
    assert SHIPPED
