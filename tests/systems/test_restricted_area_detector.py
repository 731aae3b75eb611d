import numpy as np
import pytest
from made_up_back import BODY, observed_back
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.given_areas import given_areas
from bath_drake.perception.restricted import find_restricted_areas
from bath_drake.systems.restricted_area_detector import RestrictedAreaDetector

MARGIN, PERIOD = 0.02, 0.1


@pytest.fixture
def simulator():
    dut = RestrictedAreaDetector(margin=MARGIN, period=PERIOD)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.GetInputPort("canonical_map").FixValue(context, Value(BODY))
    return simulator


def _look(simulator, observation, until):
    dut = simulator.get_system()
    context = simulator.get_mutable_context()
    dut.GetInputPort("body_observation").FixValue(context, Value(observation))
    simulator.AdvanceTo(until)
    return dut.GetOutputPort("sensed_obstacles").Eval(simulator.get_context())


def test_the_areas_are_those_of_the_pure_function(simulator):
    areas = _look(simulator, observed_back(), 0.5 * PERIOD)
    assert len(areas) == 1
    assert areas == find_restricted_areas(observed_back(), BODY, MARGIN)


def test_an_area_seen_for_some_frames_stays(simulator):
    for k in range(5):
        before = _look(simulator, observed_back(stamp=k * PERIOD), (k + 0.5) * PERIOD)
    for k in range(5, 30):
        clear = observed_back(wound=False, stamp=k * PERIOD)
        assert _look(simulator, clear, (k + 0.5) * PERIOD) == before
    assert _look(simulator, BodyObservation(), 31 * PERIOD) == before


def test_an_area_that_one_frame_showed_goes_after_a_second_of_clear_skin(simulator):
    assert len(_look(simulator, observed_back(), 0.5 * PERIOD)) == 1
    counts = [
        len(
            _look(
                simulator,
                observed_back(wound=False, stamp=k * PERIOD),
                (k + 0.5) * PERIOD,
            )
        )
        for k in range(1, 14)
    ]
    assert counts == [1] * 10 + [0] * 3


def test_one_frame_counts_once(simulator):
    assert len(_look(simulator, observed_back(), 2.5)) == 1
    # Twenty-five looks at one frame confirm nothing: a second of clear skin clears it.
    for k in range(26, 40):
        clear = observed_back(wound=False, stamp=k * PERIOD)
        areas = _look(simulator, clear, (k + 0.5) * PERIOD)
    assert len(areas) == 0


def test_without_a_body_nothing_is_sensed(simulator):
    assert len(_look(simulator, BodyObservation(), 0.5 * PERIOD)) == 0


@pytest.mark.parametrize(
    ("name", "value"),
    [("margin", -0.01), ("margin", float("nan")), ("period", 0.0), ("min_area", 0.0)],
)
def test_bad_parameters_are_refused(name, value):
    good = {"margin": MARGIN, "period": PERIOD}
    with pytest.raises(ValueError, match=name):
        RestrictedAreaDetector(**{**good, name: value})


def test_what_the_carer_gave_is_there_from_the_first_frame_on():
    polygon = [[-0.6, -0.5], [-0.3, -0.5], [-0.45, -0.2]]
    dut = RestrictedAreaDetector(margin=MARGIN, period=PERIOD, given=[polygon])
    context = dut.CreateDefaultContext()
    dut.GetInputPort("canonical_map").FixValue(context, Value(BODY))
    dut.GetInputPort("body_observation").FixValue(context, Value(BodyObservation()))
    simulator = Simulator(dut, context)
    port = dut.GetOutputPort("sensed_obstacles")
    simulator.AdvanceTo(0.05)
    assert len(port.Eval(context)) == 0  # nobody is there yet
    expected = given_areas([np.array(polygon)], BODY, MARGIN)
    dut.GetInputPort("body_observation").FixValue(context, Value(observed_back(False)))
    simulator.AdvanceTo(0.15)
    np.testing.assert_array_equal(port.Eval(context).theta, expected.theta)
    # A wound that is seen later is another area; the given one stays as it is.
    wounded = observed_back(stamp=0.2)
    dut.GetInputPort("body_observation").FixValue(context, Value(wounded))
    simulator.AdvanceTo(0.35)
    theta = port.Eval(context).theta
    assert len(theta) == 2
    np.testing.assert_array_equal(theta[0], expected.theta[0])


def test_a_given_area_that_is_none_is_refused():
    with pytest.raises(ValueError, match="at least 3 corners"):
        RestrictedAreaDetector(margin=MARGIN, period=PERIOD, given=[[[0.0, 0.0]]])
