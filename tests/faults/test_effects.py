"""What faults do to signals, and where made-up areas are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.faults.effects import areas_at, faulty_signal
from bath_drake.faults.script import (
    KINDS,
    AreaFault,
    FaultScript,
    SignalFault,
    check_script,
)
from bath_drake.faults.touch import REACTION_S, area_touches
from bath_drake.perception.faults import within

VALUE, HELD = np.array([1.0, 2.0, 3.0]), np.array([-1.0, -2.0, -3.0])


def fault(kind, **more):
    return SignalFault(port="a.b", kind=kind, begin=1.0, end=2.0, **more)


@given(st.sampled_from(KINDS), st.floats(0.0, 5.0))
def test_outside_of_its_time_a_fault_changes_nothing(kind, t):
    found = faulty_signal(VALUE, HELD, fault(kind, value=7.0), t)
    if not 1.0 - 1e-9 <= t < 2.0:
        np.testing.assert_array_equal(found, VALUE)


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ("nan", [1.0, np.nan, 3.0]),
        ("constant", [1.0, 4.0, 3.0]),
        ("offset", [1.0, 6.0, 3.0]),
        ("ramp", [1.0, 4.0, 3.0]),
        ("frozen", [1.0, -2.0, 3.0]),
        ("drift", [-1.0, 0.0, -3.0]),
    ],
)
def test_each_kind_changes_the_elements_it_names(kind, expected):
    found = faulty_signal(VALUE, HELD, fault(kind, value=4.0, elements=[1]), 1.5)
    np.testing.assert_allclose(found, expected)


def test_a_fault_never_changes_what_it_was_given():
    before = VALUE.copy()
    for kind in KINDS:
        faulty_signal(VALUE, HELD, fault(kind, value=4.0), 1.5)
    np.testing.assert_array_equal(VALUE, before)


def test_an_area_from_the_tool_moves_from_where_the_tool_was():
    area = AreaFault(
        centre=[0.1, 0.0], velocity=[0.5, 0.0], from_tool=True, begin=1.0, end=3.0
    )
    tools = {0: np.array([0.2, -0.3])}
    assert len(areas_at([area], 0.5, tools)) == 0
    np.testing.assert_allclose(areas_at([area], 2.0, tools).theta[0, :2], [0.8, -0.3])
    # Not begun for the Diagram: nobody said where the tool was.
    assert len(areas_at([area], 2.0, {})) == 0


def test_being_overtaken_by_an_area_is_no_entry_but_going_in_is():
    time = np.arange(0.0, 1.0, 0.1)
    still = np.zeros((10, 2))
    comes = AreaFault(centre=[1.0, 0.0], semi_axes=[0.3, 0.3], velocity=[-2.0, 0.0])
    first, entries = area_touches([comes], time, still)
    assert first == pytest.approx(0.4)
    assert entries == 0
    walks = np.column_stack([np.linspace(-1.0, 1.0, 10), np.zeros(10)])
    stays = AreaFault(centre=[0.0, 0.0], semi_axes=[0.3, 0.3])
    assert area_touches([stays], time, walks)[1] == 1
    assert area_touches([], time, walks) == (None, 0)


def test_what_appears_right_before_the_nozzle_is_entered_without_fault():
    time = np.arange(0.0, 2.0, 0.01)
    walks = np.column_stack([time - 1.0, np.zeros(200)])
    for begin, entries in ((1.0 - REACTION_S - 0.02, 1), (1.0 - REACTION_S + 0.02, 0)):
        wall = AreaFault(centre=[0.3, 0.0], semi_axes=[0.3, 0.3], begin=begin, end=1.5)
        assert area_touches([wall], time, walks)[1] == entries


def test_crossing_an_area_high_above_the_skin_is_no_entry():
    time = np.arange(0.0, 2.0, 0.01)
    walks = np.column_stack([time - 1.0, np.zeros(200)])
    area = AreaFault(centre=[0.0, 0.0], semi_axes=[0.3, 0.3])
    assert area_touches([area], time, walks, time > 0.5)[1] == 1
    # On its way down into one it was in it already: the guard does not let it.
    for down in (time < 0.0, time > 1.0, time < 0.5):
        first, entries = area_touches([area], time, walks, down)
        assert first == pytest.approx(0.71, abs=0.011)
        assert entries == 0


def test_to_drift_along_the_rim_of_an_area_that_leaves_is_no_entry():
    # It appears over the point and slides off; the point, slower, goes the same way.
    time = np.arange(0.0, 1.0, 0.01)
    leaves = AreaFault(centre=[0.0, 0.0], semi_axes=[0.3, 0.3], velocity=[-1.0, 0.0])
    drifts = np.column_stack([-0.5 * time, np.zeros(100)])
    first, entries = area_touches([leaves], time, drifts)
    assert (first, entries) == (0.0, 0)
    # One that comes back goes into it, however slow the area is.
    back = np.where(time[:, None] < 0.4, drifts, [[-0.1, 0.0]])
    back[45:60] = [-0.45, 0.0]
    assert area_touches([leaves], time, back)[1] == 1


@pytest.mark.parametrize(
    ("script", "message"),
    [
        (FaultScript(signals=[SignalFault(port="a")]), r"signals\[0\].port: found 'a'"),
        (
            FaultScript(signals=[SignalFault(port="joint_guard.checked_command")]),
            "an output of no guard",
        ),
        (FaultScript(signals=[SignalFault(port="a.b", kind="x")]), "kind: found 'x'"),
        (
            FaultScript(signals=[SignalFault(port="a.b")] * 2),
            "fault of a port at a time",
        ),
        (FaultScript(areas=[AreaFault(semi_axes=[0.0, 1.0])]), "allowed above 0"),
        (FaultScript(areas=[AreaFault(begin=2.0, end=1.0)]), "the end later"),
        (FaultScript(areas=[AreaFault(centre=[0.0])]), "two finite numbers"),
        (
            FaultScript(signals=[SignalFault(port="a.b", value=float("nan"))]),
            "value: found nan",
        ),
    ],
)
def test_what_makes_no_fault_is_refused_by_its_key(script, message):
    with pytest.raises(ValueError, match=message):
        check_script(script)


def test_a_fault_is_on_from_its_beginning_to_just_before_its_end():
    assert within(fault("nan"), 1.0)
    assert not within(fault("nan"), 2.0)


def test_a_port_may_have_one_fault_after_the_other():
    once = SignalFault(port="a.b", begin=0.0, end=1.0)
    again = SignalFault(port="a.b", begin=1.0, end=2.0)
    check_script(FaultScript(signals=[once, again]))
