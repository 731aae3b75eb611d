import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.safety.hold import MAX_FRAME_AGE, HoldReason, hold_reason

WELL = {
    "stamp": 1.0,
    "now": 1.03,
    "body_found": True,
    "body_lost": False,
    "map_believed": True,
    "surface_found": True,
    "joint_solution": True,
    "world_sound": True,
}


def test_nothing_holds_a_robot_that_sees_well():
    assert hold_reason(**WELL) is HoldReason.NONE


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"stamp": -math.inf}, HoldReason.NO_FRAME),
        ({"stamp": math.nan}, HoldReason.NO_FRAME),
        ({"now": 1.0 + MAX_FRAME_AGE + 1e-3}, HoldReason.STALE_FRAME),
        ({"now": 0.9}, HoldReason.STALE_FRAME),
        ({"body_found": False}, HoldReason.BODY_HIDDEN),
        ({"body_found": False, "body_lost": True}, HoldReason.BODY_LOST),
        ({"map_believed": False}, HoldReason.BODY_JUMPED),
        ({"surface_found": False}, HoldReason.SURFACE_UNSEEN),
        ({"joint_solution": False}, HoldReason.NO_JOINT_SOLUTION),
        ({"world_sound": False}, HoldReason.UNSOUND_WORLD),
    ],
)
def test_each_lack_holds_for_its_own_reason(change, reason):
    assert hold_reason(**{**WELL, **change}) is reason


@given(
    stamp=st.floats(allow_nan=True, allow_infinity=True),
    now=st.floats(0.0, 1e6),
    body=st.booleans(),
    lost=st.booleans(),
    believed=st.booleans(),
    surface=st.booleans(),
    joints=st.booleans(),
    world=st.booleans(),
)
def test_it_moves_only_if_all_is_well_and_fresh(
    stamp, now, body, lost, believed, surface, joints, world
):
    reason = hold_reason(
        stamp=stamp,
        now=now,
        body_found=body,
        body_lost=lost,
        map_believed=believed,
        surface_found=surface,
        joint_solution=joints,
        world_sound=world,
    )
    if reason is HoldReason.NONE:
        assert body
        assert surface
        assert joints
        assert world
        # 1e-9 s: the rounding the decision itself allows.
        assert -1e-9 <= now - stamp <= MAX_FRAME_AGE + 1e-9
