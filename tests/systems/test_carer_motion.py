import numpy as np
import pytest
from pydrake.geometry import FrameId

from bath_drake.carer.arm import PARTS, CarerArm
from bath_drake.carer.skin_path import SkinPath
from bath_drake.systems.carer_motion import CarerMotion

FRAMES = {part: FrameId.get_new_id() for part in PARTS}
TIMES = np.linspace(0.0, 2.0, 21)
ARM = CarerArm(
    path=SkinPath(
        TIMES,
        np.stack([0.1 * TIMES, 0.0 * TIMES, 0.8 + 0.0 * TIMES], axis=1),
        np.tile([0.0, 1.0, 0.0], (21, 1)),
    ),
    marker_radius=0.02,
    middle_W=np.array([0.7, 0.0, 0.8]),
    aside_W=np.array([0.0, -1.0, 0.0]),
    outward_W=np.array([-1.0, 0.0, 0.0]),
    swing=0.3,
    swing_period=3.0,
)


@pytest.mark.parametrize("t", [0.0, 0.7, 5.0])
def test_the_frames_are_where_the_pure_arm_has_its_parts(t):
    dut = CarerMotion(frame_ids=FRAMES, arm=ARM)
    context = dut.CreateDefaultContext()
    context.SetTime(t)
    # A quarter turn about z, as the scene seats people.
    half = np.sqrt(0.5)
    pose = np.array([half, 0.0, 0.0, half, 0.75, 0.1, 0.0])
    dut.GetInputPort("body_pose").FixValue(context, pose)
    R_WM = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    found = dut.GetOutputPort("geometry_pose").Eval(context)
    for part, (R, p) in ARM.poses(t, (R_WM, pose[4:])).items():
        X = found.value(FRAMES[part])
        # The quaternion's rounding.
        np.testing.assert_allclose(X.rotation().matrix(), R, atol=1e-12)
        np.testing.assert_allclose(X.translation(), p, atol=1e-12)


def test_every_part_needs_a_frame():
    with pytest.raises(ValueError, match=r"missing: \['trunk'\]"):
        CarerMotion(frame_ids={p: FRAMES[p] for p in PARTS[:-1]}, arm=ARM)
