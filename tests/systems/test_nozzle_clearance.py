from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.height_field import CELL
from bath_drake.perception.recalled_skin import RecalledSkin
from bath_drake.perception.skin_distance import STEP, skin_distance
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


def clearance(p_WE, patch, **skin):
    dut = NozzleClearance()
    context = dut.CreateDefaultContext()
    dut.GetInputPort("surface_patch").FixValue(context, patch)
    dut.GetInputPort("nozzle_pose").FixValue(context, RigidTransform(p_WE))
    for name, value in skin.items():
        dut.GetInputPort(name).FixValue(context, Value(value))
    (found,) = dut.GetOutputPort("nozzle_clearance").Eval(context)
    return found


@pytest.mark.parametrize("height", [0.06, 0.0, -0.05])
def test_it_is_the_height_along_the_normal(height):
    # Rounding of three numbers near one.
    p_WE = [0.5 - height, 0.01, 1.02]
    assert clearance(p_WE, make_patch()) == pytest.approx(height, abs=1e-12)


@pytest.mark.parametrize("valid", [True, False])
def test_it_is_that_of_the_patch_where_that_lies_under_the_nozzle(valid):
    patch = make_patch(valid)
    found = clearance([0.46, 0.02, 1.0], patch)
    assert found == height_over(patch, np.array([0.46, 0.02, 1.0]))


def test_a_patch_says_nothing_about_a_nozzle_far_beside_it():
    # In front of the shoulder while the patch is at the flank: no height at all
    # along the flank's normal, and yet far from any skin.
    assert clearance([0.5, -0.2, 1.0], make_patch()) == np.inf


def frame(points_W):
    areas = np.full(len(points_W), 1e-5)
    return replace(BodyObservation(), points_W=points_W, point_areas=areas)


@pytest.mark.parametrize("patch", [make_patch(), make_patch(valid=False)])
def test_skin_beside_the_patch_is_watched_all_the_same(patch):
    p_WE = np.array([0.47, -0.2, 1.0])
    y, z = np.mgrid[-0.25:0.25:0.003, 0.8:1.2:0.003]
    points_W = np.column_stack([np.full(y.size, 0.5), y.ravel(), z.ravel()])
    found = clearance(p_WE, patch, body_observation=frame(points_W))
    assert found == skin_distance(points_W, frame(points_W).point_areas, p_WE)
    # 2 cm^2 of it are within 8 mm of the foot: 31 mm at a height of 30, less a step.
    assert 0.03 - STEP <= found < 0.032


def test_and_so_is_skin_that_the_robot_hides():
    p_WE = np.array([0.47, -0.2, 1.0])
    y, z = np.mgrid[-0.25:-0.15:CELL, 0.95:1.05:CELL]
    points_W = np.column_stack([np.full(y.size, 0.5), y.ravel(), z.ravel()])
    seen = frame(points_W - [0.0, 0.0, 0.3])
    assert clearance(p_WE, make_patch(), body_observation=seen) == np.inf
    hidden = {"body_observation": seen, "recalled_skin": RecalledSkin(points_W)}
    # Of a centimetre's cells two are enough, the second within 14 mm of the foot.
    assert 0.03 - STEP <= clearance(p_WE, make_patch(), **hidden) < 0.034
