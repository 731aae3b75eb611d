"""The closed loop with ideal perception and a kinematic arm."""

import json

import numpy as np
import pytest
from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator
from write_wiring import made_up_skill

from bath_drake.commands._options import run_and_report
from bath_drake.diagrams import build_perception, build_reproduction
from bath_drake.diagrams.block_diagram import connections
from bath_drake.errors import ScenarioError
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.report.page import write_report
from bath_drake.run_folder import simulate_into
from bath_drake.scenario import find_skill, load_scenario
from bath_drake.simulation import run
from bath_drake.skill_file import load_skill
from bath_drake.strokes import scenario_skill
from bath_drake.systems.ideal_segmenter import IdealSegmenter
from bath_drake.systems.kinematic_arm import KinematicArm
from bath_drake.verification import evaluate


def fast(name, **changes):
    scenario = load_scenario(name)
    scenario.perception.source = "ideal"
    scenario.scene.arm.fidelity = "kinematic"
    for key, value in changes.items():
        setattr(scenario, key, value)
    return scenario


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        *(pytest.param(k, marks=pytest.mark.exhaustive) for k in ("bending", "pour")),
        "coverage",
    ],
)
def test_the_run_passes_verification(name):
    scenario = fast(name)
    skill = scenario_skill(scenario)
    log = run(build_reproduction(scenario, skill), scenario)
    metrics = evaluate(log, scenario, skill).metrics
    assert metrics["verdict"] == "pass"
    assert metrics["perception"] == "ideal"
    assert metrics["frames"] == metrics["dropped_frames"] == 0
    if name == "coverage":
        assert metrics["restricted_min_clearance_mm"] > 0.0
        assert metrics["washing"]["strokes"] == 6
        assert metrics["washing"]["wound_wetted_cm2"] == 0.0


def test_nothing_is_rendered_and_nobody_else_notices():
    usual = load_scenario("reproduction")
    wires = connections(build_reproduction(fast("reproduction"), made_up_skill()))
    camera = connections(build_reproduction(usual, made_up_skill()))
    systems = {w.source for w in wires} | {w.target for w in wires}
    assert not systems & {"camera", "scene_graph", "gravity_compensation"}
    eyes = {"camera", "scene_graph", "arm_position", "gravity_compensation"}
    eyes |= {"body_segmenter", "canonical_projector", "restricted_area_detector"}
    # Without frames there is nothing of them to watch.
    watch = {"frame_monitor", "body_monitor", "camera_monitor"}

    def rest(every):
        every = [w for w in every if w.source not in watch and w.target not in watch]
        return {str(w) for w in every if w.target not in eyes and w.target != "plant"}

    # Logs, control and all: the same wires.
    assert rest(wires) == rest(camera)


@pytest.mark.parametrize("name", ["reproduction", "bending"])
def test_it_is_drawn_where_somebody_looks(name):
    diagram = build_reproduction(fast(name), made_up_skill(), meshcat=Meshcat())
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.1)
    graph = diagram.GetSubsystemByName("scene_graph")
    context = graph.GetMyContextFromRoot(simulator.get_context())
    query = graph.get_query_output_port().Eval(context)
    arm = [
        f
        for f in query.inspector().GetAllFrameIds()
        if "nozzle" in query.inspector().GetName(f)
    ]
    assert arm
    for frame in arm:
        X_WL = query.GetPoseInWorld(frame)
        assert 0.2 < np.linalg.norm(X_WL.translation()) < 2.0


def test_the_areas_are_there_with_the_first_frame():
    scenario = fast("restricted_area")
    diagram = build_perception(scenario)
    simulator = Simulator(diagram)
    context = simulator.get_context()
    areas = diagram.GetOutputPort("sensed_obstacles")
    assert len(areas.Eval(context)) == 0
    simulator.AdvanceTo(0.01)
    assert len(areas.Eval(context)) == 1
    observation = diagram.GetOutputPort("body_observation").Eval(context)
    assert observation.stamp == 0.0
    assert diagram.GetOutputPort("rejected_frames").Eval(context) == [0.0]


def test_a_look_comes_every_period():
    class Sight:
        def observe(self, R_WM, p_WM, bend, stamp):
            np.testing.assert_allclose(R_WM, np.eye(3), atol=1e-12)
            np.testing.assert_array_equal(p_WM, [1.0, 2.0, 3.0])
            assert bend.twist == 0.3
            return BodyObservation(stamp=stamp, found=True)

    system = IdealSegmenter(sight=Sight(), period=0.1)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    pose = [1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0]
    system.GetInputPort("body_pose").FixValue(context, pose)
    system.GetInputPort("trunk_bend").FixValue(context, [0.0, 0.0, 0.3, 0.0])
    port = system.GetOutputPort("body_observation")
    assert not port.Eval(context).found
    simulator.AdvanceTo(0.25)
    assert port.Eval(context).stamp == pytest.approx(0.2)
    with pytest.raises(ValueError, match="period must be positive, got 0"):
        IdealSegmenter(sight=Sight(), period=0.0)


def test_the_kinematic_arm_is_where_it_is_told():
    arm = KinematicArm()
    context = arm.CreateDefaultContext()
    told = np.arange(14.0)
    arm.GetInputPort("arm_desired_state").FixValue(context, told)
    np.testing.assert_array_equal(arm.GetOutputPort("arm_state").Eval(context), told)
    position = arm.GetOutputPort("arm_position").Eval(context)
    np.testing.assert_array_equal(position, told[:7])


def test_frames_that_are_not_taken_cannot_be_recorded(tmp_path):
    scenario = fast("reproduction")
    with pytest.raises(ScenarioError, match="found 'ideal', allowed camera to record"):
        build_reproduction(scenario, made_up_skill(), write_frame=print)
    with pytest.raises(ScenarioError, match=r"--record: perception\.source"):
        run_and_report(tmp_path, scenario, made_up_skill(), False, tmp_path / "film")


@pytest.mark.slow
@pytest.mark.usefixtures("unsaved_figures")
def test_the_report_says_so(tmp_path):
    scenario = fast("restricted_area", duration=4.0)
    skill = load_skill(find_skill(scenario.skill))
    simulate_into(tmp_path, scenario, skill, meshcat=Meshcat())
    page = write_report(tmp_path).read_text(encoding="utf-8")
    assert "Perception was ideal" in page
    assert "The arm was kinematic" in page
    metrics = json.loads((tmp_path / "metrics.json").read_text(encoding="utf-8"))
    assert metrics["perception"] == "ideal"
    assert metrics["frames"] == 0
