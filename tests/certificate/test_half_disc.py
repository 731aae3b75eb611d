"""Gates: what is said of boxes is so in exact arithmetic, and bounds hold."""

from fractions import Fraction

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from strategies import disjoint_worlds
from worlds import make

from bath_drake.certificate.crossing import (
    APART,
    CROSSED,
    NOT_SHOWN,
    _stretch,
    boundary_is_crossed,
    goal_is_alone,
)
from bath_drake.certificate.half_disc import (
    FREE,
    NOT_FREE,
    inside,
    least_beta,
    most_psi,
    outside,
)
from bath_drake.certificate.world import interval_world
from bath_drake.field.navigation import grad_psi, min_beta, psi

NUMBER = st.floats(-3.0, 3.0)
NONE = np.empty((0, 5))


@st.composite
def gates(draw):
    turn = draw(st.floats(-4.0, 4.0))
    centre = draw(st.tuples(NUMBER, NUMBER))
    return np.array([*centre, np.cos(turn), np.sin(turn), draw(st.floats(0.05, 1.5))])


def is_in(x: float, y: float, gate) -> bool:
    """Exactly."""
    cx, cy, ux, uy, r = map(Fraction, gate.tolist())
    dx, dy = Fraction(x) - cx, Fraction(y) - cy
    return dx * ux + dy * uy >= 0 and dx * dx + dy * dy <= r * r


def points_of(gate, count, rng):
    q = gate[:2] + gate[4] * rng.uniform(-1.0, 1.0, (count, 2))
    return q[[is_in(x, y, gate) for x, y in q]]


@given(gates(), NUMBER, NUMBER, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_boxes_said_to_be_in_or_out_are(gate, x, y, width, height):
    box = (x, x + width), (y, y + height)
    corners = [is_in(a, b, gate) for a in box[0] for b in box[1]]
    if outside(*box, gate):
        assert not any(corners)
        near = np.clip(gate[:2], [x, y], [x + width, y + height])
        assert not is_in(*near.tolist(), gate)
    if inside(*box, gate):
        assert all(corners)  # the half-disc is convex


@given(gates(), st.sampled_from([0, 1]), st.floats(-1.0, 0.9), st.floats(0.0, 1.0))
def test_a_stretch_lies_in_its_box(gate, piece, low, share):
    high = low + share * (1.0 - low)
    x, y = _stretch(piece, low, high, gate)
    s = np.linspace(low, high, 50)
    u, t = gate[2:4], np.array([-gate[3], gate[2]])
    turn = 0.5 * np.pi * s
    along, across = (np.cos(turn), np.sin(turn)) if piece == 0 else (0.0 * s, s)
    q = gate[:2] + gate[4] * (along[:, None] * u + across[:, None] * t)
    # What these points themselves are rounded by.
    slack = 1e-15
    assert (q[:, 0] >= x[0] - slack).all()
    assert (q[:, 0] <= x[1] + slack).all()
    assert (q[:, 1] >= y[0] - slack).all()
    assert (q[:, 1] <= y[1] + slack).all()


@given(gates(), disjoint_worlds(), st.integers(0, 2**32 - 1))
def test_bounds_over_a_gate_hold_at_its_points(gate, field, seed):
    world = interval_world(field, None)
    status, clearance, box, _ = least_beta(world, gate, 1e-9 * gate[4], 50_000)
    q = points_of(gate, 400, np.random.default_rng(seed))
    values = min_beta(q, field)
    if status == FREE:
        assert clearance > 0.0
        # The sampled values are right to a few roundings of numbers below 1e4.
        assert (values >= clearance - 1e-11).all()
        level, _ = most_psi(world, gate, 2000)
        assert (psi(q, field) <= level + 1e-9).all()
    if status == NOT_FREE:
        x, _, y, _ = box.tolist()
        assert is_in(x, y, gate)
        assert min_beta([x, y], field) <= 1e-11
    if len(q) and (values < -1e-9).any():
        assert status != FREE


@given(gates(), disjoint_worlds(most=3))
def test_a_boundary_that_is_crossed_is_tangent_in_points_only(gate, field):
    world = interval_world(field, None)
    found, _ = boundary_is_crossed(world, gate, NONE, 500)
    assert found in (CROSSED, NOT_SHOWN)
    if found == CROSSED:
        across = gate[:2] + np.linspace(-1, 1, 41)[:, None] * gate[4] * np.array(
            [-gate[3], gate[2]]
        )
        assert (min_beta(across, field) > 0.0).all()
        along = np.abs(grad_psi(across, field) @ gate[2:4])
        assert (along > 0.0).sum() > 20


def test_the_part_in_other_gates_is_looked_at_alone():
    # An obstacle on the far end of the straight side matters only for that end.
    world = interval_world(make(4.0, [0.0, 1.0, 0.3, 0.3, 0.0]), None)
    gate = np.array([0.0, 0.0, 1.0, 0.0, 1.0])
    here = np.array([[0.0, -0.8, 1.0, 0.0, 0.5]])
    far = np.array([[-4.0, 0.0, 1.0, 0.0, 0.5]])
    assert boundary_is_crossed(world, gate, NONE, 500)[0] == NOT_SHOWN
    assert boundary_is_crossed(world, gate, here, 500)[0] == CROSSED
    assert boundary_is_crossed(world, gate, far, 500)[0] == APART
    both = np.concatenate([here, far])
    assert boundary_is_crossed(world, gate, both, 500)[0] == APART


@pytest.mark.parametrize("share", [-0.05, 0.05])
def test_below_a_saddle_s_level_the_goal_is_alone(share):
    field = make(4.0, [0.0, 0.0, 1.0, 1.0, 0.0])
    # The saddle lies on the x-axis behind the disc, a minimum along it.
    x = np.linspace(-4.9, -1.001, 100_001)
    saddle = psi(np.stack([x, 0.0 * x], axis=1), field).min()
    world = interval_world(field, None)
    alone, _ = goal_is_alone(world, float(saddle) + share, 1e-4, 20_000)
    assert alone is (share < 0.0)
