import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from bath_drake.control.approach import Phase
from bath_drake.control.force_regulation import (
    ForceLimits,
    ForceState,
    Touch,
    next_force_state,
)
from bath_drake.systems.force_regulator import ForceRegulator

LIMITS, DT = ForceLimits(), 0.005
STANDOFF = 0.068


def regulated(force, *, seconds, phase=Phase.WASH, hold=None):
    """A regulator that felt one force, in E against z, for so long, and its outputs."""
    system = ForceRegulator(limits=LIMITS, period=DT)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    system.GetInputPort("approach_standoff").FixValue(context, [STANDOFF])
    system.GetInputPort("approach_phase").FixValue(context, [float(phase)])
    wrench = np.zeros(7)
    wrench[6] = -force
    system.GetInputPort("wrench").FixValue(context, wrench)
    if hold is not None:
        system.GetInputPort("hold").FixValue(context, [hold])
    simulator.AdvanceTo(seconds)
    return {
        name: float(system.GetOutputPort(name).Eval(context)[0])
        for name in ("standoff", "phase", "asked_force", "touch")
    }


def expected(force, steps):
    state = ForceState()
    for _ in range(steps):
        state = next_force_state(
            state, force, Phase.WASH, held=False, dt=DT, limits=LIMITS
        )
    return state


@pytest.mark.parametrize("force", [0.0, 1.5, 4.0, 12.0])
def test_every_output_is_that_of_the_pure_law(force):
    # Updates at 0, 5, ..., 100 ms.
    found, state = regulated(force, seconds=0.101), expected(force, 21)
    assert found["standoff"] == STANDOFF - state.depth
    assert found["asked_force"] == state.asked
    assert found["touch"] == state.touch
    assert found["phase"] == (Phase.WASH if state.washing else Phase.DESCEND)


def test_on_the_way_to_the_skin_the_approach_is_passed_on():
    found = regulated(4.0, seconds=1.0, phase=Phase.DESCEND)
    assert found == {
        "standoff": STANDOFF,
        "phase": Phase.DESCEND,
        "asked_force": 0.0,
        "touch": Touch.AWAY,
    }


def test_while_held_it_is_away():
    found = regulated(4.0, seconds=1.0, hold=1.0)
    assert found["standoff"] == STANDOFF
    assert found["touch"] == Touch.AWAY
    assert regulated(4.0, seconds=1.0, hold=0.0)["touch"] == Touch.PRESS


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan")])
def test_the_period_must_be_positive(period):
    with pytest.raises(ValueError, match="period must be positive"):
        ForceRegulator(limits=LIMITS, period=period)
