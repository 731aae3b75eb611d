"""The joints' velocities: Drake's answer, found sooner where no limit binds."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from bath_drake.control._joint_velocities import TOO_FAST
from bath_drake.control.avoidance import AvoidanceConfig
from bath_drake.scene.arm import make_control_plant
from bath_drake.scene.config import ArmConfig
from bath_drake.systems import _joint_solver
from bath_drake.systems._joint_solver import JointSolver

PLANT = make_control_plant(ArmConfig())
POSTURE = np.array(ArmConfig().posture)
LOW, HIGH = PLANT.GetPositionLowerLimits(), PLANT.GetPositionUpperLimits()
SPEED = 0.5 * PLANT.GetVelocityUpperLimits()
STEP, ACCELERATION = 0.005, 20.0
# Of both answers, rounding; Drake keeps its bounds to about a thousandth, rad/s.
SAME, KEPT = 1e-9, 2e-3


def solver():
    return JointSolver(
        plant=PLANT,
        limits=(LOW, HIGH),
        posture=POSTURE,
        time_step=STEP,
        speed_fraction=0.5,
        acceleration=ACCELERATION,
        centering_gain=1.0,
        avoidance=AvoidanceConfig(),
    )


def answer(q, v, twist, dut=None):
    dut = dut or solver()
    R_WE, _ = dut.nozzle(q, v)
    return dut.solve(q, v, twist, R_WE, None)


def drakes_answer(monkeypatch, q, v, twist):
    with monkeypatch.context() as patched:
        patched.setattr(_joint_solver, "solve", lambda *_: TOO_FAST)
        return answer(q, v, twist)


def sevens(size):
    return st.lists(st.floats(-size, size), min_size=7, max_size=7).map(np.array)


TWISTS = st.lists(st.floats(-0.05, 0.05), min_size=6, max_size=6).map(np.array)


@given(sevens(0.05), sevens(0.01), TWISTS)
def test_where_nothing_binds_it_is_drakes_answer(aside, v, twist):
    q = POSTURE + aside
    found = answer(q, v, twist)
    # Near a bound Drake's solver stops short of the exact answer.
    assume(found is not None and np.abs(found - v).max() < 0.9 * ACCELERATION * STEP)
    with pytest.MonkeyPatch.context() as monkeypatch:
        theirs = drakes_answer(monkeypatch, q, v, twist)
    np.testing.assert_allclose(found, theirs, atol=SAME)


def test_where_nothing_binds_drake_is_not_asked(monkeypatch):
    def asked(*_):
        raise AssertionError("asked")

    monkeypatch.setattr(_joint_solver, "DoDifferentialInverseKinematics", asked)
    assert answer(POSTURE, np.zeros(7), np.full(6, 0.01)) is not None
    with pytest.raises(AssertionError, match="asked"):
        answer(POSTURE, np.zeros(7), np.full(6, 5.0))


@given(sevens(0.3), sevens(0.3), TWISTS.map(lambda twist: 20.0 * twist))
def test_no_limit_is_passed(aside, v, twist):
    found = answer(POSTURE + aside, v, twist)
    if found is None:
        return
    assert (np.abs(found) <= SPEED + KEPT).all()
    assert (np.abs(found - v) <= ACCELERATION * STEP + KEPT).all()


def test_at_the_end_of_its_range_a_joint_goes_no_further():
    q = POSTURE.copy()
    q[1] = HIGH[1]
    # Straight down: the second joint alone would lean further out.
    found = answer(q, np.zeros(7), np.array([0.0, 0.0, 0.0, 0.0, 0.0, -0.05]))
    assert found is None or found[1] <= KEPT
