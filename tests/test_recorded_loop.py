"""What `simulate --record` keeps of a closed loop."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from write_wiring import made_up_skill

from bath_drake.diagrams import build_reproduction
from bath_drake.diagrams.block_diagram import wiring_lines
from bath_drake.scenario import load_scenario


@pytest.fixture(scope="module")
def recorded():
    """A noisy loop's Diagram and the list that its frames go to."""
    scenario = load_scenario("reproduction")
    scenario.scene.camera.noise = "kinect_v2"
    frames = []
    diagram = build_reproduction(
        scenario, made_up_skill(), write_frame=lambda *frame: frames.append(frame)
    )
    return diagram, frames


def output(diagram, context, system, port):
    subsystem = diagram.GetSubsystemByName(system)
    own = subsystem.GetMyContextFromRoot(context)
    return subsystem.GetOutputPort(port).Eval(own)


@pytest.mark.render
def test_the_frames_are_those_the_loop_sees(recorded):
    diagram, frames = recorded
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.07)
    assert [round(30 * t) for t, _, _ in frames] == [0, 1, 2]
    for _, colour, depth in frames:
        assert colour.max() > 200
        assert (depth > 0.0).mean() > 0.9
    context = simulator.get_context()
    observation = output(diagram, context, "body_segmenter", "body_observation")
    assert observation.found
    # The noise, too, is that of the same instant.
    again = diagram.CreateDefaultContext()
    seen = output(diagram, again, "depth_noise", "noisy_depth_image")
    np.testing.assert_array_equal(frames[0][2], seen.data[..., 0])


def test_recorder_and_noise_add_their_own_wires_and_move_one(recorded):
    diagram, _ = recorded
    quiet = load_scenario("reproduction")
    quiet.scene.camera.noise = "none"
    plain = set(wiring_lines(build_reproduction(quiet, made_up_skill())))
    noisy = set(wiring_lines(diagram))
    assert noisy - plain == {
        "camera.color_image -> frame_recorder.colour_image",
        "camera.depth_image_32f -> depth_noise.depth_image",
        "depth_noise.noisy_depth_image -> body_monitor.depth_image",
        "depth_noise.noisy_depth_image -> body_segmenter.depth_image",
        "depth_noise.noisy_depth_image -> camera_monitor.depth_image",
        "depth_noise.noisy_depth_image -> frame_monitor.depth_image",
        "depth_noise.noisy_depth_image -> frame_recorder.depth_image",
    }
    assert plain - noisy == {
        f"camera.depth_image_32f -> {taker}.depth_image"
        for taker in (
            "body_monitor",
            "body_segmenter",
            "camera_monitor",
            "frame_monitor",
        )
    }
