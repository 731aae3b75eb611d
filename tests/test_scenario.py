import dataclasses

import pytest

from bath_drake.carer.config import CarerConfig
from bath_drake.errors import ScenarioError
from bath_drake.perception.colour_noise import ColourNoiseConfig
from bath_drake.perception.depth_sensor import CAMERA_MODELS
from bath_drake.perception.faults import LateFault
from bath_drake.resources import diagrams_folder
from bath_drake.scenario import (
    Scenario,
    approach_limits,
    check_scenario,
    dump_scenario,
    find_demonstration,
    load_scenario,
    loop_bounds,
)
from bath_drake.scene.config import CameraConfig, WoundConfig

SHIPPED = sorted(path.name for path in diagrams_folder().glob("*.yaml"))


@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_scenario_loads_by_its_name(name):
    assert load_scenario(name).description


def test_a_written_scenario_reads_back_the_same(tmp_path):
    scenario = Scenario(description="x", duration=7.5)
    scenario.scene.wound = WoundConfig(centre=[0.1, 1e-3])
    scenario.scene.carer = CarerConfig(waypoints=[[0.5, 0], [0.25, 1e-3]])
    scenario.limits.frechet_executed = None
    scenario.scene.camera.colour_noise = ColourNoiseConfig(exposure=1.5)
    path = tmp_path / "scenario.yaml"
    path.write_text(dump_scenario(scenario))
    assert load_scenario(path) == scenario
    scenario.scene.carer = None
    scenario.scene.camera.faults.late = LateFault(delay=0.05)
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
        (
            "perception: dream\n",
            "perception.source: found 'dream', allowed camera, ide",
        ),
        ("perception: 3\n", "perception: found 3, expected a mapping"),
        (
            "perception: ideal\nscene: {camera: {faults: {loss: {}}}}\n",
            "perception.source: found 'ideal', allowed camera where there is scene.",
        ),
        (
            "scene: {arm: {fidelity: toy}}\n",
            "scene: arm.fidelity: found 'toy', allowed: dynamic, kinematic",
        ),
        ("scene: {camera: {model: lidar}}\n", "scene.camera.model: found 'lidar'"),
        ("scene: {camera: {colour_noise: {read: -1}}}\n", "colour_noise.read: found"),
        ("scene: {camera: {faults: {rain: {}}}}\n", "camera.faults.rain: unknown key"),
        ("scene: {camera: {faults: {late: {delay: 9}}}}\n", "faults.late.delay: found"),
        (
            "scene: {carer: {waypoints: [[0, 0], [1, 1]]}, "
            "camera: {faults: {loss: {}}}}\n",
            "camera.faults: a filmed carer's camera has none",
        ),
        ("scene: {carer: {waypoints: [[0, 0], [a, 1]]}}\n", "waypoints[1][0]: found"),
        ("scene: {carer: {swing: 9}}\n", "scene: carer.swing: found 9.0, allowed"),
        (
            "perception: {canonical_map: round}\n",
            "perception.canonical_map: found 'round', allowed tracked, affine",
        ),
        (
            "perception: {segmenter: magic}\n",
            "perception.segmenter: found 'magic', allowed classic, neural",
        ),
        ("perception: {onnx_mask: hair}\n", "perception.onnx_mask: found 'hair'"),
        ("duration: 1e9\n", "duration: found 1000000000.0, allowed"),
        ("random_seed: -1\n", "random_seed: found -1"),
        ("random_seed: 1.5\n", "random_seed: found 1.5"),
        ("limits: {frechet_executed: -1}\n", "limits.frechet_executed: found -1"),
        ("limits: {coverage: 95}\n", "limits.coverage: found 95.0, allowed 0.0 to 1.0"),
        ("washing: {tool: mop}\n", "washing.tool: found 'mop', allowed jet, sponge"),
        ("washing: {half_angle: 2}\n", "washing.half_angle: found 2.0, allowed"),
        ("washing: {spared: -1}\n", "washing.spared: found -1.0, allowed"),
        ("washing: {target_low: [-1, 0]}\n", "washing.target_high: found null"),
        ("washing: {target_low: [-2, 0]}\n", "washing.target_low: found [-2.0, 0.0]"),
        (
            "washing: {target_low: [0, 0], target_high: [0.5, 0]}\n",
            "washing.target_high: found [0.5, 0.0], allowed more than target_low",
        ),
        ("strokes: [{start: [0, 0, 1]}]\n", "strokes[0].start: found [0.0, 0.0, 1.0]"),
        (
            "strokes: [{start: [0, 0], goal: [0, 0.01]}]\n",
            "strokes[0].goal: found [0.0, 0.01], allowed 0.05 or more",
        ),
        ("strokes: [{begin: [0, 0]}]\n", "begin: unknown key"),
        ("lanes: {spacing: 0}\n", "lanes.spacing: found 0.0, allowed 0.05 to 1.0"),
        ("lanes: {low: [0, 2]}\n", "lanes.low: found [0.0, 2.0], allowed two numbers"),
        ("lanes: {high: [0, -0.6]}\n", "lanes.high: found [0.0, -0.6], allowed more"),
        ("lanes: {}\nstrokes: [{}]\n", "lanes: found beside strokes, allowed one"),
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


@pytest.mark.parametrize("name", CAMERA_MODELS)
def test_a_cameras_name_fills_in_its_numbers_but_for_those_given(tmp_path, name):
    path = tmp_path / "scenario.yaml"
    path.write_text(f"scene: {{camera: {{model: {name}, far: 2.5, noise: none}}}}\n")
    camera = load_scenario(path).scene.camera
    assert camera.pinhole() == CAMERA_MODELS[name].camera
    assert camera.near == CAMERA_MODELS[name].sensor.near
    assert (camera.far, camera.noise) == (2.5, "none")
    path.write_text(f"scene: {{camera: {{model: {name}}}}}\n")
    whole = load_scenario(path)
    assert whole.scene.camera.noise == name
    assert whole.scene.camera.far == CAMERA_MODELS[name].sensor.far
    # What is written says it all, and means the same.
    path.write_text(dump_scenario(whole))
    assert load_scenario(path) == whole


def test_a_camera_without_a_name_is_as_it_always_was(tmp_path):
    path = tmp_path / "scenario.yaml"
    path.write_text("scene: {camera: {far: 3.0}}\n")
    assert load_scenario(path).scene.camera == CameraConfig(far=3.0)
    assert CameraConfig().pinhole() == CAMERA_MODELS["kinect_v2"].camera
    assert CameraConfig().noise == "none"
    assert not CameraConfig().faults.any


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
    # Two camera periods pass by themselves; three would be 100 ms.
    assert control.max_frame_age <= 0.1


def test_the_pure_limits_carry_the_scenario_values():
    scenario = Scenario()
    limits, bounds = approach_limits(scenario), loop_bounds(scenario)
    assert limits.standoff == scenario.control.standoff
    assert bounds == dataclasses.replace(bounds, duration=scenario.duration)


def test_a_given_area_that_is_no_polygon_is_named():
    scenario = Scenario()
    scenario.perception.restricted_areas = [
        [[0.0, 0.0], [0.2, 0.0], [0.1, 0.2]],
        [[0.0, 0.0], [0.2, 0.0]],
    ]
    with pytest.raises(
        ValueError, match=r"perception\.restricted_areas: polygon 2: .* 3 corners"
    ):
        check_scenario(scenario)


def test_given_areas_are_written_and_read_back(tmp_path):
    scenario = Scenario()
    triangle = [[0.0, 0.0], [0.2, 0.0], [0.1, 0.25]]
    scenario.perception.restricted_areas = [triangle, triangle[::-1]]
    path = tmp_path / "given.yaml"
    path.write_text(dump_scenario(scenario), encoding="utf-8")
    assert load_scenario(path) == scenario


def test_a_word_may_stand_for_the_source_of_perception(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_text("perception: ideal\n", encoding="utf-8")
    short = load_scenario(path)
    path.write_text("perception: {source: ideal}\n", encoding="utf-8")
    assert short == load_scenario(path)
    assert short.perception.source == "ideal"
    path.write_text(dump_scenario(short), encoding="utf-8")
    assert load_scenario(path) == short
