"""The check of the canonical velocity, by its properties."""

from math import hypot, inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.field._boundaries import min_beta
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.safety.canonical_command import (
    check_canonical_command,
    guarded_world,
)
from bath_drake.safety.limits import GuardLimits
from bath_drake.safety.reasons import Reason

LIMITS = GuardLimits()
FIELD = NavigationField(
    workspace=Workspace(np.zeros(2), np.array([1.2, 1.1]), 4),
    goal=np.array([0.8, 0.0]),
    kappa=5.0,
    obstacles=ObstacleSet(np.array([[0.0, 0.0, 0.2, 0.2, 0.0]])),
)
AREA = ObstacleSet(np.array([[-0.5, 0.5, 0.1, 0.1, 0.0]]))
EXTENTS = (0.18, 0.24)
STEADY = np.array([0.2, 0.0])
DT = 0.01


def check(velocity=STEADY, point=(-0.8, 0.0), last=STEADY, **change):
    given = {
        "world": guarded_world(FIELD, AREA, LIMITS.canonical.margin),
        "half_extents": EXTENTS,
        "condition_number": 1.0,
        "dt": DT,
        "limits": LIMITS,
        **change,
    }
    return check_canonical_command(velocity, point, last, **given)


def test_a_command_within_all_limits_passes_bit_by_bit():
    checked = check()
    np.testing.assert_array_equal(checked.velocity, STEADY)
    assert checked.reason is Reason.NONE
    assert not checked.limited


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"velocity": (nan, 0.0)}, Reason.COMMAND_NOT_FINITE),
        ({"velocity": (0.0, inf)}, Reason.COMMAND_NOT_FINITE),
        ({"point": (nan, 0.0)}, Reason.COMMAND_NOT_FINITE),
        ({"half_extents": (0.0, 0.2)}, Reason.COMMAND_NOT_FINITE),
        ({"half_extents": (nan, 0.2)}, Reason.COMMAND_NOT_FINITE),
        ({"condition_number": nan}, Reason.COMMAND_NOT_FINITE),
        ({"velocity": (0.1, 0.0, 0.0)}, Reason.COMMAND_NOT_FINITE),
        ({"velocity": (1e300, 1e300)}, Reason.COMMAND_JUMP),
        ({"point": (0.1, 0.0)}, Reason.POINT_NOT_FREE),
        ({"point": (1.3, 0.0)}, Reason.POINT_NOT_FREE),
        ({"point": (1e300, 0.0)}, Reason.POINT_NOT_FREE),
        ({"point": (-0.5, 0.45)}, Reason.AREA_ENTERED),
        ({"velocity": (0.0, 0.0)}, Reason.TRAPPED),
        # 0.2 beyond the rim's margin is nearer than any of five halvings reaches.
        ({"point": (-0.2051, 0.0), "last": (0.5, 0.0)}, Reason.CLEARANCE),
    ],
)
def test_what_cannot_be_scaled_is_held_with_its_reason(change, reason):
    checked = check(**change)
    assert checked.reason is reason
    np.testing.assert_array_equal(checked.velocity, np.zeros(2))


def test_at_the_goal_no_motion_is_no_trap():
    assert check(velocity=(0.0, 0.0), point=FIELD.goal).reason is Reason.NONE


def test_too_fast_along_the_skin_is_scaled_to_the_limit():
    checked = check(velocity=(0.7, 0.0), last=(0.6, 0.0))
    assert checked.limited
    # 0.10 m/s over 0.18 m; to the rounding of three products.
    assert checked.velocity[0] == pytest.approx(0.10 / 0.18, rel=1e-12)


def test_speeding_up_is_scaled_to_the_acceleration():
    checked = check(last=(0.0, 0.0))
    assert checked.limited
    # To the rounding of a root.
    assert hypot(*checked.velocity) == pytest.approx(
        DT * LIMITS.canonical.acceleration, rel=1e-12
    )


def test_slowing_down_is_always_allowed():
    np.testing.assert_array_equal(
        check(velocity=(0.01, 0.0), last=(0.5, 0.0)).velocity, (0.01, 0.0)
    )


def test_a_turn_too_sharp_for_its_speed_stops_first():
    checked = check(velocity=(0.0, 0.3), last=(0.3, 0.0))
    np.testing.assert_array_equal(checked.velocity, np.zeros(2))
    assert checked.reason is Reason.NONE
    assert checked.limited
    assert check(velocity=(0.0, 0.3), last=checked.velocity).velocity[1] > 0.0


@pytest.mark.parametrize(("number", "share"), [(17.0, 1.0), (23.5, 0.5), (30.0, 0.0)])
def test_near_a_singularity_it_slows(number, share):
    checked = check(condition_number=number)
    np.testing.assert_allclose(checked.velocity, share * STEADY, rtol=1e-12)


def test_towards_an_obstacle_it_slows_before_it_holds():
    # Half of the way to brake from 0.4 1/s, 0.008 N, off the margin.
    near = (-0.2 - LIMITS.canonical.margin - 0.006, 0.0)
    checked = check(velocity=(0.4, 0.0), last=(0.4, 0.0), point=near)
    assert checked.reason is Reason.NONE
    assert 0.0 < checked.velocity[0] < 0.4


def test_within_the_margin_it_may_only_go_out():
    within = (-0.2 - 0.5 * LIMITS.canonical.margin, 0.0)
    assert check(velocity=(-0.2, 0.0), last=(-0.2, 0.0), point=within).velocity[0] < 0.0
    assert check(velocity=(0.2, 0.0), point=within).reason is Reason.CLEARANCE


def test_the_rim_has_its_margin_too():
    # The rim is at x = 1.2; the step and the brake from 0.5 1/s take 0.0175.
    near = (1.2 - LIMITS.canonical.margin - 3e-3, 0.0)
    checked = check(velocity=(0.5, 0.0), last=(0.5, 0.0), point=near)
    assert checked.reason is Reason.NONE
    assert 0.0 < checked.velocity[0] < 0.5
    within = (1.2 - 0.5 * LIMITS.canonical.margin, 0.0)
    assert check(velocity=(0.2, 0.0), point=within).reason is Reason.CLEARANCE


def test_within_the_margin_a_sharp_turn_stops_first_as_anywhere():
    within = (-0.2 - 0.5 * LIMITS.canonical.margin, 0.0)
    checked = check(velocity=(-0.3, 0.0), last=(0.0, 0.3), point=within)
    assert checked.reason is Reason.NONE
    np.testing.assert_array_equal(checked.velocity, np.zeros(2))


def test_a_step_over_a_thin_obstacle_is_not_free():
    thin = ObstacleSet(np.array([[0.0, 0.0, 0.001, 0.5, 0.0]]))
    field = NavigationField(FIELD.workspace, FIELD.goal, 5.0, thin)
    world = guarded_world(field, ObstacleSet(), 0.0)
    checked = check(
        velocity=(0.5, 0.0), last=(0.5, 0.0), point=(-0.002, 0.0), world=world
    )
    assert checked.velocity[0] < 0.2


ellipses = st.tuples(
    st.floats(-0.5, 0.5),
    st.floats(-0.5, 0.5),
    st.floats(0.02, 0.6),
    st.floats(0.02, 0.6),
    st.floats(-3.0, 3.0),
)


@given(
    ellipse=ellipses,
    margin=st.floats(1e-4, 0.1),
    point=st.tuples(st.floats(-1.2, 1.2), st.floats(-1.1, 1.1)),
)
def test_what_is_free_with_the_margin_is_that_far_from_every_boundary(
    ellipse, margin, point
):
    field = NavigationField(
        FIELD.workspace, FIELD.goal, 5.0, ObstacleSet(np.array([ellipse]))
    )
    world = guarded_world(field, ObstacleSet(), margin)
    if min_beta(*point, world.inner_workspace, world.wide_forms) <= 0.0:
        return
    # Sampled points lie farther than the boundary itself, never nearer.
    boundary = field.obstacles.boundary(720)[0]
    t = np.linspace(0.0, 2.0 * np.pi, 720)
    rim = np.stack([np.cos(t), np.sin(t)], axis=-1)
    rim /= ((rim**4).sum(axis=-1) ** 0.25)[:, None]
    rim *= field.workspace.semi_axes
    for points in (boundary, rim):
        assert np.linalg.norm(points - point, axis=-1).min() >= margin


def test_a_margin_that_leaves_nothing_is_refused():
    with pytest.raises(ValueError, match="margin must be less than"):
        guarded_world(FIELD, AREA, 1.1)
