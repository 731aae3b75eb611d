import dataclasses

import numpy as np
import pytest
from pydrake.common.value import Value

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.surface import desired_nozzle_pose, fit_surface
from bath_drake.systems.surface_reference import SurfaceReference

ROLL, STANDOFF, RADIUS = 0.4, 0.06, 0.04
P_NQ = np.array([0.3, -0.2])
BODY = CanonicalMap(
    np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    np.array([0.7, 0.0, 0.9]),
    np.array([0.17, 0.25]),
)


@pytest.fixture
def observation():
    rng = np.random.default_rng(6)
    x, z = (rng.uniform(-1, 1, (8000, 2)) * BODY.half_extents).T
    points = np.column_stack([x, x**2 - 0.02, z]) + BODY.p_WP
    return dataclasses.replace(BodyObservation(), found=True, points_W=points)


@pytest.fixture
def dut():
    return SurfaceReference(radius=RADIUS, roll=ROLL)


def _context(dut, observation):
    context = dut.CreateDefaultContext()
    dut.GetInputPort("canonical_reference").FixValue(context, P_NQ)
    dut.GetInputPort("canonical_map").FixValue(context, Value(BODY))
    dut.GetInputPort("body_observation").FixValue(context, Value(observation))
    dut.GetInputPort("standoff").FixValue(context, [STANDOFF])
    return context


def test_patch_and_pose_are_those_of_the_pure_functions(dut, observation):
    context = _context(dut, observation)
    expected = fit_surface(observation.points_W, BODY, P_NQ, RADIUS)
    patch = dut.GetOutputPort("surface_patch").Eval(context)
    np.testing.assert_array_equal(patch.p_WS, expected.p_WS)
    np.testing.assert_array_equal(patch.normal_W, expected.normal_W)
    R_WE, p_WE = desired_nozzle_pose(expected, STANDOFF, BODY, ROLL)
    X_WE = dut.GetOutputPort("desired_nozzle_pose").Eval(context)
    np.testing.assert_array_equal(X_WE.translation(), p_WE)
    np.testing.assert_array_equal(X_WE.rotation().matrix(), R_WE)
    assert dut.GetOutputPort("surface_status").Eval(context)[0] == 1.0
    normal = dut.GetOutputPort("surface_normal").Eval(context)
    np.testing.assert_array_equal(normal, expected.normal_W)


def test_a_new_standoff_moves_the_nozzle_alone(dut, observation):
    context = _context(dut, observation)
    port = dut.GetOutputPort("desired_nozzle_pose")
    before = port.Eval(context).translation().copy()
    patch = dut.GetOutputPort("surface_patch").Eval(context)
    dut.GetInputPort("standoff").FixValue(context, [STANDOFF + 0.08])
    after = port.Eval(context).translation()
    np.testing.assert_allclose(after - before, 0.08 * patch.normal_W, atol=1e-12)


def test_no_skin_is_status_zero_and_still_a_pose(dut):
    context = _context(dut, BodyObservation())
    assert dut.GetOutputPort("surface_status").Eval(context)[0] == 0.0
    assert not dut.GetOutputPort("surface_patch").Eval(context).valid
    normal = dut.GetOutputPort("surface_normal").Eval(context)
    np.testing.assert_array_equal(normal, np.zeros(3))
    X_WE = dut.GetOutputPort("desired_nozzle_pose").Eval(context)
    assert np.isfinite(X_WE.translation()).all()


@pytest.mark.parametrize(
    ("name", "value"),
    [("radius", 0.0), ("radius", 0.5), ("roll", float("inf"))],
)
def test_bad_parameters_are_refused(name, value):
    with pytest.raises(ValueError, match=name):
        SurfaceReference(**{name: value})
