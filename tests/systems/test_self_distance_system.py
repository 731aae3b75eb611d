from math import nan

import numpy as np
import pytest

from bath_drake.safety.self_distance import self_distance_ahead
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.scene.config import ArmConfig
from bath_drake.systems.self_distance import SelfDistance

HOME = np.array(ArmConfig().home)
CHAIN = arm_chain(ArmConfig())


def evaluated(dut, q, v):
    context = dut.CreateDefaultContext()
    dut.GetInputPort("joint_command").FixValue(context, np.concatenate([q, v]))
    (distance,) = dut.GetOutputPort("self_distance").Eval(context)
    return distance


@pytest.mark.parametrize("lookahead", [0.0, 0.3])
def test_the_distance_is_that_of_the_pure_function(lookahead):
    v = np.linspace(-1.0, 1.0, 7)
    distance = evaluated(SelfDistance(arm=CHAIN, lookahead=lookahead), HOME, v)
    assert distance == self_distance_ahead(HOME, v, CHAIN, lookahead)


def test_a_command_that_is_no_number_gives_none():
    assert np.isnan(evaluated(SelfDistance(arm=CHAIN), HOME, np.full(7, nan)))


@pytest.mark.parametrize("lookahead", [-0.1, nan])
def test_a_lookahead_that_is_none_is_refused(lookahead):
    with pytest.raises(ValueError, match="lookahead"):
        SelfDistance(arm=CHAIN, lookahead=lookahead)
