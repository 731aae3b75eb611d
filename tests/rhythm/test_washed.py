"""What is said of washed cycles: how many, how much, how large."""

import numpy as np
import pytest

from bath_drake.rhythm.limit_cycle import LimitCycle
from bath_drake.rhythm.washed import washed_cycles

CYCLE = LimitCycle(np.array([[0.1, 0.0], [0.0, 0.06]]), 1.0, 0.1)
ASKED = CYCLE.offset(np.linspace(0.0, 14.0 * np.pi, 1400))


def test_all_that_was_asked_for():
    told = washed_cycles(CYCLE, np.add(ASKED, [0.02, -0.01]), ASKED)
    assert told["cycles"] == pytest.approx(7.0, abs=0.5)
    assert told["gain"] == pytest.approx(1.0, abs=1e-3)
    # The 95 % quantile of an oval's distances.
    assert told["asked_share"] == pytest.approx(1.0, abs=0.01)


def test_half_the_size_is_half_the_gain():
    assert washed_cycles(CYCLE, 0.5 * ASKED, ASKED)["gain"] == pytest.approx(0.5)
    shrunk = washed_cycles(CYCLE, 0.5 * ASKED, 0.5 * ASKED)
    assert shrunk["asked_share"] == pytest.approx(0.5, abs=0.01)
    assert shrunk["gain"] == pytest.approx(1.0)


def test_without_cycles_nothing_is_said():
    assert washed_cycles(None, ASKED, 0.0 * ASKED) is None
    assert washed_cycles(CYCLE, ASKED, 0.0 * ASKED) is None
