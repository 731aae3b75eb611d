import dataclasses

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.safety.hold import HoldReason
from bath_drake.systems.hold_supervisor import HoldSupervisor

SEEN = dataclasses.replace(BodyObservation(), stamp=1.0, found=True)


@pytest.fixture
def dut():
    return HoldSupervisor(period=0.01)


@pytest.fixture
def context(dut):
    context = dut.CreateDefaultContext()
    context.SetTime(1.02)
    dut.GetInputPort("body_observation").FixValue(context, SEEN)
    dut.GetInputPort("map_status").FixValue(context, [1.0])
    dut.GetInputPort("surface_status").FixValue(context, [1.0])
    dut.GetInputPort("ik_status").FixValue(context, [0.0])
    dut.GetInputPort("world_status").FixValue(context, [1.0])
    return context


def test_the_robot_moves_while_all_is_well(dut, context):
    assert dut.GetOutputPort("hold").Eval(context)[0] == 0.0
    assert dut.GetOutputPort("hold_reason").Eval(context)[0] == HoldReason.NONE


@pytest.mark.parametrize(
    ("port", "value", "reason"),
    [
        ("body_observation", BodyObservation(), HoldReason.NO_FRAME),
        (
            "body_observation",
            dataclasses.replace(SEEN, found=False, unfound_since=0.98),
            HoldReason.BODY_HIDDEN,
        ),
        (
            "body_observation",
            dataclasses.replace(SEEN, found=False, unfound_since=0.9),
            HoldReason.BODY_LOST,
        ),
        ("map_status", [0.0], HoldReason.BODY_JUMPED),
        ("surface_status", [0.0], HoldReason.SURFACE_UNSEEN),
        ("ik_status", [1.0], HoldReason.NO_JOINT_SOLUTION),
        ("world_status", [0.0], HoldReason.UNSOUND_WORLD),
    ],
)
def test_it_holds_with_the_reason(dut, context, port, value, reason):
    dut.GetInputPort(port).FixValue(context, value)
    assert dut.GetOutputPort("hold").Eval(context)[0] == 1.0
    assert dut.GetOutputPort("hold_reason").Eval(context)[0] == reason


def test_a_frame_grows_stale_as_time_goes_by_and_is_counted_once(dut, context):
    simulator = Simulator(dut, context)
    simulator.AdvanceTo(1.3)
    counts = dut.GetOutputPort("hold_counts").Eval(context)
    expected = np.zeros(len(HoldReason))
    expected[HoldReason.STALE_FRAME] = 1.0
    np.testing.assert_array_equal(counts, expected)


@pytest.mark.parametrize("name", ["max_frame_age", "lost_time", "period"])
def test_its_numbers_must_be_positive(name):
    with pytest.raises(ValueError, match=name):
        HoldSupervisor(**{name: 0.0})
