"""Perception on a folder of images, drawn or filmed: what it sees and says."""

import json

import numpy as np
import pytest
from made_up_carer import BREADTH, DISTANCE, FRAMES, RATE, write_recording
from pydrake.systems.analysis import Simulator
from write_wiring import made_up_skill

from bath_drake import cli
from bath_drake.demonstrations.rgbd.folder import open_rgbd
from bath_drake.demonstrations.rgbd.writer import RgbdWriter
from bath_drake.diagrams import build_reproduction
from bath_drake.diagrams.block_diagram import wiring_lines
from bath_drake.diagrams.recorded_perception import build_recorded_perception, perceive
from bath_drake.scenario import Scenario, load_scenario

# The drawn camera looks along +y of W, level, from a metre high.
X_WC = [[1, 0, 0, 0], [0, 0, 1, -DISTANCE], [0, -1, 0, 1.0], [0, 0, 0, 1]]
WORKSPACE = ("-0.6", "-0.4", "0.5", "0.6", "0.4", "1.6")


def posed(folder):
    """Tells a drawn recording where its camera stood."""
    path = folder / "intrinsics.json"
    numbers = json.loads(path.read_text())
    path.write_text(json.dumps(numbers | {"X_WC": X_WC}))
    return folder


def drawn_scenario():
    scenario = Scenario()
    scenario.perception.workspace_low = [float(x) for x in WORKSPACE[:3]]
    scenario.perception.workspace_high = [float(x) for x in WORKSPACE[3:]]
    return scenario


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drawn") / "film"
    return posed(write_recording(folder, marker=None))


@pytest.fixture(scope="module")
def perceived(drawn):
    return perceive(open_rgbd(drawn), drawn_scenario())


def test_every_frame_is_seen_once_with_its_own_time(perceived):
    times = [frame.t for frame in perceived]
    np.testing.assert_allclose(times, np.arange(FRAMES) / RATE, atol=1e-6)


def test_the_back_is_found_where_it_was_drawn(perceived):
    for frame in perceived[1:]:
        assert frame.observation.found
        x, y, z = frame.canonical_map.p_WP
        # It sways by some millimetres; a hand hides parts of it.
        assert abs(x) < 0.04
        # Between the barrel's axis and its front, 12 cm before it.
        assert -0.13 < y < 0.0
        assert abs(z - 1.0) < 0.05
        # The barrel's width, 1 % left out at either end, flanks seen flat.
        assert 0.8 * BREADTH < frame.canonical_map.half_extents[0] < 1.05 * BREADTH


def test_its_wiring_is_that_of_perception_without_scene_or_robot(drawn):
    diagram = build_recorded_perception(open_rgbd(drawn), drawn_scenario())
    assert wiring_lines(diagram) == [
        "body_segmenter.body_observation -> canonical_projector.body_observation",
        "body_segmenter.body_observation -> restricted_area_detector.body_observation",
        "canonical_projector.canonical_map -> restricted_area_detector.canonical_map",
        "rgbd_recording.colour_image -> body_segmenter.colour_image",
        "rgbd_recording.depth_image -> body_segmenter.depth_image",
        "rgbd_recording.frame_stamp -> body_segmenter.frame_stamp",
    ]


@pytest.mark.render
def test_a_recorded_loop_is_seen_as_it_was_live(tmp_path):
    scenario = load_scenario("restricted_area")
    camera = scenario.scene.camera
    # Whole millimetres, which a file keeps.
    camera.noise = "kinect_v2"
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = camera.rotation(), camera.eye
    writer = RgbdWriter(tmp_path / "film", camera.pinhole(), pose)
    diagram = build_reproduction(scenario, made_up_skill(), write_frame=writer.write)
    simulator = Simulator(diagram)
    # The areas of the last frame come 2 ms after it.
    simulator.AdvanceTo(0.104)

    def live(system, port):
        subsystem = diagram.GetSubsystemByName(system)
        own = subsystem.GetMyContextFromRoot(simulator.get_context())
        return subsystem.GetOutputPort(port).Eval(own)

    observation = live("body_segmenter", "body_observation")
    seen = live("canonical_projector", "canonical_map")
    areas = live("restricted_area_detector", "sensed_obstacles")
    last = perceive(open_rgbd(tmp_path / "film"), scenario)[-1]
    assert last.t == pytest.approx(observation.stamp, abs=1e-6)
    # The arm is not masked, but it is not in sight of the back yet; what is left is
    # the last bit of a float32.
    assert (last.observation.mask ^ observation.mask).sum() < 10
    assert last.observation.area == pytest.approx(observation.area, rel=1e-3)
    np.testing.assert_allclose(last.canonical_map.p_WP, seen.p_WP, atol=1e-4)
    np.testing.assert_allclose(
        last.canonical_map.half_extents, seen.half_extents, rtol=1e-3
    )
    assert len(last.areas) == len(areas) == 1
    np.testing.assert_allclose(last.areas.theta, areas.theta, atol=1e-3)


def command(capsys, *words):
    try:
        code = cli.main(["perceive", *map(str, words)])
    except SystemExit as stop:
        code = stop.code
    return code, *capsys.readouterr()


def test_the_command_writes_a_row_a_frame(capsys, drawn, perceived, tmp_path):
    path = tmp_path / "seen.csv"
    code, out, _ = command(capsys, drawn, "--workspace", *WORKSPACE, "-o", path)
    assert code == 0
    assert f"{FRAMES} of {FRAMES} seen" in out
    table = np.genfromtxt(path, delimiter=",", names=True)
    np.testing.assert_allclose(table["t_s"], [f.t for f in perceived], atol=1e-6)
    np.testing.assert_array_equal(
        table["found"], [f.observation.found for f in perceived]
    )
    last = perceived[-1].canonical_map
    found = [table[-1][name] for name in ("x_m", "y_m", "z_m", "half_x_m", "half_y_m")]
    # Five decimals.
    np.testing.assert_allclose(found, [*last.p_WP, *last.half_extents], atol=6e-6)


def test_where_there_is_no_back_the_command_says_so(capsys, drawn):
    code, out, _ = command(capsys, drawn, "--workspace", 5, 5, 5, 6, 6, 6)
    assert code == 1
    assert "found in 0 frames" in out
    assert "--workspace" in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--workspace", 1, 1, 1, 0, 0, 0), "--workspace: perception.workspace"),
        (("-o", "table.txt"), "expected a name that ends in .csv"),
        (("--scenario", "no_such"), "no such scenario"),
    ],
)
def test_bad_options_are_told_on_one_line(capsys, drawn, words, message):
    code, _, err = command(capsys, drawn, *words)
    assert code == 2
    assert message in err
    assert err.count("\n") == 1


def test_a_table_is_not_written_into_the_recording(capsys, drawn):
    code, _, err = command(capsys, drawn, "-o", drawn / "timestamps.csv")
    assert code == 2
    assert "is inside the recording" in err
    assert len(open_rgbd(drawn)) == FRAMES


def test_without_the_cameras_pose_nothing_can_be_placed(capsys, tmp_path):
    folder = write_recording(tmp_path / "film", frames=2)
    code, _, err = command(capsys, folder)
    assert code == 2
    assert "intrinsics.json: X_WC: is missing" in err
