"""Every row of the fault matrix does as it says; and the docs say the same."""

from pathlib import Path

import pytest
from write_fault_table import BEGIN, DOCS, END, expected_cells
from write_wiring import made_up_skill

from bath_drake.benchmarks.faults import (
    DAMAGED_SKILL,
    damaged_skill_row,
    fault_row,
    fault_scenarios,
    row_of,
)
from bath_drake.diagrams import build_reproduction
from bath_drake.errors import ScenarioError
from bath_drake.faults.script import SignalFault
from bath_drake.scenario import load_scenario

PATHS = fault_scenarios()
SCENARIOS = {path: load_scenario(path) for path in PATHS}
ROWS = 37


def row(path: Path) -> int:
    return SCENARIOS[path].expect.row


def test_every_row_but_that_of_a_damaged_skill_has_its_scenario():
    assert {row(path) for path in PATHS} == set(range(1, ROWS + 1)) - {DAMAGED_SKILL}
    for path in PATHS:
        assert int(path.name[:2]) == row(path)


def test_overlapping_areas_and_one_across_the_rim_alone_go_on():
    going = {row(p) for p in PATHS if SCENARIOS[p].expect.reaction == "go_on"}
    assert going == {18, 19}


def cases():
    """Every scenario; those through the camera take minutes together."""
    for path in PATHS:
        seen = SCENARIOS[path].perception.source == "camera"
        marks = (pytest.mark.exhaustive, pytest.mark.render) if seen else ()
        yield pytest.param(path, id=path.stem, marks=marks)


@pytest.mark.faults
@pytest.mark.slow
@pytest.mark.parametrize("path", [*cases()])
def test_a_fault_leads_to_what_its_row_says(path):
    found = fault_row(path)
    assert found["as expected"], found


def test_a_damaged_skill_is_refused_by_its_file():
    assert damaged_skill_row()["as expected"]


def test_the_docs_hold_what_is_expected_of_every_row():
    table = DOCS.read_text("utf-8").split(BEGIN)[1].split(END)[0]
    told = [line.split(" | ")[:4] for line in table.splitlines()[2:]]
    rows = [row_of(SCENARIOS[path].expect) for path in PATHS] + [damaged_skill_row()]
    assert [[cells[0].strip("| "), *cells[1:]] for cells in told] == [
        expected_cells(row) for row in rows
    ]


@pytest.mark.parametrize(
    ("port", "message"),
    [
        ("nobody.says", "found no system 'nobody'"),
        ("differential_ik.nothing", "found no port 'nothing' of differential_ik"),
        ("approach_sequencer.phase", None),
        ("body_segmenter.body_observation", "allowed a vector"),
    ],
)
def test_a_fault_at_a_port_that_is_none_is_refused_by_its_key(port, message):
    scenario = load_scenario("reproduction")
    scenario.perception.source = "ideal"
    scenario.faults.signals = [SignalFault(port=port)]
    if message is None:
        build_reproduction(scenario, made_up_skill())
        return
    with pytest.raises(ScenarioError, match=message):
        build_reproduction(scenario, made_up_skill())


def test_a_fault_stands_before_all_readers_but_the_log():
    scenario = load_scenario("reproduction")
    scenario.perception.source = "ideal"
    scenario.faults.signals = [SignalFault(port="differential_ik.joint_command")]
    diagram = build_reproduction(scenario, made_up_skill())
    giver = "fault_differential_ik_joint_command"
    fed = {
        system.get_name(): source.get_name()
        for (system, port), (source, _) in diagram.connection_map().items()
        if system.get_input_port(port).get_name() == "joint_command"
        or system.get_name().startswith("log_differential_ik")
    }
    assert fed["joint_guard"] == giver
    assert fed["self_distance"] == fed["obstacle_distance"] == giver
    assert fed["log_differential_ik_joint_command"] == "differential_ik"
