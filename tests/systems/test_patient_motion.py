"""PatientMotion's ports against the pure function."""

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import FrameId
from pydrake.math import RigidTransform

from bath_drake.patient.motion import MotionConfig, person_pose
from bath_drake.systems.patient_motion import PatientMotion

FRAME = FrameId.get_new_id()
SOUND = {
    "frame_id": FRAME,
    "motion": MotionConfig(),
    "person_position": np.array([0.75, 0.1, 0.0]),
    "person_yaw": 1.2,
    "hips": np.array([0.0, -0.1, 0.5]),
    "breath_direction": np.array([0.0, 2.0, 0.0]),
}


@pytest.fixture
def dut():
    return PatientMotion(**SOUND)


def expected(t):
    unit = SOUND["breath_direction"] / 2.0
    return person_pose(
        t,
        SOUND["motion"],
        SOUND["person_position"],
        SOUND["person_yaw"],
        SOUND["hips"],
        unit,
    )


@pytest.mark.parametrize("t", [0.0, 0.7, 3.0, 61.3])
def test_both_ports_give_the_pure_functions_pose(dut, t):
    context = dut.CreateDefaultContext()
    context.SetTime(t)
    R, p = expected(t)
    X_WM = dut.GetOutputPort("geometry_pose").Eval(context).value(FRAME)
    # The rotation is projected once, which moves it by rounding.
    np.testing.assert_allclose(X_WM.rotation().matrix(), R, atol=1e-14)
    np.testing.assert_array_equal(X_WM.translation(), p)
    pose = dut.GetOutputPort("body_pose").Eval(context)
    again = RigidTransform(Quaternion(wxyz=pose[:4]), pose[4:])
    assert again.IsNearlyEqualTo(X_WM, 1e-14)


def test_at_rest_the_person_is_where_the_scene_puts_it(dut):
    pose = dut.GetOutputPort("body_pose").Eval(dut.CreateDefaultContext())
    half = SOUND["person_yaw"] / 2.0
    np.testing.assert_allclose(
        pose[:4], [np.cos(half), 0.0, 0.0, np.sin(half)], atol=1e-14
    )
    np.testing.assert_allclose(pose[4:], SOUND["person_position"], atol=1e-15)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"motion": MotionConfig(breath_amplitude=-1.0)}, "breath_amplitude"),
        ({"person_position": np.full(3, np.nan)}, "person_position must be 3 finite"),
        ({"person_yaw": float("inf")}, "person_yaw must be finite"),
        ({"hips": np.zeros(2)}, "hips must be 3 finite"),
        ({"breath_direction": np.zeros(3)}, "breath_direction must not be zero"),
    ],
)
def test_bad_parameters_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        PatientMotion(**(SOUND | arguments))
