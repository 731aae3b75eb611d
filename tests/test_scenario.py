import dataclasses

import pytest

from bath_drake.carer.config import CarerConfig
from bath_drake.errors import ScenarioError
from bath_drake.resources import diagrams_folder
from bath_drake.scenario import (
    Scenario,
    approach_limits,
    dump_scenario,
    find_demonstration,
    load_scenario,
    loop_bounds,
)
from bath_drake.scene.config import WoundConfig
from bath_drake.systems.hold_supervisor import MAX_FRAME_AGE

SHIPPED = sorted(path.name for path in diagrams_folder().glob("*.yaml"))


@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_scenario_loads_by_its_name(name):
    assert load_scenario(name).description


def test_a_written_scenario_reads_back_the_same(tmp_path):
    scenario = Scenario(description="x", duration=7.5)
    scenario.scene.wound = WoundConfig(centre=[0.1, 1e-3])
    scenario.scene.carer = CarerConfig(waypoints=[[0.5, 0], [0.25, 1e-3]])
    scenario.limits.frechet_executed = None
    path = tmp_path / "scenario.yaml"
    path.write_text(dump_scenario(scenario))
    assert load_scenario(path) == scenario


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("foo: 1\n", "foo: unknown key"),
        ("control: {washing_sped: 0.1}\n", "control.washing_sped: unknown key"),
        ("control: {washing_speed: 1}\n", "control.washing_speed: found 1.0, allowed"),
        ("control: {washing_speed: fast}\n", "control.washing_speed: found 'fast'"),
        ("control: 3\n", "control: found 3"),
        ("control: {min_clearance: 0.06}\n", "control.min_clearance"),
        ("control: {far_standoff: 0.05}\n", "far_standoff"),
        ("scene: {wound: {centre: [1]}}\n", "wound.centre must be 2"),
        ("scene: {camera: {eye: 3}}\n", "scene.camera.eye: found 3"),
        ("scene: {camera: {noise: loud}}\n", "camera.noise: found 'loud', allowed"),
        ("scene: {carer: {waypoints: [[0, 0], [a, 1]]}}\n", "waypoints[1][0]: found"),
        ("scene: {carer: {swing: 9}}\n", "scene: carer.swing: found 9.0, allowed"),
        ("duration: 1e9\n", "duration: found 1000000000.0, allowed"),
        ("random_seed: -1\n", "random_seed: found -1"),
        ("random_seed: 1.5\n", "random_seed: found 1.5"),
        ("limits: {frechet_executed: -1}\n", "limits.frechet_executed: found -1"),
        ("- a\n", "found list"),
        ("", "scenario.yaml"),
        ("a: [\n", "line 2"),
    ],
)
def test_a_bad_scenario_is_refused_by_file_and_key(tmp_path, text, message):
    path = tmp_path / "scenario.yaml"
    path.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert str(path) in str(caught.value)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_shipped_demonstrations_are_found_by_name_in_their_folders_too():
    for name in ("back_sinusoid_1.csv", "strokes/s_curve_1.csv"):
        assert find_demonstration(name).is_file()
    # What leaves the folder is a path, and taken as one.
    for name in ("../demonstrations/back_sinusoid_1.csv", "no_such.csv"):
        assert str(find_demonstration(name)) == name


def test_an_unknown_scenario_lists_the_shipped_ones():
    with pytest.raises(ScenarioError, match=r"reproduction\.yaml"):
        load_scenario("no_such_scenario")


def test_the_careful_defaults_are_those_of_bathing_practice():
    control = Scenario().control
    assert control.washing_speed <= 0.10
    assert control.approach_speed <= 0.05
    assert control.max_frame_age == MAX_FRAME_AGE


def test_the_pure_limits_carry_the_scenario_values():
    scenario = Scenario()
    limits, bounds = approach_limits(scenario), loop_bounds(scenario)
    assert limits.standoff == scenario.control.standoff
    assert bounds == dataclasses.replace(bounds, duration=scenario.duration)
