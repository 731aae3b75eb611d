"""No command goes around the guards, in any shipped Diagram that drives the arm."""

import pytest
from write_wiring import BUILDERS, shipped_diagram

from bath_drake.diagrams.control import guard_limits
from bath_drake.scenario import ControlConfig, Scenario, load_scenario
from bath_drake.systems._guard_facts import OPTIONAL_PORTS

# In these the arm stands at home, by a constant, or there is none.
STANDING = {name for name in BUILDERS if name.endswith("_perception")} | {
    "demonstration",
    "canonical_loop",
}
DRIVEN = sorted(set(BUILDERS) - STANDING)


def sources(diagram):
    """(system, port) of what every input port is fed by."""
    return {
        (system.get_name(), system.get_input_port(port).get_name()): (
            source.get_name(),
            source.get_output_port(output).get_name(),
        )
        for (system, port), (source, output) in diagram.connection_map().items()
    }


@pytest.mark.parametrize("name", DRIVEN)
def test_all_that_moves_the_arm_is_the_joint_guards_checked_command(name):
    diagram = shipped_diagram(name)
    commands = {
        port: source
        for (system, port), source in sources(diagram).items()
        if system == "plant" and source[0] != "scene_graph"
    }
    # Of the person's skin, in the same plant where it can be touched.
    moved = commands.pop("skin_desired_state", None)
    assert moved in (None, ("patient_motion", "skin_segments"))
    assert commands == {
        "arm_desired_state": ("joint_guard", "checked_command"),
        # Carries the arm's own weight, from its measured state alone.
        "arm_actuation": ("gravity_compensation", "generalized_force"),
    }
    compensated = {
        source
        for (system, _), source in sources(diagram).items()
        if system == "gravity_compensation"
    }
    assert compensated == {("plant", "arm_state")}


@pytest.mark.parametrize("name", DRIVEN)
def test_the_canonical_velocity_goes_to_its_guard_alone(name):
    fed = sources(shipped_diagram(name))
    raw = ("navigation_controller", "canonical_velocity")
    takers = {sink for sink, source in fed.items() if source == raw}
    assert takers == {("canonical_guard", "canonical_velocity")}
    checked = ("canonical_guard", "checked_velocity")
    takers = {system for (system, _), source in fed.items() if source == checked}
    periodic = shipped_diagram(name).HasSubsystemNamed("periodic_motion")
    assert takers == {"periodic_motion" if periodic else "canonical_reference"}


@pytest.mark.parametrize("name", DRIVEN)
def test_the_inverse_kinematics_is_heard_by_the_joint_guard_and_its_aids_alone(name):
    fed = sources(shipped_diagram(name))
    raw = ("differential_ik", "joint_command")
    takers = {sink for sink, source in fed.items() if source == raw}
    assert {system for system, _ in takers if not system.startswith("log_")} == {
        "joint_guard",
        "self_distance",
        "obstacle_distance",
    }
    for watch in ("self_distance", "obstacle_distance"):
        heeded = {s for (s, _), source in fed.items() if source[0] == watch}
        assert heeded == {"joint_guard"}
    for who in ("differential_ik", "obstacle_distance"):
        assert fed[who, "obstacles"] == ("body_obstacles", "obstacles")
    heeded = {s for (s, _), source in fed.items() if source[0] == "nozzle_clearance"}
    assert heeded == {"joint_guard", "loop_monitor"}


@pytest.mark.parametrize("name", DRIVEN)
def test_what_the_guard_holds_is_held_where_it_is_planned(name):
    fed = sources(shipped_diagram(name))
    for system in ("differential_ik", "canonical_reference", "approach_sequencer"):
        assert fed[system, "hold"] == ("joint_guard", "hold")
    assert fed["differential_ik", "emitted_command"] == (
        "joint_guard",
        "checked_command",
    )


# An operator's reset has no source in simulation; the joint command is of this tick.
UNWATCHED = {"reset", "command_stamp"}
# With ideal perception there are no frames and no bodies to watch.
UNSEEN = {"frame_status", "camera_status", "body_status"}


def test_where_skin_is_touched_the_guard_and_the_regulator_feel_the_same_force():
    fed = sources(shipped_diagram("wash_contact"))
    measured = ("force_sensor", "wrench")
    assert fed["joint_guard", "wrench"] == measured
    assert fed["force_regulator", "wrench"] == measured
    assert fed["force_sensor", "contact_wrench"] == ("contact_wrench",) * 2
    # And what the force moves goes through inverse kinematics and guard as all else.
    assert fed["surface_reference", "standoff"] == ("force_regulator", "standoff")
    assert fed["force_regulator", "hold"] == ("joint_guard", "hold")


@pytest.mark.parametrize("name", DRIVEN)
def test_the_joint_guard_watches_all_that_there_is_to_watch(name):
    fed = {
        port
        for system, port in sources(shipped_diagram(name))
        if system == "joint_guard"
    }
    scenario = load_scenario(name)
    ideal = scenario.perception.source == "ideal"
    assert set(OPTIONAL_PORTS) - fed == UNWATCHED | (UNSEEN if ideal else set())


@pytest.mark.parametrize(("asked", "kept"), [(0.05, 0.05), (0.1, 0.1), (0.4, 0.1)])
def test_a_scenario_can_make_frames_stale_sooner_but_not_later(asked, kept):
    scenario = Scenario(control=ControlConfig(max_frame_age=asked))
    assert guard_limits(scenario).frames.hold_age == kept
