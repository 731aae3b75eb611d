import numpy as np
import pytest
from made_up_skill import crossing_chain
from pydrake.systems.analysis import Simulator

from bath_drake.control.areas import inflated
from bath_drake.control.world import join_areas
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.systems.world_reconciler import WorldReconciler

START = np.array([-0.7, 0.0])
FIELD = NavigationField(
    workspace=Workspace(np.zeros(2), np.full(2, 2.0)),
    goal=np.array([0.7, 0.0]),
    kappa=6.0,
    obstacles=ObstacleSet(np.array([[0.3, -0.12, 0.35, 0.1, 1.2]])),
)
AREAS = ObstacleSet(np.array([[-0.1, 0.0, 0.2, 0.15, 0.3]]))
PERIOD = 1.0 / 30.0


@pytest.fixture
def dut():
    return WorldReconciler(period=PERIOD, slack=0.02)


def run(dut, areas, end=0.01, simulator=None):
    if simulator is None:
        simulator = Simulator(dut, dut.CreateDefaultContext())
    context = simulator.get_mutable_context()
    dut.GetInputPort("navigation_field").FixValue(context, FIELD)
    dut.GetInputPort("sensed_obstacles").FixValue(context, areas)
    dut.GetInputPort("canonical_reference").FixValue(context, START)
    simulator.AdvanceTo(end)
    return simulator


def out(dut, simulator, port):
    return dut.GetOutputPort(port).Eval(simulator.get_context())


def test_it_gives_the_world_of_the_pure_function(dut):
    simulator = run(dut, AREAS)
    world = join_areas(FIELD, inflated(AREAS, 0.02), START)
    field = out(dut, simulator, "reconciled_field")
    np.testing.assert_array_equal(field.obstacles.theta, world.virtual.obstacles.theta)
    assert field.kappa == world.virtual.kappa
    sensed = out(dut, simulator, "reconciled_obstacles")
    np.testing.assert_array_equal(sensed.theta, world.sensed.theta)
    np.testing.assert_array_equal(sensed.powers, world.sensed.powers)
    assert (
        out(dut, simulator, "world_status")[0] == float(world.certificate.passed) == 1.0
    )


def test_a_flicker_of_an_area_is_no_new_world(dut):
    simulator = run(dut, AREAS)
    before = out(dut, simulator, "reconciled_obstacles")
    run(dut, inflated(AREAS, 0.01), 0.1, simulator)
    after = out(dut, simulator, "reconciled_obstacles")
    np.testing.assert_array_equal(after.theta, before.theta)


def test_a_new_area_makes_a_new_world(dut):
    simulator = run(dut, ObstacleSet())
    assert len(out(dut, simulator, "reconciled_obstacles")) == 0
    run(dut, AREAS, 0.1, simulator)
    assert len(out(dut, simulator, "reconciled_obstacles")) == 1


def test_before_it_has_looked_no_world_is_sound(dut):
    context = dut.CreateDefaultContext()
    dut.GetInputPort("navigation_field").FixValue(context, FIELD)
    assert dut.GetOutputPort("world_status").Eval(context)[0] == 0.0
    assert dut.GetOutputPort("reconciled_field").Eval(context) == FIELD


def test_an_area_on_the_goal_makes_the_world_unsound(dut):
    on_goal = ObstacleSet(np.array([[0.7, 0.0, 0.2, 0.2, 0.0]]))
    simulator = run(dut, on_goal)
    assert out(dut, simulator, "world_status")[0] == 0.0


@pytest.mark.parametrize("numbers", [{"period": 0.0}, {"period": 1.0, "slack": -1.0}])
def test_its_numbers_must_be_in_range(numbers):
    with pytest.raises(ValueError, match="must be"):
        WorldReconciler(**numbers)


CHAIN = crossing_chain()


def run_chain(dut, chain, simulator=None, end=0.1, point=(-0.7, -0.3)):
    if simulator is None:
        simulator = Simulator(dut, dut.CreateDefaultContext())
    context = simulator.get_mutable_context()
    for name, value in (
        ("navigation_field", chain.fields[0]),
        ("remaining_chain", chain),
        ("sensed_obstacles", ObstacleSet(np.array([[-0.3, 0.4, 0.1, 0.1, 0.0]]))),
        ("canonical_reference", np.array(point)),
    ):
        dut.GetInputPort(name).FixValue(context, value)
    simulator.AdvanceTo(end)
    return simulator


def test_the_next_world_is_there_before_the_gate_is_passed(dut):
    simulator = run_chain(dut, CHAIN)
    worlds = out(dut, simulator, "reconciled_worlds")
    assert [world.learned for world in worlds] == list(CHAIN.fields[:2])
    later = CHAIN.rest(1)
    # Nothing is simulated: the very moment the field changes.
    run_chain(dut, later, simulator, end=0.1)
    assert out(dut, simulator, "world_status")[0] == 1.0
    assert out(dut, simulator, "reconciled_field") == worlds[1].virtual
    assert out(dut, simulator, "reconciled_obstacles") == worlds[1].sensed


def test_a_field_nobody_announced_is_unsound_until_its_world_is_made(dut):
    simulator = run_chain(dut, CHAIN)
    run_chain(dut, CHAIN.rest(2), simulator, end=0.1)
    assert out(dut, simulator, "world_status")[0] == 0.0
    areas = out(dut, simulator, "restricted_areas")
    assert out(dut, simulator, "reconciled_obstacles") == areas
    run_chain(dut, CHAIN.rest(2), simulator, end=0.1 + PERIOD)
    assert out(dut, simulator, "world_status")[0] == 1.0
