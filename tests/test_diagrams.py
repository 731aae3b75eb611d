from dataclasses import replace

import numpy as np
import pytest
from made_up_skill import composed_skill, with_branch
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import EventStatus
from write_wiring import BUILDERS, RECORDS, made_up_skill, shipped_diagram, wiring_text

from bath_drake.composition.rollout import chain_rollout
from bath_drake.diagrams.canonical import build_canonical_loop
from bath_drake.diagrams.logs import log_name, logged_ports
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.field.rollout import RolloutStatus
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.patient.people import load_person
from bath_drake.patient.skin import TrueSkin
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.scenario import load_scenario
from bath_drake.systems._guard_facts import OPTIONAL_PORTS
from bath_drake.verification import pose_from_row

PERCEPTION = [name for name in BUILDERS if name.endswith("_perception")]
SCENARIOS = [name.removesuffix("_perception") for name in PERCEPTION]
ARRIVED = 1e-4


@pytest.fixture(scope="module")
def loop():
    return shipped_diagram("canonical_loop")


def other_skill():
    skill = made_up_skill()
    field = replace(
        skill.field,
        goal=np.array([-0.3, -0.7]),
        kappa=4.0,
        obstacles=ObstacleSet(np.array([[0.0, -0.1, 0.2, 0.1, 0.7]])),
    )
    return with_branch(skill, field=field, start=np.array([0.5, 0.6]))


def drive(diagram, skill=None):
    """The path of the canonical loop, of another skill than its own if given."""
    context = diagram.CreateDefaultContext()
    source = diagram.GetSubsystemByName("virtual_obstacle_source")
    reference = diagram.GetSubsystemByName("canonical_reference")
    goal = made_up_skill().chain.goal
    if skill is not None:
        source.set_chain(source.GetMyMutableContextFromRoot(context), skill.chain)
        reference.set_start(reference.GetMyMutableContextFromRoot(context), skill.start)
        goal = skill.chain.goal
    path = []
    port = diagram.GetOutputPort("canonical_position")

    def watch(root):
        path.append(port.Eval(root))
        if np.linalg.norm(path[-1] - goal) < ARRIVED:
            return EventStatus.ReachedTermination(diagram, "arrived")
        return EventStatus.Succeeded()

    simulator = Simulator(diagram, context)
    simulator.set_monitor(watch)
    simulator.AdvanceTo(60.0)
    return np.array(path)


def rolled_out(skill):
    result = chain_rollout(
        skill.start, skill.chain, step=0.001, max_steps=20000, goal_tolerance=ARRIVED
    )
    assert result.status is RolloutStatus.ARRIVED
    return result.path


@pytest.mark.slow
def test_the_canonical_loop_drives_the_path_of_the_rollout():
    # The deviation is Euler's, in proportion to the speed: at 0.15/s half of what it
    # is at the default. This path is long and turns back on itself (3 units of N).
    path = drive(build_canonical_loop(made_up_skill(), speed=0.15))
    assert discrete_frechet(path, rolled_out(made_up_skill())) < 1e-3
    np.testing.assert_array_equal(path[0], made_up_skill().start)


def test_one_canonical_loop_serves_another_skill(loop):
    skill = other_skill()
    path = drive(loop, skill)
    assert discrete_frechet(path, rolled_out(skill)) < 1e-3
    np.testing.assert_array_equal(path[0], skill.start)
    # A fresh context knows nothing of it.
    start = loop.GetOutputPort("canonical_position").Eval(loop.CreateDefaultContext())
    np.testing.assert_array_equal(start, made_up_skill().start)


def test_the_canonical_loop_follows_a_chain_through_its_gates(loop):
    # The path crosses itself; it passes a gate up to one step late, 3e-4 of N here.
    skill = composed_skill()
    path = drive(loop, skill)
    assert discrete_frechet(path, rolled_out(skill)) < 1e-3
    np.testing.assert_array_equal(path[0], skill.start)


@pytest.mark.parametrize("name", PERCEPTION)
def test_perception_exports_what_it_makes(name):
    diagram = shipped_diagram(name)
    ports = [
        diagram.get_output_port(k).get_name() for k in range(diagram.num_output_ports())
    ]
    assert ports == [
        "body_observation",
        "canonical_map",
        "rejected_frames",
        "sensed_obstacles",
    ]
    assert diagram.num_input_ports() == 0
    assert diagram.get_name() == "perception"


@pytest.mark.render
@pytest.mark.parametrize("name", SCENARIOS)
def test_perception_sees_the_body_where_it_is(name):
    diagram, scenario = shipped_diagram(f"{name}_perception"), load_scenario(name)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.04)
    context = simulator.get_context()
    observation, seen, areas = (
        diagram.GetOutputPort(port).Eval(context)
        for port in ("body_observation", "canonical_map", "sensed_obstacles")
    )
    assert isinstance(observation, BodyObservation)
    assert isinstance(seen, CanonicalMap)
    assert isinstance(areas, ObstacleSet)
    assert observation.found
    assert observation.stamp == pytest.approx(1.0 / scenario.perception.camera_rate)
    motion = diagram.GetSubsystemByName("patient_motion")
    X_WM = pose_from_row(
        motion.GetOutputPort("body_pose").Eval(motion.GetMyContextFromRoot(context))
    )
    true = TrueSkin(load_person(scenario.scene.person)).canonical_map
    # The visible part of the back, without its flanks, is what the camera has.
    np.testing.assert_allclose(
        seen.p_WP, X_WM.multiply(true.p_WP[:, None])[:, 0], atol=0.04
    )
    assert (seen.R_WP[:, 2] @ X_WM.rotation().matrix() @ true.R_WP[:, 2]) > 0.97
    assert len(areas) == (scenario.scene.wound is not None)


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_logged_port_has_its_sink(name):
    diagram = shipped_diagram(name)
    names = {system.get_name() for system in diagram.GetSystems()}
    for system, port in logged_ports(names):
        sink = diagram.GetSubsystemByName(log_name(system, port))
        size = diagram.GetSubsystemByName(system).GetOutputPort(port).size()
        assert sink.get_input_port().size() == size


@pytest.mark.parametrize("name", BUILDERS)
def test_the_wiring_is_as_recorded(name):
    record = (RECORDS / f"{name}.txt").read_text(encoding="utf-8")
    assert wiring_text(name).splitlines() == record.splitlines(), (
        "if the change is meant, renew the records: python tests/write_wiring.py"
    )


def test_no_record_is_of_a_diagram_that_is_gone():
    assert {path.stem for path in RECORDS.iterdir()} == set(BUILDERS)


@pytest.mark.parametrize("name", BUILDERS)
def test_every_input_is_connected_or_optional(name):
    diagram = shipped_diagram(name)
    optional = {
        ("body_segmenter", "frame_stamp"),
        ("canonical_reference", "phase"),
        ("canonical_reference", "hold"),
        ("navigation_controller", "sensed_obstacles"),
        ("stage_sequencer", "sensed_obstacles"),
        # Nothing touches the tool where no skin can be touched.
        ("force_sensor", "contact_wrench"),
        # Only faults give frames a time of their own.
        ("frame_monitor", "frame_stamp"),
        # What the other guard watches; see test_guarded_paths for what must be.
        *(("canonical_guard", name) for name in OPTIONAL_PORTS),
        *(("joint_guard", name) for name in OPTIONAL_PORTS),
    }
    wired = {
        (system.get_name(), system.get_input_port(index).get_name())
        for system, index in diagram.connection_map()
    }
    for system in diagram.GetSystems():
        if system.get_name() in {"plant", "scene_graph"}:
            continue  # Drake's own ports for what is not there
        for k in range(system.num_input_ports()):
            port = system.get_name(), system.get_input_port(k).get_name()
            assert port in wired or port in optional, f"{port} is not connected"
