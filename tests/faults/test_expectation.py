"""A run shows the reaction that was expected, or it does not."""

import numpy as np
import pytest

from bath_drake.faults.expectation import (
    Expectation,
    check_expectation,
    judge_reaction,
    reaction_checks,
)
from bath_drake.safety.reasons import Mode, Reason

TIME = np.arange(0.0, 4.0, 0.01)
HOLD = Expectation(row=1, begins=1.0, ends=2.0, reasons=["FRAME_STALE"], resumes=True)


def judged(expected, *, hold=(1.0, 2.2), mode=Mode.HOLD, reason=Reason.FRAME_STALE):
    during = (hold[0] <= TIME) & (hold[1] > TIME)
    return judge_reaction(
        expected,
        expected.begins,
        time=TIME,
        mode=np.where(during, mode, Mode.PASS).astype(float),
        reason=np.where(during, reason, Reason.NONE).astype(float),
        emitted=np.zeros((len(TIME), 14)),
    )


def passed(expected, found):
    return all(check["pass"] for check in reaction_checks(expected, found).values())


def test_a_hold_in_time_that_ends_by_itself_is_as_expected():
    found = judged(HOLD)
    assert found["seconds"] == pytest.approx(0.0)
    assert passed(HOLD, found)


@pytest.mark.parametrize(
    "wrong",
    [
        {"hold": (1.2, 2.2)},  # too late
        {"hold": (0.0, 2.2)},  # it held anyway
        {"hold": (1.0, 1.5)},  # it went on while the fault was there
        {"hold": (1.0, 9.0)},  # it never went on
        {"reason": Reason.SINGULAR},
        {"mode": Mode.STOP},
        {"hold": (8.0, 9.0)},  # nothing happened
    ],
)
def test_anything_else_is_not(wrong):
    assert not passed(HOLD, judged(HOLD, **wrong))


def test_an_arm_that_moves_while_held_is_seen():
    during = (TIME >= 1.0) & (TIME < 2.2)
    emitted = np.zeros((len(TIME), 14))
    emitted[TIME > 1.5, 8] = 0.01
    found = judge_reaction(
        HOLD,
        1.0,
        time=TIME,
        mode=np.where(during, Mode.HOLD, Mode.PASS).astype(float),
        reason=np.where(during, Reason.FRAME_STALE, Reason.NONE).astype(float),
        emitted=emitted,
    )
    assert found["at_rest"] is False
    emitted[10, 0] = np.nan
    assert not passed(HOLD, found)


def test_going_on_means_never_to_hold():
    goes = Expectation(reaction="go_on", begins=1.0)
    assert passed(goes, judged(goes, hold=(8.0, 9.0)))
    assert not passed(goes, judged(goes, hold=(3.0, 3.1)))


def test_a_condition_that_never_came_is_no_success():
    found = judge_reaction(
        HOLD,
        None,
        time=TIME,
        mode=np.zeros(len(TIME)),
        reason=np.zeros(len(TIME)),
        emitted=np.zeros((len(TIME), 14)),
    )
    assert not passed(HOLD, found)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"row": -1}, "row: found -1"),
        ({"reaction": "flee"}, "reaction: found 'flee'"),
        ({"reasons": ["TIRED"]}, "reasons: found 'TIRED'"),
        ({"reasons": []}, "allowed at least one"),
        ({"reaction": "go_on"}, "none where it goes on"),
        ({"begins": 3.0}, "before ends"),
        ({"within": 0.0}, "within: found 0.0"),
    ],
)
def test_what_expects_nothing_is_refused_by_its_key(wrong, message):
    with pytest.raises(ValueError, match=message):
        check_expectation(Expectation(**{**vars(HOLD), **wrong}))
