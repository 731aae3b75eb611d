"""Controller, source, reference and tracker against their pure functions."""

import numpy as np
import pytest
from made_up_skill import crossing_chain
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator

from bath_drake.composition.chain import Chain
from bath_drake.control.approach import ApproachLimits, Phase
from bath_drake.control.reference import next_reference
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.speed import canonical_velocity
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.systems.approach_sequencer import ApproachSequencer
from bath_drake.systems.canonical_reference import CanonicalReference
from bath_drake.systems.canonical_tracker import CanonicalTracker
from bath_drake.systems.navigation_controller import NavigationController
from bath_drake.systems.virtual_obstacle_source import VirtualObstacleSource

FIELD = NavigationField(
    workspace=Workspace(np.zeros(2), np.full(2, 2.0)),
    goal=np.array([0.6, 0.0]),
    kappa=5.0,
    obstacles=ObstacleSet(np.array([[0.0, 0.1, 0.15, 0.1, 0.3]])),
)
SENSED = ObstacleSet(np.array([[0.2, -0.3, 0.1, 0.1, 0.0]]))
P_NQ = np.array([-0.5, 0.1])
MAP = CanonicalMap(
    RollPitchYaw(0.1, 0.2, 0.3).ToRotationMatrix().matrix(),
    np.array([0.7, 0.0, 0.9]),
    np.array([0.18, 0.24]),
)


@pytest.fixture
def controller():
    return NavigationController(washing_speed=0.07, slow_radius=0.1)


@pytest.fixture
def controller_context(controller):
    context = controller.CreateDefaultContext()
    controller.GetInputPort("canonical_position").FixValue(context, P_NQ)
    controller.GetInputPort("navigation_field").FixValue(context, FIELD)
    controller.GetInputPort("canonical_map").FixValue(context, MAP)
    return context


def velocity(field):
    return canonical_velocity(
        P_NQ, field, speed=0.07, half_extents=MAP.half_extents, slow_radius=0.1
    )


def test_the_controller_follows_the_pure_speed_law(controller, controller_context):
    v_NQ = controller.GetOutputPort("canonical_velocity").Eval(controller_context)
    np.testing.assert_array_equal(v_NQ, velocity(FIELD))


def test_sensed_obstacles_join_the_virtual_ones(controller, controller_context):
    port = controller.GetInputPort("sensed_obstacles")
    port.FixValue(controller_context, SENSED)
    v_NQ = controller.GetOutputPort("canonical_velocity").Eval(controller_context)
    np.testing.assert_array_equal(v_NQ, velocity(FIELD.with_obstacles(SENSED)))
    assert not np.array_equal(v_NQ, velocity(FIELD))


def test_a_wrong_value_is_refused_by_the_name_of_its_port(
    controller, controller_context
):
    controller.GetInputPort("navigation_field").FixValue(controller_context, "field")
    with pytest.raises(TypeError, match="navigation_field"):
        controller.GetOutputPort("canonical_velocity").Eval(controller_context)


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), float("inf")])
def test_the_washing_speed_must_be_positive(speed):
    with pytest.raises(ValueError, match="washing_speed must be positive"):
        NavigationController(washing_speed=speed)


def test_the_source_gives_the_chain_of_its_parameter_and_takes_another():
    source = VirtualObstacleSource(chain=Chain((FIELD,)))
    context = source.CreateDefaultContext()
    port = source.GetOutputPort("navigation_chain")
    assert port.Eval(context) == Chain((FIELD,))
    source.set_chain(context, crossing_chain())
    assert port.Eval(context) == crossing_chain()
    assert port.Eval(source.CreateDefaultContext()) == Chain((FIELD,))


def test_the_source_refuses_more_than_it_has_room_for():
    with pytest.raises(ValueError, match="1 obstacles, at most 0 fit"):
        VirtualObstacleSource(chain=Chain((FIELD,)), max_obstacles=0)
    with pytest.raises(ValueError, match="3 stages, at most 2 fit"):
        VirtualObstacleSource(chain=crossing_chain(), max_stages=2)


def test_the_controller_slows_only_where_nothing_comes_after(
    controller, controller_context
):
    near = FIELD.goal + np.array([-0.05, 0.0])
    controller.GetInputPort("canonical_position").FixValue(controller_context, near)
    port = controller.GetOutputPort("canonical_velocity")
    speeds = []
    for final in (0.0, 1.0):
        controller.GetInputPort("final_stage").FixValue(controller_context, [final])
        v_NQ = port.Eval(controller_context)
        speeds.append(np.linalg.norm(v_NQ * MAP.half_extents))
    # Half the slow radius away; 1e-12: a few roundings.
    np.testing.assert_allclose(speeds, [0.07, 0.035], rtol=1e-12)


@pytest.fixture
def reference():
    return CanonicalReference(start=P_NQ, period=0.01, leash=0.05)


def step_reference(reference, position, velocity, **flags):
    context = reference.CreateDefaultContext()
    reference.GetInputPort("canonical_position").FixValue(context, position)
    reference.GetInputPort("canonical_velocity").FixValue(context, velocity)
    for name, value in flags.items():
        reference.GetInputPort(name).FixValue(context, [float(value)])
    # The update of time zero happens in the first step.
    Simulator(reference, context).AdvanceTo(0.005)
    return reference.GetOutputPort("canonical_reference").Eval(context)


def test_the_reference_integrates_as_the_pure_function(reference):
    position, v_NQ = P_NQ + np.array([0.01, 0.0]), np.array([0.3, -0.1])
    np.testing.assert_array_equal(
        step_reference(reference, position, v_NQ),
        next_reference(P_NQ, position, v_NQ, dt=0.01, leash=0.05, pull=0.5),
    )


def test_the_reference_never_runs_off_its_leash():
    far = np.array([0.5, 0.5])
    ahead = next_reference(
        far, P_NQ, np.array([0.3, 0.0]), dt=0.01, leash=0.05, pull=0.5
    )
    # 1e-12: one scaling of a vector of length 1.
    assert np.linalg.norm(ahead - P_NQ) == pytest.approx(0.05, abs=1e-12)


def test_a_nozzle_that_was_pushed_aside_draws_the_reference_to_itself():
    reference, position = P_NQ, P_NQ + np.array([0.0, 0.04])
    for _ in range(1000):
        reference = next_reference(
            reference, position, np.zeros(2), dt=0.01, leash=0.05, pull=0.5
        )
    # exp(-0.5 * 10) of 0.04 is 3e-4.
    np.testing.assert_allclose(reference, position, atol=3e-4)


@pytest.mark.parametrize("flags", [{"hold": 1}, {"phase": Phase.DESCEND}])
def test_the_reference_waits_while_the_robot_holds_or_approaches(reference, flags):
    moved = step_reference(reference, P_NQ, np.array([0.3, 0.0]), **flags)
    np.testing.assert_array_equal(moved, P_NQ)


def test_the_reference_needs_a_finite_start():
    with pytest.raises(ValueError, match="start must be two finite numbers"):
        CanonicalReference(start=np.array([np.nan, 0.0]))


def test_the_tracker_maps_the_point_down_the_jet():
    tracker = CanonicalTracker()
    context = tracker.CreateDefaultContext()
    X_WE = RigidTransform(RollPitchYaw(0.3, 1.4, 0.1), [0.6, 0.05, 0.95])
    tracker.GetInputPort("nozzle_pose").FixValue(context, X_WE)
    tracker.GetInputPort("canonical_map").FixValue(context, MAP)
    tracker.GetInputPort("standoff").FixValue(context, [0.06])
    expected = MAP.canonical_from_world(X_WE.multiply([0.0, 0.0, 0.06]))
    np.testing.assert_array_equal(
        tracker.GetOutputPort("canonical_position").Eval(context), expected
    )


@pytest.mark.parametrize(
    ("hold", "expected"), [(0.0, Phase.DESCEND), (1.0, Phase.REACH)]
)
def test_the_sequencer_advances_unless_the_robot_holds(hold, expected):
    sequencer = ApproachSequencer(limits=ApproachLimits())
    context = sequencer.CreateDefaultContext()
    for name in ("nozzle_pose", "desired_nozzle_pose"):
        sequencer.GetInputPort(name).FixValue(context, RigidTransform())
    sequencer.GetInputPort("hold").FixValue(context, [hold])
    Simulator(sequencer, context).AdvanceTo(0.005)
    assert sequencer.GetOutputPort("phase").Eval(context)[0] == expected
