"""The injectors and stand-ins give what their pure functions say."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource, ConstantVectorSource

from bath_drake.faults.script import AreaFault as Area
from bath_drake.faults.script import SignalFault as Fault
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.systems.area_fault import AreaFault
from bath_drake.systems.arm_link import ArmLink
from bath_drake.systems.force_sensor import ForceSensor
from bath_drake.systems.signal_fault import SignalFault

FRAME = 1.0 / 30.0


def out(system, context, port):
    own = system.GetMyContextFromRoot(context)
    return system.GetOutputPort(port).Eval(own)


def alone(system, **inputs):
    """A simulator of a system with constant inputs."""
    builder = DiagramBuilder()
    builder.AddSystem(system)
    for name, value in inputs.items():
        if isinstance(value, np.ndarray):
            source = ConstantVectorSource(value)
        else:
            source = ConstantValueSource(Value(value))
        builder.AddSystem(source)
        builder.Connect(source.get_output_port(), system.GetInputPort(name))
    return Simulator(builder.Build())


def test_a_signal_passes_but_for_the_time_of_its_fault():
    system = SignalFault(fault=Fault(port="a.b", begin=0.5, end=1.0), size=2)
    simulator = alone(system, signal=np.array([1.0, 2.0]))
    for until, finite in ((0.4, True), (0.7, False), (1.2, True)):
        simulator.AdvanceTo(until)
        found = out(system, simulator.get_context(), "faulty_signal")
        assert np.isfinite(found).all() == finite


def test_a_frozen_signal_is_that_before_the_fault():
    system = SignalFault(
        fault=Fault(port="a.b", kind="frozen", begin=0.5, end=9.0), size=7
    )
    builder = DiagramBuilder()
    sensor = builder.AddSystem(ForceSensor(seed=1))
    builder.AddSystem(system)
    builder.Connect(sensor.get_output_port(), system.get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.6)
    held = out(system, simulator.get_context(), "faulty_signal").copy()
    simulator.AdvanceTo(0.8)
    np.testing.assert_array_equal(
        out(system, simulator.get_context(), "faulty_signal"), held
    )
    assert 0.49 <= held[0] <= 0.5


def test_an_element_that_the_signal_has_not_is_refused():
    with pytest.raises(ValueError, match="allowed 0 to 1"):
        SignalFault(fault=Fault(port="a.b", elements=[2]), size=2)


def test_an_area_appears_where_the_tool_is_and_goes_again():
    sensed = ObstacleSet([[0.5, 0.5, 0.1, 0.1, 0.0]])
    fault = Area(from_tool=True, begin=0.2, end=0.4)
    system = AreaFault(faults=[fault], period=FRAME)
    tool = np.array([0.1, -0.2])
    simulator = alone(system, sensed_obstacles=sensed, canonical_position=tool)
    for until, count in ((0.1, 1), (0.3, 2), (0.6, 1)):
        simulator.AdvanceTo(until)
        found = out(system, simulator.get_context(), "sensed_obstacles")
        assert len(found) == count
        if count == 2:
            np.testing.assert_allclose(found.theta[1, :2], tool)


def test_the_force_sensor_is_fresh_never_the_same_and_small():
    sensor = ForceSensor(seed=3, period=0.005)
    simulator = alone(sensor)
    before = None
    for k in range(1, 40):
        simulator.AdvanceTo(0.005 * k + 0.001)
        wrench = out(sensor, simulator.get_context(), "wrench").copy()
        assert wrench[0] == pytest.approx(0.005 * k)
        # Six standard deviations.
        assert np.abs(wrench[4:]).max() < 0.3
        assert before is None or (wrench[1:] != before[1:]).all()
        before = wrench


def test_the_same_seed_measures_the_same():
    first, second = (alone(ForceSensor(seed=5)) for _ in range(2))
    values = []
    for simulator in (first, second):
        simulator.AdvanceTo(0.1)
        root = simulator.get_system()
        values.append(out(root.GetSystems()[0], simulator.get_context(), "wrench"))
    np.testing.assert_array_equal(*values)


@pytest.mark.parametrize("known", [True, False])
def test_the_link_answers_now_unless_the_state_is_no_number(known):
    link = ArmLink()
    state = np.zeros(14)
    if not known:
        state[3] = np.nan
    simulator = alone(link, arm_state=state)
    simulator.AdvanceTo(0.25)
    context = simulator.get_context()
    stamp = out(link, context, "robot_stamp")[0]
    assert stamp == 0.25 if known else np.isnan(stamp)
    assert out(link, context, "loop_seconds")[0] == 0.0


@pytest.mark.parametrize("wrong", [0.0, -0.03, np.nan])
def test_the_link_tells_how_far_a_joint_is_off_what_it_was_told(wrong):
    link = ArmLink()
    told = np.linspace(-1.0, 1.0, 14)
    state = np.concatenate([told[:7], np.zeros(7)])
    state[3] += wrong
    simulator = alone(link, arm_state=state, checked_command=told)
    (error,) = out(link, simulator.get_context(), "following_error")
    # 1e-15: the sum's rounding.
    np.testing.assert_allclose(error, abs(wrong), atol=1e-15)


@pytest.mark.parametrize(
    "wrong", [{"seed": -1}, {"seed": 0, "period": 0.0}, {"seed": 0, "force_noise": 0}]
)
def test_a_sensor_that_is_none_is_refused(wrong):
    with pytest.raises(ValueError, match="must be"):
        ForceSensor(**wrong)
