"""Skin that goes back and forth: the systems find its speed and where it is now."""

import dataclasses

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

from bath_drake.diagrams.wiring import connect
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.surface import fit_surface
from bath_drake.perception.surface_velocity import VelocityFilter
from bath_drake.systems.surface_reference import SurfaceReference
from bath_drake.systems.surface_velocity import SurfaceVelocity

PERIOD = 1.0 / 30.0
P_NQ = np.array([0.2, -0.1])
R_WP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
# As much as a deep breath, and as fast as one out of breath.
AMPLITUDE, FREQUENCY = 0.01, 0.5


def body_map(y):
    return CanonicalMap(R_WP, np.array([0.7, y, 0.9]), np.array([0.17, 0.25]))


def seen(t, y):
    rng = np.random.default_rng(6)
    x, z = (rng.uniform(-1, 1, (4000, 2)) * [0.17, 0.25]).T
    points = np.column_stack([x, x**2, z]) + body_map(y).p_WP
    return dataclasses.replace(BodyObservation(), stamp=t, found=True, points_W=points)


def breath(t):
    return AMPLITUDE * np.sin(2 * np.pi * FREQUENCY * t)


class Breathing(LeafSystem):
    """A camera and what is made of its frames, of a body that moves along y of W."""

    def __init__(self):
        super().__init__()
        self._seen = self.DeclareAbstractState(Value(BodyObservation()))
        self._map = self.DeclareAbstractState(Value(body_map(0.0)))
        self.DeclareStateOutputPort("body_observation", self._seen)
        self.DeclareStateOutputPort("canonical_map", self._map)
        self.DeclarePeriodicUnrestrictedUpdateEvent(PERIOD, 0.0, self._look)

    def _look(self, context, state):
        t = context.get_time()
        observation = seen(t, breath(t))
        state.get_mutable_abstract_state(int(self._seen)).set_value(observation)
        state.get_mutable_abstract_state(int(self._map)).set_value(body_map(breath(t)))


@pytest.fixture
def dut():
    return SurfaceVelocity(period=PERIOD)


def _after_frames(dut, frames):
    """The velocity after each of some frames: an observation and the map of each."""
    context = dut.CreateDefaultContext()
    dut.GetInputPort("canonical_reference").FixValue(context, P_NQ)
    simulator = Simulator(dut, context)
    for k, (observation, canonical_map) in enumerate(frames):
        dut.GetInputPort("canonical_map").FixValue(context, Value(canonical_map))
        dut.GetInputPort("body_observation").FixValue(context, Value(observation))
        simulator.AdvanceTo((k + 0.5) * PERIOD)
        yield dut.GetOutputPort("surface_velocity").Eval(context).copy()


def test_velocity_is_that_of_the_pure_functions(dut):
    first, second = seen(0.0, 0.0), seen(PERIOD, 0.002)
    frames = [(first, body_map(0.0)), (second, body_map(0.002))]
    at_first, later = _after_frames(dut, frames)
    np.testing.assert_array_equal(at_first, np.zeros(6))
    expected = VelocityFilter().next(
        np.zeros(6),
        fit_surface(first.points_W, body_map(0.0), P_NQ),
        fit_surface(second.points_W, body_map(0.002), P_NQ),
        PERIOD,
    )
    assert expected.any()
    np.testing.assert_array_equal(later, expected)


def test_a_frame_that_is_no_new_one_changes_nothing(dut):
    second = (seen(PERIOD, 0.002), body_map(0.002))
    _, later, again = _after_frames(
        dut, [(seen(0.0, 0.0), body_map(0.0)), second, second]
    )
    assert later.any()
    np.testing.assert_array_equal(again, later)


def _lag(*, feed_forward):
    """How late (s) the nozzle's desired pose is, by the slope over the velocity."""
    builder = DiagramBuilder()
    body = builder.AddNamedSystem("body", Breathing())
    reference = builder.AddNamedSystem("p_NQ", ConstantVectorSource(P_NQ))
    standoff = builder.AddNamedSystem("standoff", ConstantVectorSource([0.06]))
    surface = builder.AddNamedSystem("surface", SurfaceReference())
    velocity = builder.AddNamedSystem("velocity", SurfaceVelocity(period=PERIOD))
    for sink in (surface, velocity):
        builder.Connect(
            reference.get_output_port(), sink.GetInputPort("canonical_reference")
        )
    connect(builder, body, "body_observation", [surface, velocity])
    connect(builder, body, "canonical_map", [surface, velocity])
    builder.Connect(standoff.get_output_port(), surface.GetInputPort("standoff"))
    if feed_forward:
        connect(builder, velocity, "surface_velocity", [surface])
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = surface.GetMyContextFromRoot(simulator.get_context())
    rest = seen(0.0, 0.0).points_W
    still = fit_surface(rest, body_map(0.0), P_NQ)
    behind, speeds = [], []
    # The frames' own times are left out: updates are due then.
    for t in np.arange(1.0, 5.0, 0.013) + 0.0041:
        simulator.AdvanceTo(t)
        pose = surface.GetOutputPort("desired_nozzle_pose").Eval(context)
        there = still.p_WS + 0.06 * still.normal_W + [0.0, breath(t), 0.0]
        behind.append(there[1] - pose.translation()[1])
        angular = 2 * np.pi * FREQUENCY
        speeds.append(AMPLITUDE * angular * np.cos(angular * t))
    return float(np.dot(speeds, behind) / np.dot(speeds, speeds))


def test_the_skin_foretold_is_not_late():
    # Half a frame, and the five millisecond that the projector may be behind.
    assert _lag(feed_forward=False) == pytest.approx(PERIOD / 2.0, abs=2e-3)
    # The velocity is 0.15 s late itself: of a breath every two seconds a fifth is lost.
    assert _lag(feed_forward=True) < 0.25 * PERIOD / 2.0


@pytest.mark.parametrize(
    ("name", "value"), [("period", 0.0), ("period", np.inf), ("radius", 0.5)]
)
def test_bad_parameters_are_refused(name, value):
    with pytest.raises(ValueError, match=name):
        SurfaceVelocity(**{"period": PERIOD, name: value})
