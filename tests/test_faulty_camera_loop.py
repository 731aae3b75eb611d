"""The whole loop behind a camera whose frames stop, or come late."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from write_wiring import made_up_skill

from bath_drake.diagrams import build_reproduction
from bath_drake.diagrams.block_diagram import wiring_lines
from bath_drake.perception.colour_noise import ColourNoiseConfig
from bath_drake.perception.faults import FrameFault, LateFault
from bath_drake.safety.reasons import Reason
from bath_drake.scenario import load_scenario
from bath_drake.simulation import run
from bath_drake.verification import evaluate

FRAME = 1.0 / 30.0


def quiet_scenario():
    """The first experiment with a camera that has no noise."""
    scenario = load_scenario("reproduction")
    scenario.scene.camera.noise = "none"
    return scenario


def loop(**faults):
    scenario = quiet_scenario()
    for name, fault in faults.items():
        setattr(scenario.scene.camera.faults, name, fault)
    return build_reproduction(scenario, made_up_skill())


def output(diagram, context, system, port):
    subsystem = diagram.GetSubsystemByName(system)
    own = subsystem.GetMyContextFromRoot(context)
    return subsystem.GetOutputPort(port).Eval(own)


def watched(diagram, until, step=0.02):
    """Time, hold reason, age of the frame and joint command, every `step` seconds."""
    simulator = Simulator(diagram)
    rows = []
    for k in range(1, round(until / step) + 1):
        simulator.AdvanceTo(k * step)
        context = simulator.get_context()
        t = context.get_time()
        reason = output(diagram, context, "joint_guard", "present_reason")[0]
        observation = output(diagram, context, "body_segmenter", "body_observation")
        command = output(diagram, context, "differential_ik", "joint_command")
        rows.append((t, reason, t - observation.stamp, command.copy()))
    return rows


@pytest.mark.render
def test_the_robot_holds_while_no_frames_come_and_goes_on_after():
    begin, end = 0.3, 0.6
    rows = watched(loop(loss=FrameFault(begin=begin, end=end)), 1.0)
    for t, reason, age, _ in rows:
        # The last frame before the gap is stale after 0.1 s.
        if begin + 0.1 < t < end:
            assert reason == Reason.FRAME_STALE
            assert age > 0.1
        if t > end + FRAME or 0.1 < t < begin:
            assert reason == Reason.NONE
    # At most 1.31 rad/s here; at 10 rad/s^2 the guard brakes within 0.14 s.
    held = [command for t, _, _, command in rows if begin + 0.24 < t < end + 0.2]
    for command in held[1:]:
        np.testing.assert_array_equal(command, held[0])
    before, after = rows[10][3], rows[-1][3]
    assert np.abs(before[:7] - held[0][:7]).max() > 0.0
    assert np.abs(after[:7] - held[0][:7]).max() > 0.0


@pytest.mark.render
@pytest.mark.parametrize(
    ("delay", "reason"), [(FRAME, Reason.NONE), (0.2, Reason.FRAME_STALE)]
)
def test_a_late_frame_is_as_old_as_it_is(delay, reason):
    rows = watched(loop(late=LateFault(delay=delay)), 0.4)
    for t, found, age, _ in rows:
        if t > 0.3:
            assert delay - 1e-9 <= age <= delay + 1.01 * FRAME
            assert found == reason


def test_faults_stand_between_the_camera_and_all_who_look_at_its_frames():
    plain = set(wiring_lines(loop()))
    faulty = set(wiring_lines(loop(frozen=FrameFault(begin=1.0))))
    assert faulty - plain == {
        "arm_position.y0 -> camera_faults.arm_position",
        "camera.color_image -> camera_faults.colour_image",
        "camera.depth_image_32f -> camera_faults.depth_image",
        "camera_faults.arm_position -> body_segmenter.arm_position",
        "camera_faults.arm_position -> camera_monitor.arm_position",
        "camera_faults.colour_image -> body_segmenter.colour_image",
        "camera_faults.depth_image -> body_segmenter.depth_image",
        "camera_faults.depth_image -> body_monitor.depth_image",
        "camera_faults.depth_image -> camera_monitor.depth_image",
        "camera_faults.depth_image -> frame_monitor.depth_image",
        "camera_faults.frame_stamp -> body_segmenter.frame_stamp",
        "camera_faults.frame_stamp -> frame_monitor.frame_stamp",
    }
    assert len(plain - faulty) == 7


def test_colour_noise_is_one_more_system_on_its_way():
    scenario = quiet_scenario()
    scenario.scene.camera.colour_noise = ColourNoiseConfig()
    noisy = set(wiring_lines(build_reproduction(scenario, made_up_skill())))
    plain = set(wiring_lines(loop()))
    assert noisy - plain == {
        "camera.color_image -> colour_noise.colour_image",
        "colour_noise.noisy_colour_image -> body_segmenter.colour_image",
    }


@pytest.mark.render
def test_a_run_whose_first_frames_are_lost_is_kept_and_judged():
    scenario = quiet_scenario()
    scenario.duration = 0.5
    scenario.scene.camera.faults.loss = FrameFault(begin=0.0, end=0.25)
    skill = made_up_skill()
    log = run(build_reproduction(scenario, skill), scenario)
    camera = scenario.scene.camera
    assert log.keyframe_mask.shape == (2, camera.height, camera.width)
    # No frame by the first key frame: nothing is seen yet, and the robot holds.
    assert not log.keyframe_mask[0].any()
    assert log.keyframe_mask[1].any()
    assert log.guard_mode[log.time < 0.25].all()
    assert evaluate(log, scenario, skill).metrics["verdict"] == "fail"
