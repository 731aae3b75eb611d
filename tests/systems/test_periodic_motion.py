"""The system is the pure superposition, and a loop with it enters no area."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource, ConstantVectorSource

from bath_drake.control.approach import Phase
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace, beta
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.rhythm.limit_cycle import LimitCycle
from bath_drake.rhythm.superposition import Pace, Rhythm, Room, advance, offset
from bath_drake.systems.canonical_reference import CanonicalReference
from bath_drake.systems.navigation_controller import NavigationController
from bath_drake.systems.periodic_motion import PeriodicMotion

CYCLE = LimitCycle(np.array([[0.12, 0.0], [0.0, 0.09]]), period=1.0, pitch=0.15)
FIELD = NavigationField(
    goal=np.array([0.7, 0.2]),
    kappa=3.0,
    workspace=Workspace(np.zeros(2), np.array([2.0, 2.0])),
    obstacles=ObstacleSet(),
)
AREAS = ObstacleSet(np.array([[0.0, 0.25, 0.1, 0.15, 0.3]]))
BODY = CanonicalMap(np.eye(3), np.zeros(3), np.array([0.2, 0.25]))
SPEED = 0.07
AT = np.array([-0.1, 0.0])


def made(**options):
    return PeriodicMotion(cycle=CYCLE, length=1.5, washing_speed=SPEED, **options)


def fixed(system, *, areas=AREAS, final=1.0, phase=None, hold=None):
    """A context in which every input has a value."""
    context = system.CreateDefaultContext()
    for name, value in (
        ("canonical_reference", AT),
        ("canonical_velocity", [0.3, 0.1]),
        ("canonical_position", [-0.05, 0.02]),
        ("navigation_field", Value[object](FIELD)),
        ("final_stage", [final]),
        ("sensed_obstacles", Value[object](areas)),
        ("canonical_map", Value[object](BODY)),
        ("phase", phase),
        ("hold", hold),
    ):
        if value is not None:
            system.GetInputPort(name).FixValue(context, value)
    return context


def output(system, context, name):
    return system.GetOutputPort(name).Eval(context)


def updated(system, context):
    return system.EvalUniquePeriodicDiscreteUpdate(context).value(0)


RHYTHM = Rhythm(phase=1.0, deviation=np.array([0.02, 0.01]), share=0.9, travelled=0.5)


def test_target_and_offset_are_the_pure_function():
    system = made()
    context = fixed(system)
    system.set_rhythm(context, RHYTHM)
    room = Room(AREAS, FIELD.workspace, margin=0.02)
    expected = offset(CYCLE, RHYTHM, AT, room)
    assert np.linalg.norm(expected) > 0.03
    np.testing.assert_array_equal(output(system, context, "canonical_offset"), expected)
    np.testing.assert_array_equal(
        output(system, context, "canonical_target"), AT + expected
    )
    np.testing.assert_array_equal(
        output(system, context, "discrete_position"),
        np.array([-0.05, 0.02]) - expected,
    )


@pytest.mark.parametrize("final", [0.0, 1.0])
def test_a_step_is_the_pure_function_s(final):
    system = made()
    context = fixed(system, final=final)
    system.set_rhythm(context, RHYTHM)
    to_goal = float(np.linalg.norm(FIELD.goal - AT)) if final else np.inf
    rhythm, velocity = advance(
        CYCLE,
        RHYTHM,
        AT,
        np.array([0.3, 0.1]),
        to_goal,
        Room(AREAS, FIELD.workspace, margin=0.02),
        Pace(SPEED, BODY.half_extents, 1.5),
        0.01,
    )
    np.testing.assert_allclose(
        output(system, context, "discrete_velocity"), velocity, rtol=1e-15
    )
    row = updated(system, context)
    expected = [rhythm.phase, *rhythm.deviation, rhythm.share, rhythm.travelled]
    np.testing.assert_allclose(row, expected, rtol=1e-15)


@pytest.mark.parametrize("why", [{"hold": [1.0]}, {"phase": [float(Phase.REACH)]}])
def test_on_hold_and_before_washing_the_rhythm_stands_still(why):
    system = made()
    context = fixed(system, **why)
    system.set_rhythm(context, RHYTHM)
    before = system.rhythm(context)
    np.testing.assert_array_equal(
        updated(system, context),
        [before.phase, *before.deviation, before.share, before.travelled],
    )


def test_while_washing_it_goes_on():
    system = made()
    context = fixed(system, phase=[float(Phase.WASH)], hold=[0.0])
    assert updated(system, context)[4] > 0.0


def test_an_area_over_the_reference_leaves_no_offset():
    system = made()
    covering = ObstacleSet(np.array([[*AT, 0.2, 0.2, 0.0]]))
    context = fixed(system, areas=covering)
    system.set_rhythm(context, RHYTHM)
    np.testing.assert_array_equal(output(system, context, "canonical_offset"), 0.0)


@pytest.mark.parametrize(
    ("final", "share", "faded"), [(1.0, 0.0, 1.0), (1.0, 0.1, 0.0), (0.0, 0.0, 0.0)]
)
def test_faded_is_said_on_the_last_stage_alone(final, share, faded):
    system = made()
    context = fixed(system, final=final, areas=ObstacleSet())
    system.set_rhythm(context, Rhythm(share=share))
    assert output(system, context, "faded") == [faded]


def canonical_loop():
    """Field, reference and circles; the measured point is the target."""
    builder = DiagramBuilder()
    controller = NavigationController(washing_speed=SPEED)
    reference = CanonicalReference(start=np.array([-0.7, -0.2]))
    motion = made()
    for name, system in (
        ("controller", controller),
        ("reference", reference),
        ("motion", motion),
    ):
        builder.AddNamedSystem(name, system)
    for value, name, sinks in (
        (FIELD, "navigation_field", [controller, motion]),
        (BODY, "canonical_map", [controller, motion]),
        (AREAS, "sensed_obstacles", [controller, motion]),
    ):
        source = builder.AddSystem(ConstantValueSource(Value[object](value)))
        for sink in sinks:
            builder.Connect(source.get_output_port(), sink.GetInputPort(name))
    final = builder.AddSystem(ConstantVectorSource([1.0]))
    builder.Connect(final.get_output_port(), motion.GetInputPort("final_stage"))
    for source, port, sink, name in (
        (controller, "canonical_velocity", motion, "canonical_velocity"),
        (reference, "canonical_reference", motion, "canonical_reference"),
        (reference, "canonical_reference", controller, "canonical_position"),
        (motion, "canonical_target", motion, "canonical_position"),
        (motion, "discrete_velocity", reference, "canonical_velocity"),
        (motion, "discrete_position", reference, "canonical_position"),
    ):
        builder.Connect(source.GetOutputPort(port), sink.GetInputPort(name))
    builder.ExportOutput(motion.GetOutputPort("canonical_target"), "target")
    builder.ExportOutput(motion.GetOutputPort("faded"), "faded")
    return builder.Build()


def test_the_loop_circles_to_the_goal_round_the_area_no_faster_than_allowed():
    diagram = canonical_loop()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    path = []
    for k in range(6000):
        simulator.AdvanceTo(0.01 * k)
        path.append(diagram.GetOutputPort("target").Eval(context))
        if np.linalg.norm(path[-1] - FIELD.goal) < 0.01:
            break
    path = np.array(path)
    assert diagram.GetOutputPort("faded").Eval(context) == [1.0]
    # The margin of 0.02 on the area.
    assert beta(path, AREAS).min() > 0.0
    speed = np.linalg.norm(np.diff(path, axis=0) * BODY.half_extents, axis=1) / 0.01
    # The time of a step is found in a few rounds.
    assert speed.max() <= 1.01 * SPEED
    # Some eight circles of a pitch of 0.15 on 1.5: far longer than the way itself.
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() > 4.0


@pytest.mark.parametrize("name", ["length", "washing_speed", "half_box", "period"])
def test_numbers_must_be_positive(name):
    options = {"cycle": CYCLE, "length": 1.5, name: 0.0}
    with pytest.raises(ValueError, match=name):
        PeriodicMotion(**options)


def test_a_negative_margin_is_refused():
    with pytest.raises(ValueError, match="margin"):
        made(margin=-0.01)
