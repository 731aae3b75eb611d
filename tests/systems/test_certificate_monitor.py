import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from bath_drake.control.certified_world import WorldVerdict, certify_world
from bath_drake.control.world import join_areas
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.systems.certificate_monitor import CertificateMonitor

START = np.array([-0.7, 0.0])
FIELD = NavigationField(
    workspace=Workspace(np.zeros(2), np.full(2, 2.0)),
    goal=np.array([0.7, 0.0]),
    kappa=6.0,
    obstacles=ObstacleSet(np.array([[0.3, -0.12, 0.35, 0.1, 1.2]])),
)
NONE = ObstacleSet()
AREA = ObstacleSet(np.array([[-0.3, 0.6, 0.1, 0.1, 0.0]]))
# Broadside to the goal and long: it traps before it, but not what starts beyond.
WALL = ObstacleSet(np.array([[-0.3, 0.0, 0.05, 0.6, 0.0]]))
PERIOD = 1.0 / 30.0


@pytest.fixture
def dut():
    return CertificateMonitor(period=PERIOD)


def run(dut, *, areas=NONE, start=START, end=0.01, simulator=None, field=FIELD):
    if simulator is None:
        simulator = Simulator(dut, dut.CreateDefaultContext())
    context = simulator.get_mutable_context()
    dut.GetInputPort("navigation_field").FixValue(context, field)
    dut.GetInputPort("sensed_obstacles").FixValue(context, areas)
    dut.GetInputPort("canonical_reference").FixValue(context, start)
    simulator.AdvanceTo(end)
    return simulator


def out(dut, simulator, port):
    return dut.GetOutputPort(port).Eval(simulator.get_context())


def test_it_gives_the_certificate_of_the_pure_function(dut):
    simulator = run(dut, areas=AREA)
    expected = certify_world(FIELD.with_obstacles(AREA), START)
    world = out(dut, simulator, "certified_world")
    assert world.field == expected.field
    assert world.certificate.verdict == expected.certificate.verdict == "proved"
    assert world.certificate.critical_points == expected.certificate.critical_points
    assert out(dut, simulator, "certificate_verdict")[0] == WorldVerdict.PROVED
    seconds = out(dut, simulator, "certificate_seconds")[0]
    assert seconds == world.certificate.seconds > 0.0
    np.testing.assert_array_equal(out(dut, simulator, "certified_start"), START)
    assert out(dut, simulator, "world_status")[0] == 1.0


def test_before_it_has_looked_nothing_is_proved(dut):
    context = run(dut, end=0.0).get_context()
    assert not dut.GetOutputPort("certified_world").Eval(context).made
    assert dut.GetOutputPort("world_status").Eval(context)[0] == 0.0
    verdict = dut.GetOutputPort("certificate_verdict").Eval(context)[0]
    assert verdict == WorldVerdict.UNKNOWN
    assert dut.GetOutputPort("certificate_seconds").Eval(context)[0] == 0.0


def test_an_unchanged_world_is_not_proved_twice(dut):
    simulator = run(dut, areas=AREA)
    before = out(dut, simulator, "certified_world")
    moved = START + np.array([0.2, 0.1])
    run(dut, areas=AREA, start=moved, end=0.2, simulator=simulator)
    after = out(dut, simulator, "certified_world")
    # Drake copies states: the same proof is told by its time.
    assert after.certificate.seconds == before.certificate.seconds
    np.testing.assert_array_equal(out(dut, simulator, "certified_start"), START)


def test_a_change_stops_the_robot_until_it_is_proved(dut):
    simulator = run(dut)
    context = simulator.get_mutable_context()
    dut.GetInputPort("sensed_obstacles").FixValue(context, AREA)
    assert out(dut, simulator, "world_status")[0] == 0.0
    assert out(dut, simulator, "certificate_verdict")[0] == WorldVerdict.PROVED
    simulator.AdvanceTo(0.1)
    assert out(dut, simulator, "world_status")[0] == 1.0
    assert len(out(dut, simulator, "certified_world").field.obstacles) == 2


def test_another_goal_is_another_world(dut):
    simulator = run(dut)
    other = FIELD.with_goal(np.array([0.6, 0.5]))
    dut.GetInputPort("navigation_field").FixValue(
        simulator.get_mutable_context(), other
    )
    assert out(dut, simulator, "world_status")[0] == 0.0
    simulator.AdvanceTo(0.1)
    assert out(dut, simulator, "certified_world").field == other
    assert out(dut, simulator, "world_status")[0] == 1.0


def test_a_trap_before_the_start_keeps_the_robot_holding(dut):
    simulator = run(dut, areas=WALL, start=np.array([-0.9, 0.0]))
    assert out(dut, simulator, "certificate_verdict")[0] == WorldVerdict.REFUTED
    assert out(dut, simulator, "world_status")[0] == 0.0


def test_a_start_whose_own_region_is_proved_may_go_on_despite_a_trap_elsewhere(dut):
    beyond = np.array([0.2, 0.4])
    simulator = run(dut, areas=WALL, start=beyond)
    world = out(dut, simulator, "certified_world")
    assert world.certificate.region is not None
    assert out(dut, simulator, "certificate_verdict")[0] == WorldVerdict.PROVED
    assert out(dut, simulator, "world_status")[0] == 1.0
    # Pushed back before the wall, the proof covers it no more, at once and later.
    context = simulator.get_mutable_context()
    dut.GetInputPort("canonical_reference").FixValue(context, np.array([-0.9, 0.0]))
    assert out(dut, simulator, "world_status")[0] == 0.0
    simulator.AdvanceTo(0.1)
    assert out(dut, simulator, "world_status")[0] == 0.0
    assert out(dut, simulator, "certificate_verdict")[0] == WorldVerdict.REFUTED


def test_a_start_that_is_not_free_is_not_proved(dut):
    simulator = run(dut, start=np.array([0.3, -0.12]))
    assert out(dut, simulator, "world_status")[0] == 0.0


@pytest.mark.parametrize(("status", "sound"), [(0.0, 0.0), (1.0, 1.0)])
def test_where_no_sound_world_was_found_the_proof_alone_does_not_do(dut, status, sound):
    simulator = run(dut)
    port = dut.GetInputPort("reconciler_status")
    port.FixValue(simulator.get_mutable_context(), [status])
    assert out(dut, simulator, "world_status")[0] == sound


def test_reading_its_ports_proves_nothing(dut):
    context = run(dut, end=0.0).get_context()
    for k in range(dut.num_output_ports()):
        dut.get_output_port(k).Eval(context)
    assert not dut.GetOutputPort("certified_world").Eval(context).made


def test_at_a_gate_the_proof_of_the_next_world_is_there_already(dut):
    later = FIELD.with_goal(np.array([0.6, 0.5]))
    entry = np.array([0.5, 0.2])
    ahead = (join_areas(FIELD, AREA, START), join_areas(later, AREA, entry))
    simulator = Simulator(dut, dut.CreateDefaultContext())
    context = simulator.get_mutable_context()
    dut.GetInputPort("reconciled_worlds").FixValue(context, Value[object](ahead))
    run(dut, areas=ahead[0].sensed, field=ahead[0].virtual, simulator=simulator)
    simulator.AdvanceTo(0.1)
    run(
        dut,
        areas=ahead[1].sensed,
        field=ahead[1].virtual,
        start=entry + 0.01,
        simulator=simulator,
        end=0.1,
    )
    # Not a moment later, and it is told as that of the new world.
    assert out(dut, simulator, "world_status")[0] == 1.0
    assert out(dut, simulator, "certified_world").field == ahead[1].field
    np.testing.assert_array_equal(out(dut, simulator, "certified_start"), entry)


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan"), float("inf")])
def test_its_period_must_be_positive(period):
    with pytest.raises(ValueError, match="period must be positive"):
        CertificateMonitor(period=period)
