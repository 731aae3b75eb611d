import numpy as np
import pytest
from pydrake.math import RigidTransform

from bath_drake.perception.surface import SurfacePatch, height_over
from bath_drake.systems.nozzle_clearance import NozzleClearance


def make_patch(valid=True):
    return SurfacePatch(
        p_WS=np.array([0.5, 0.0, 1.0]),
        normal_W=np.array([-1.0, 0.0, 0.0]),
        curvatures=np.zeros(2),
        count=100,
        rms=0.0,
        radius=0.03,
        valid=valid,
    )


def clearance(p_WE, patch):
    dut = NozzleClearance()
    context = dut.CreateDefaultContext()
    dut.GetInputPort("surface_patch").FixValue(context, patch)
    dut.GetInputPort("nozzle_pose").FixValue(context, RigidTransform(p_WE))
    (found,) = dut.GetOutputPort("nozzle_clearance").Eval(context)
    assert found == height_over(patch, np.array(p_WE))
    return found


@pytest.mark.parametrize("height", [0.06, 0.0, -0.05])
def test_it_is_the_height_along_the_normal(height):
    # Rounding of three numbers near one.
    p_WE = [0.5 - height, 0.01, 1.02]
    assert clearance(p_WE, make_patch()) == pytest.approx(height, abs=1e-12)


def test_skin_that_was_not_seen_says_nothing():
    assert clearance([0.5, 0.0, 1.0], make_patch(valid=False)) == np.inf


def test_a_patch_says_nothing_about_a_nozzle_far_beside_it():
    # In front of the shoulder while the patch is at the flank: no height at all
    # along the flank's normal, and yet far from any skin.
    assert clearance([0.5, -0.2, 1.0], make_patch()) == np.inf
