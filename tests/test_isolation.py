"""Nothing downstream of the camera knows the true body: walked along the wires.

A system is taken to pass every input on to every output, so what is found not to
be reachable here is not reachable at all. The walk stops at the sensors alone.
"""

import functools
from collections import defaultdict

import pytest
from pydrake.systems.framework import Context
from pydrake.systems.primitives import VectorLogSink
from write_wiring import BUILDERS, made_up_skill, shipped_diagram

from bath_drake.diagrams import control, reproduction
from bath_drake.diagrams.block_diagram import connections
from bath_drake.diagrams.graph_layout import Connection
from bath_drake.scenario import load_scenario
from bath_drake.systems.canonical_tracker import CanonicalTracker

SENSORS = {
    ("camera", "color_image"),
    ("camera", "depth_image_32f"),
    ("plant", "arm_state"),
    # Of what touches the tool, where skin can be touched.
    ("force_sensor", "wrench"),
}
WORLD = {"patient_motion", "scene_graph", "camera", "plant"}
# Where there is contact: what is between it and the sensor.
FELT = {"contact_wrench", "force_sensor"}
# What moves the arm or ends its motion.
DECIDING = ("differential_ik", "joint_guard", "loop_monitor")
# Where a carer is filmed no robot is told anything.
SCENES = [name for name in BUILDERS if name not in ("canonical_loop", "demonstration")]
LOOPS = [name for name in SCENES if not name.endswith("_perception")]


@functools.cache
def filmed_diagram(name):
    """The shipped Diagram; with a camera where perception is ideal by decree."""
    if name == "canonical_loop":
        return shipped_diagram(name)
    scenario = load_scenario(name.removesuffix("_perception"))
    if scenario.perception.source == "camera":
        return shipped_diagram(name)
    scenario.perception.source = "camera"
    if name.endswith("_perception"):
        return reproduction.build_perception(scenario)
    return reproduction.build_reproduction(scenario, made_up_skill())


def logs_of(diagram):
    systems = diagram.GetSystems()
    return {s.get_name() for s in systems if isinstance(s, VectorLogSink)}


def reachable(wires, start):
    """Systems that hear of `start`, other than through a sensor."""
    ahead = defaultdict(set)
    for wire in wires:
        if (wire.source, wire.output) not in SENSORS:
            ahead[wire.source].add(wire.target)
    return _walk(ahead, start)


def sources(wires, start):
    """Systems that `start` hears of, other than through a sensor."""
    behind = defaultdict(set)
    for wire in wires:
        if (wire.source, wire.output) not in SENSORS:
            behind[wire.target].add(wire.source)
    return _walk(behind, start)


def sensors_of(wires, start):
    """The sensors through which `start` hears of the world."""
    heard = sources(wires, start) | {start}
    ports = {(w.source, w.output) for w in wires if w.target in heard}
    return ports & SENSORS


def _walk(graph, start):
    found, waiting = set(), [start]
    while waiting:
        for name in graph[waiting.pop()] - found:
            found.add(name)
            waiting.append(name)
    return found


def leaks(wires, logs):
    """What breaks the isolation, one line each; empty where it holds."""
    found = []
    harmless = logs | {"meshcat_visualizer"}
    allowed = {
        ("patient_motion", "body_pose"): harmless,
        ("patient_motion", "geometry_pose"): {"scene_graph"},
        # To the plant for contacts, in which the person takes no part.
        ("scene_graph", "query"): harmless | {"camera", "plant"},
        # The skin that is touched is moved by the truth, and felt by the sensor.
        ("patient_motion", "skin_segments"): {"plant"},
        ("plant", "contact_results"): {"contact_wrench"},
        ("contact_wrench", "contact_wrench"): harmless | {"force_sensor"},
    }
    for wire in wires:
        port = wire.source, wire.output
        if port in allowed and wire.target not in allowed[port]:
            found.append(f"truth: {wire}")
        elif wire.source == "camera" and port not in SENSORS:
            found.append(f"label: {wire}")
    known = harmless | WORLD | FELT
    for start in ("patient_motion", "scene_graph", "camera"):
        for name in sorted(reachable(wires, start) - known):
            found.append(f"ahead: {start} reaches {name}")
    untold = ("geometry_query", "skin_desired_state")
    inputs = [w for w in wires if w.target == "plant" and w.input not in untold]
    for wire in inputs:
        for name in sorted((sources(wires, wire.source) | {wire.source}) & WORLD):
            found.append(f"behind: {wire.input} of the plant hears of {name}")
    for start in DECIDING:
        for name in sorted(sources(wires, start) & WORLD):
            found.append(f"behind: {start} hears of {name}")
    return found


@pytest.mark.parametrize("name", SCENES)
def test_the_truth_reaches_logs_and_the_scene_alone(name):
    diagram = filmed_diagram(name)
    assert leaks(connections(diagram), logs_of(diagram)) == []


@pytest.mark.parametrize("name", SCENES)
def test_the_label_image_goes_to_nobody(name):
    wires = connections(filmed_diagram(name))
    used = {wire.output for wire in wires if wire.source == "camera"}
    assert used == {"color_image", "depth_image_32f"}


@pytest.mark.parametrize("name", LOOPS)
def test_the_command_comes_through_the_images_and_the_arms_own_state(name):
    wires = connections(filmed_diagram(name))
    assert sensors_of(wires, "differential_ik") == SENSORS


@pytest.mark.parametrize("name", LOOPS)
def test_the_walks_see_the_whole_loop(name):
    """Else an empty walk would prove anything."""
    wires = connections(filmed_diagram(name))
    loop = {"body_segmenter", "canonical_projector", "surface_reference"}
    assert loop | {"navigation_controller"} <= sources(wires, "differential_ik")
    ahead = reachable(wires, "body_segmenter") | {"body_segmenter"}
    assert loop | {"differential_ik", "plant"} <= ahead
    assert "scene_graph" in reachable(wires, "patient_motion")


@pytest.mark.parametrize("name", LOOPS)
def test_logs_keep_what_they_hear_to_themselves(name):
    diagram = filmed_diagram(name)
    wires = connections(diagram)
    assert ("patient_motion", "body_pose") in {(w.source, w.output) for w in wires}
    for sink in logs_of(diagram):
        assert diagram.GetSubsystemByName(sink).num_output_ports() == 0


@pytest.mark.parametrize("name", SCENES)
def test_the_person_takes_no_part_in_contacts(name):
    """So that the plant, which asks the scene for them, cannot feel the truth."""
    inspector = filmed_diagram(name).GetSubsystemByName("scene_graph").model_inspector()
    # By their owner: a bending person's skin hangs on no frame of its own.
    persons = [
        g
        for g in inspector.GetAllGeometryIds()
        if inspector.GetOwningSourceName(g) == "person"
    ]
    seen = [inspector.GetPerceptionProperties(g) is not None for g in persons]
    assert sum(seen) >= 4
    assert all(inspector.GetProximityProperties(g) is None for g in persons)


@pytest.mark.parametrize(
    ("wire", "sort"),
    [
        ("patient_motion.body_pose -> surface_reference.standoff", "truth"),
        ("patient_motion.body_pose -> loop_monitor.nozzle_pose", "truth"),
        ("patient_motion.geometry_pose -> canonical_tracker.x", "truth"),
        ("scene_graph.query -> differential_ik.x", "truth"),
        ("camera.label_image -> body_segmenter.colour_image", "label"),
        ("camera.label_image -> log_labels.data", "label"),
        ("camera.depth_image_16u -> body_segmenter.depth_image", "label"),
        ("camera.body_pose_in_world -> body_segmenter.x", "label"),
        ("plant.contact_results -> joint_guard.x", "ahead"),
        ("plant.contact_results -> joint_guard.x", "truth"),
        ("contact_wrench.contact_wrench -> force_regulator.wrench", "truth"),
        ("patient_motion.skin_segments -> differential_ik.x", "truth"),
        ("plant.body_poses -> nozzle_kinematics.arm_state", "behind"),
        ("log_patient_motion_body_pose.y -> differential_ik.x", "ahead"),
    ],
)
def test_a_wire_too_many_is_found(wire, sort):
    diagram = shipped_diagram("reproduction")
    source, target = wire.split(" -> ")
    extra = Connection(*source.split("."), *target.split("."))
    found = leaks([*connections(diagram), extra], logs_of(diagram))
    assert any(line.startswith(f"{sort}: ") for line in found)


class CheatingTracker(CanonicalTracker):
    """A tracker that is told the truth."""

    def __init__(self):
        super().__init__()
        self._truth = self.DeclareVectorInputPort("body_pose", 7)

    def truth(self, context: Context):
        return self._truth.Eval(context)


def test_a_mis_wired_diagram_is_found(monkeypatch):
    add_logs = reproduction.add_logs

    def cheat(builder, scene, systems):
        builder.Connect(
            scene.patient_motion.GetOutputPort("body_pose"),
            systems["canonical_tracker"].GetInputPort("body_pose"),
        )
        add_logs(builder, scene, systems)

    monkeypatch.setattr(control, "CanonicalTracker", CheatingTracker)
    monkeypatch.setattr(reproduction, "add_logs", cheat)
    scenario = load_scenario("reproduction")
    diagram = reproduction.build_reproduction(scenario, made_up_skill())
    found = leaks(connections(diagram), logs_of(diagram))
    wire = "patient_motion.body_pose -> canonical_tracker.body_pose"
    assert f"truth: {wire}" in found
    assert "ahead: patient_motion reaches differential_ik" in found
    assert "behind: differential_ik hears of patient_motion" in found
