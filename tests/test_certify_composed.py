"""`bath-drake certify` of composed skills and of lists of fields."""

import json
from dataclasses import replace

import numpy as np
import pytest
from made_up_skill import composed_skill, crossing_chain, stage

from bath_drake.cli import main
from bath_drake.commands._certification import certify_file
from bath_drake.composition.certify import certify_chain
from bath_drake.composition.chain import Chain, Gate
from bath_drake.field_file import chains_to_mapping
from bath_drake.report import style
from bath_drake.report.chain_certificate_figure import draw_chain_certificates
from bath_drake.skill_file import certified, load_skill, save_skill
from bath_drake.yaml_io import dump_yaml

# A broadside ellipse with a trap behind it; before it, all is well.
TRAP = stage([1.2, 0.0], [[0.0, 0.0, 0.2, 0.8, 0.0]], kappa=2.0)


def passing(first_goal) -> Chain:
    """A field that leads to the trap's field through a gate ahead of its goal."""
    gate = Gate(np.subtract(first_goal, [0.03, 0.0]), np.array([1.0, 0.0]), 0.1)
    return Chain((stage(first_goal, []), TRAP), (gate,))


def two_ways():
    chain = crossing_chain()
    return composed_skill((chain, Chain(chain.fields[1:], chain.gates[1:])))


def saved(tmp_path, skill):
    path = tmp_path / "skill.yaml"
    save_skill(path, certified(skill, *map(certify_chain, skill.chains)))
    return path


def test_a_composed_skill_is_proved_as_its_file_says(tmp_path, capsys):
    path = saved(tmp_path, composed_skill())
    assert main(["certify", str(path)]) == 0
    found = json.loads(capsys.readouterr().out)
    in_file = load_skill(path).certificate
    assert {key: found[key] for key in in_file} == in_file
    assert found["verdict"] == "proved"
    assert found["witness"] is None
    assert found["seconds"] > 0.0
    assert [s["stage"] for s in found["stages"]] == [0, 1, 2]
    assert all(h["clearance"] > 0.0 for h in found["handovers"])
    assert len(found["simulated"]) == 3
    points = [p for s in found["stages"] for p in s["critical_points"]]
    assert len(found["critical_points"]) == len(points) == 3
    for point in found["critical_points"]:
        assert {"branch", "stage", "x", "y", "kind"} <= point.keys()


@pytest.mark.slow
def test_every_branch_of_a_skill_is_certified(tmp_path, capsys):
    path = saved(tmp_path, two_ways())
    certificate = tmp_path / "c.json"
    assert main(["certify", str(path), "-o", str(certificate)]) == 0
    assert "proved: 2 branches proved" in capsys.readouterr().out
    assert (tmp_path / "c.png").read_bytes().startswith(b"\x89PNG")
    found = json.loads(certificate.read_text())
    numbers = [(s["branch"], s["stage"]) for s in found["stages"]]
    assert numbers == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1)]
    assert [h["branch"] for h in found["handovers"]] == [0, 0, 1]


def test_a_conditioned_skill_is_certified_at_its_demonstrated_starts_too(
    tmp_path, capsys
):
    skill = composed_skill(conditioned=True)
    assert main(["certify", str(saved(tmp_path, skill))]) == 0
    found = json.loads(capsys.readouterr().out)
    (branch,) = skill.branches
    said = found["demonstrated_starts"]
    assert [[s["x"], s["y"]] for s in said] == branch.starts.tolist()
    for start, entry in zip(branch.starts, said, strict=True):
        own = certify_chain(branch.chain_for(start), start=start)
        assert entry["verdict"] == own.verdict
        assert entry["reason"] == own.reason


def test_a_list_of_fields_in_any_file_is_a_chain(tmp_path, capsys):
    path = tmp_path / "fields.yaml"
    path.write_text(dump_yaml({"field": chains_to_mapping([passing([0.7, 0.0])])}))
    assert main(["certify", str(path)]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "refuted"
    assert found["stages"][1]["verdict"] == "refuted"
    assert found["witness"] == found["stages"][1]["witness"]
    # Nothing is said of a start: there is none.
    assert "from_start" not in found
    assert "demonstrated_starts" not in found


@pytest.mark.parametrize(("goal", "verdict"), [(0.7, "proved"), (-1.2, "refuted")])
def test_a_skill_may_be_proved_from_its_start_alone(tmp_path, capsys, goal, verdict):
    path = saved(tmp_path, composed_skill((passing([goal, 0.0]),)))
    assert main(["certify", str(path)]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "refuted"
    # From before the ellipse the trap is out of reach, from behind it is not.
    assert found.get("from_start", found)["verdict"] == verdict
    if verdict == "proved":
        assert found["from_start"]["stages"][1]["region"] is not None


def test_a_composed_skill_is_renewed(tmp_path, capsys):
    skill = composed_skill()
    path = saved(tmp_path, skill)
    good = path.read_bytes()
    coarse = certify_chain(skill.chain, budget=3)
    save_skill(path, certified(skill, coarse))
    assert load_skill(path).certificate["verdict"] == "undecided"
    assert main(["certify", str(path), "--renew"]) == 0
    assert path.read_bytes() == good


def test_a_gate_in_an_obstacle_is_shown_where_it_is(tmp_path, capsys):
    chain = crossing_chain()
    wall = stage([0.05, 0.72], [[0.75, 0.15, 0.1, 0.1, 0.0]])
    chain = replace(chain, fields=(chain.fields[0], wall, chain.fields[2]))
    found = certify_file(str(saved(tmp_path, composed_skill((chain,)))), False)
    assert "refuted: gate 0: its point" in found.summary
    with style.figure_style():
        figure = draw_chain_certificates(found.chains, found.certificates, found.starts)
    panels = [axes for axes in figure.axes if axes.get_visible()]
    titles = [axes.get_title(loc="left") for axes in panels]
    assert titles == ["Stage 0: proved", "Stage 1: proved", "Stage 2: proved"]
    assert "Gate in: refuted" in " ".join(panels[1].get_xlabel().split())
    assert figure.get_suptitle().startswith("REFUTED: gate 0")
    (legend,) = figure.legends
    said = {text.get_text() for text in legend.get_texts()}
    assert {"obstacle", "saddle", "goal", "way of the start"} <= said
    assert {"gate in: hand-over from before", "starts that end at the goal"} <= said


def test_a_bad_list_is_one_line(tmp_path, capsys):
    data = chains_to_mapping([crossing_chain()])
    data[0]["gate"]["radius"] = -1.0
    path = tmp_path / "fields.yaml"
    path.write_text(dump_yaml({"field": data}))
    assert main(["certify", str(path)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "field[0].gate: radius must be positive" in said
