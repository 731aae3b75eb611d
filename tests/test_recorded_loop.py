"""What `simulate --record` keeps of a closed loop."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from write_wiring import made_up_skill, shipped_diagram

from bath_drake.block_diagram import wiring_lines
from bath_drake.diagrams import build_reproduction
from bath_drake.scenario import load_scenario


@pytest.mark.render
def test_the_frames_are_those_the_loop_sees():
    scenario = load_scenario("reproduction")
    scenario.scene.camera.noise = "kinect_v2"
    frames = []
    diagram = build_reproduction(
        scenario, made_up_skill(), write_frame=lambda *frame: frames.append(frame)
    )
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.07)
    context = simulator.get_context()
    assert [round(30 * t) for t, _, _ in frames] == [0, 1, 2]
    for _, colour, depth in frames:
        assert colour.max() > 200
        assert (depth > 0.0).mean() > 0.9
    # The noise the segmenter's frame had: that of the same instant.
    noise = diagram.GetSubsystemByName("kinect_noise")
    again = diagram.CreateDefaultContext()
    seen = noise.GetOutputPort("noisy_depth_image").Eval(
        noise.GetMyContextFromRoot(again)
    )
    np.testing.assert_array_equal(frames[0][2], seen.data[..., 0])
    segmenter = diagram.GetSubsystemByName("body_segmenter")
    observation = segmenter.GetOutputPort("body_observation")
    assert observation.Eval(segmenter.GetMyContextFromRoot(context)).found


def test_a_recorder_adds_its_own_wires_and_no_others():
    diagram = build_reproduction(
        load_scenario("reproduction"), made_up_skill(), write_frame=lambda *_: None
    )
    plain = set(wiring_lines(shipped_diagram("reproduction")))
    assert set(wiring_lines(diagram)) - plain == {
        "camera.color_image -> frame_recorder.colour_image",
        "camera.depth_image_32f -> frame_recorder.depth_image",
    }
    assert plain <= set(wiring_lines(diagram))


def test_noise_stands_between_the_camera_and_all_who_use_its_depth():
    scenario = load_scenario("reproduction")
    scenario.scene.camera.noise = "kinect_v2"
    lines = wiring_lines(build_reproduction(scenario, made_up_skill()))
    users = [line.split(" -> ")[1] for line in lines if "camera.depth_image" in line]
    assert users == ["kinect_noise.depth_image"]
    assert "kinect_noise.noisy_depth_image -> body_segmenter.depth_image" in lines
