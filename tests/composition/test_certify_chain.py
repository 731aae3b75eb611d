"""The proof of a chain: what it says holds, and what it must not say it does not."""

from dataclasses import replace

import hypothesis.strategies as st
import numpy as np
import pytest
from chains import gate_at, make, random_chain
from hypothesis import given, settings

from bath_drake.certificate.certify import certify, certify_from
from bath_drake.certificate.half_disc import least_beta, most_psi
from bath_drake.certificate.world import interval_world
from bath_drake.composition.certify import certify_chain
from bath_drake.composition.chain import Chain, Gate
from bath_drake.composition.rollout import chain_rollout
from bath_drake.composition.similarity import Similarity
from bath_drake.field.navigation import min_beta, psi
from bath_drake.field.rollout import RolloutStatus, rollout
from bath_drake.notation import FloatArray

SEEDS = st.integers(0, 2**32 - 1)
# At this kappa a broadside ellipse traps what comes from behind it.
BROADSIDE = make((1.5, 0.0), [0.0, 0.0, 0.25, 1.0, 0.0], kappa=2.0)
FORWARD = np.array([1.0, 0.0])


def timeless(certificate):
    return replace(certificate, seconds=0.0)


def strewn(field, count: int, rng: np.random.Generator) -> FloatArray:
    q = rng.uniform(-2.5, 2.5, (count, 2))
    return q[min_beta(q, field) > 1e-3]


def points_of(gate: Gate, count: int, rng: np.random.Generator) -> FloatArray:
    """Of the gate, half of them on its boundary."""
    q = gate.centre + gate.radius * rng.uniform(-1.0, 1.0, (count, 2))
    edge = gate.outline(count)
    inner = gate.centre + gate.direction * (1e-12 * gate.radius)
    edge = inner + (1.0 - 1e-11) * (edge - inner)
    return np.concatenate([q[gate.holds(q)], edge[gate.holds(edge)]])


def assert_all_arrive(starts: FloatArray, chain: Chain) -> None:
    for start in starts:
        found = chain_rollout(start, chain, step=0.02, max_steps=20_000)
        assert found.status is RolloutStatus.ARRIVED, (start, found.path[-1])
        assert found.min_beta > 0.0


@settings(max_examples=20)
@given(SEEDS)
def test_of_a_proved_chain_roll_outs_from_anywhere_arrive(seed):
    rng = np.random.default_rng(seed)
    chain = random_chain(rng, int(rng.integers(1, 5)), kappa=float(rng.uniform(3, 9)))
    found = certify_chain(chain)
    if found.passed:
        assert found.witness is None
        assert found.doubts == ()
        assert_all_arrive(strewn(chain.fields[0], 30, rng), chain)


@settings(max_examples=20)
@given(SEEDS)
def test_a_gate_s_bounds_hold_all_over_it_and_are_not_far_off(seed):
    rng = np.random.default_rng(seed)
    chain = random_chain(rng, 2)
    field, gate = chain.fields[1], chain.gates[0]
    (handover,) = certify_chain(chain).handovers
    q = points_of(gate, 3000, rng)
    assert handover.verdict == "proved"
    assert handover.clearance is not None
    assert handover.level is not None
    least, most = min_beta(q, field).min(), psi(q, field).max()
    assert handover.clearance <= least
    # A tenth for the proof, the rest for the sampling.
    assert handover.clearance >= 0.8 * least
    assert handover.level >= most
    slack = 0.02 * (field.kappa + 1 + field.obstacles.powers.sum())
    assert handover.level <= most + 2.0 * slack


@settings(max_examples=20)
@given(SEEDS)
def test_where_every_motion_is_said_to_arrive_it_does(seed):
    rng = np.random.default_rng(seed)
    chain = random_chain(rng, 2)
    found = certify_chain(chain)
    if found.passed and found.handovers[0].arrival == "every":
        level = found.handovers[0].level
        for p in found.stages[1].critical_points:
            assert psi([p.x, p.y], chain.fields[1]) > level
        for q in points_of(chain.gates[0], 60, rng):
            end = rollout(q, chain.fields[1], step=0.02, max_steps=20_000)
            assert end.status is RolloutStatus.ARRIVED


@settings(max_examples=10)
@given(SEEDS, st.floats(-3.0, 3.0), st.floats(0.3, 3.0))
def test_the_verdict_moves_along_with_the_chain(seed, turn, scale):
    rng = np.random.default_rng(seed)
    chain = random_chain(rng)
    by = Similarity(rng.normal(size=2), scale * np.exp(1j * turn), rng.normal(size=2))
    here, there = certify_chain(chain), certify_chain(chain.moved((by,) * 3))
    assert there.verdict == here.verdict
    for a, b in zip(here.handovers, there.handovers, strict=True):
        # Other boxes: bounds are as sharp, not the same.
        assert b.clearance == pytest.approx(a.clearance, rel=0.2)


@settings(max_examples=10)
@given(SEEDS)
def test_a_chain_of_one_is_certified_as_its_field(seed):
    rng = np.random.default_rng(seed)
    chain = random_chain(rng, 1, kappa=3.0)
    field = chain.fields[0]
    found, alone = certify_chain(chain), certify(field)
    assert timeless(found.stages[0]) == timeless(alone)
    assert found.verdict == alone.verdict
    assert found.reason == alone.reason
    for start in rng.uniform(-2.5, 2.5, (3, 2)):
        found, alone = certify_chain(chain, start=start), certify_from(field, start)
        assert timeless(found.stages[0]) == timeless(alone)
        assert found.witness == alone.witness


def blocked(gap: float) -> Chain:
    """The next field's disc is so far from the gate's half circle, or in it if < 0."""
    gate = Gate(np.array([-0.05, 0.0]), FORWARD, 0.2)
    disc = [0.15 + gap + 0.3, 0.0, 0.3, 0.3, 0.0]
    return Chain((make((0.0, 0.0)), make((1.5, 0.3), disc)), (gate,))


@pytest.mark.parametrize("gap", [0.1, 1e-3, 1e-7])
def test_a_gate_beside_an_obstacle_of_the_next_field_is_proved(gap):
    (handover,) = certify_chain(blocked(gap)).handovers
    assert handover.verdict == "proved"
    assert handover.clearance is not None
    assert 0.0 < handover.clearance < (1.0 + gap / 0.3) ** 2 - 1.0


@pytest.mark.parametrize("gap", [-1e-7, -1e-3, -0.1, -0.3])
def test_a_gate_that_reaches_into_an_obstacle_of_the_next_field_is_refuted(gap):
    chain = blocked(gap)
    found = certify_chain(chain)
    assert found.verdict == found.handovers[0].verdict == "refuted"
    assert found.stages[0].passed
    assert found.witness is not None
    assert chain.gates[0].holds(found.witness)
    assert min_beta(found.witness, chain.fields[1]) <= 0.0
    assert "gate 0: its point" in found.reason
    assert "in obstacle 0 of stage 1" in found.reason


def test_a_gate_that_touches_an_obstacle_of_the_next_field_is_undecided():
    found = certify_chain(blocked(0.0))
    assert found.verdict == "undecided"
    (doubt,) = found.handovers[0].doubts
    assert doubt.cause == "tangency"
    assert doubt.box.centre == pytest.approx((0.15, 0.0), abs=1e-6)
    assert "it touches a boundary of stage 1" in found.reason


def test_a_small_obstacle_within_a_gate_is_found():
    gate = Gate(np.array([-0.05, 0.0]), FORWARD, 0.2)
    pin = [0.0487, 0.0712, 1e-5, 1e-5, 0.3]
    found = certify_chain(Chain((make((0.0, 0.0)), make((1.5, 0.0), pin)), (gate,)))
    assert found.verdict == "refuted"
    # Behind the straight side it is in no one's way.
    pin[0] = -0.06
    found = certify_chain(Chain((make((0.0, 0.0)), make((1.5, 0.0), pin)), (gate,)))
    assert found.handovers[0].verdict == "proved"


def test_a_gate_beyond_the_next_field_s_rim_is_refuted():
    fields = (make((2.3, 0.0)), make((0.0, 0.0)))
    gate = Gate(np.array([2.25, 0.0]), FORWARD, 0.3)
    found = certify_chain(Chain(fields, (gate,)))
    assert found.verdict == "refuted"
    assert "beyond the rim of stage 1" in found.reason


@pytest.mark.parametrize(
    ("goal", "inside"),
    [
        ((0.0, 0.0), False),  # on the straight side
        ((0.0, 0.1), False),  # a corner
        ((0.1, 0.0), False),  # on the half circle
        ((1e-9, 0.0), True),
        ((0.1 - 1e-9, 0.0), True),
    ],
)
def test_a_goal_on_its_gate_s_boundary_is_not_proved(goal, inside):
    gate = Gate(np.zeros(2), FORWARD, 0.1)
    fields = (make(goal), make((1.0, 0.2)))
    found = certify_chain(Chain(fields, (gate,)))
    assert found.passed is inside
    if not inside:
        assert found.verdict == "undecided"
        assert "lies on the gate's boundary" in found.reason
        assert found.handovers[0].doubts[0].cause == "tangency"


def axis_chain(turn: float, offset: float = 0.0) -> Chain:
    """The next field's saddle lies behind its disc on the x-axis, its curve along it.

    The gate, before the saddle, has its straight side at this angle with the axis.
    """
    fields = (make((-1.2, 0.05 + offset)), make((1.5, 0.0), [0, 0, 0.3, 0.3, 0]))
    normal = np.array([-np.sin(turn), np.cos(turn)])
    return Chain(fields, (Gate(np.array([-1.2, offset]), normal, 0.15),))


def test_a_stable_curve_along_a_gate_s_straight_side_is_not_proved():
    chain = axis_chain(0.0)
    # It is so: what passes the straight side ends at the saddle.
    for x in np.linspace(-1.3, -1.1, 5):
        end = rollout([x, 0.0], chain.fields[1])
        assert end.status is not RolloutStatus.ARRIVED
    found = certify_chain(chain)
    assert found.verdict == "undecided"
    assert found.stages[0].passed
    assert found.stages[1].passed
    assert found.handovers[0].arrival == "not shown"
    assert "may run along the gate's boundary" in found.reason


@pytest.mark.parametrize(("turn", "offset"), [(1e-3, 0.0), (-0.5, 0.0), (0.0, 1e-3)])
def test_a_gate_turned_or_moved_a_little_is_crossed(turn, offset):
    (handover,) = certify_chain(axis_chain(turn, offset)).handovers
    assert handover.verdict == "proved"
    assert handover.arrival == "almost every"


def test_a_curve_to_a_later_field_s_saddle_along_a_gate_is_not_proved():
    # The second field has no saddle, but leads all that passes the straight side of
    # gate 0 along the x-axis onto the stable curve of the third.
    last = make((1.5, 0.0), [0.0, 0.0, 0.3, 0.3, 0.0])
    fields = (make((-1.4, 0.05)), make((-0.9, 0.0)), last)
    gates = (
        Gate(np.array([-1.4, 0.0]), np.array([0.0, 1.0]), 0.15),
        Gate(np.array([-0.95, 0.0]), FORWARD, 0.1),
    )
    chain = Chain(fields, gates)
    # Motions that enter the straight side off its corners, from below.
    for start in ([-1.4, -0.5], [-1.35, -0.4]):
        assert chain_rollout(start, chain, step=1e-3).stages[-1] == 2
    found = certify_chain(chain)
    assert found.verdict == "undecided"
    assert found.handovers[0].arrival == "not shown"
    assert found.handovers[1].arrival == "almost every"
    turned = Gate(gates[0].centre, np.array([0.01, 1.0]), 0.15)
    again = certify_chain(Chain(fields, (turned, gates[1])))
    assert again.passed
    assert again.handovers[0].arrival == "every"


def test_gates_that_overlap_are_looked_at_together():
    # The straight side of gate 0 lies along the stable curve of the last field, and
    # within gate 1: what passes it goes straight to that field's saddle.
    last = make((1.5, 0.0), [0.0, 0.0, 0.3, 0.3, 0.0])
    fields = (make((-1.2, 0.05)), make((-1.1, 0.1)), last)
    gates = (
        Gate(np.array([-1.2, 0.0]), np.array([0.0, 1.0]), 0.15),
        Gate(np.array([-1.2, -0.1]), np.array([0.0, 1.0]), 0.4),
    )
    found = certify_chain(Chain(fields, gates))
    assert found.handovers[1].verdict == "proved"
    assert found.handovers[0].verdict == "undecided"
    assert "a curve of stage 2" in found.reason
    # Apart from each other they are no matter.
    away = (gates[0], Gate(np.array([-1.1, 0.09]), np.array([0.0, 1.0]), 0.05))
    assert certify_chain(Chain(fields, away)).passed


def past_the_trap() -> Chain:
    """The second field has a trap behind its ellipse, the gate lies before it."""
    fields = (make((0.8, 0.0)), BROADSIDE)
    return Chain(fields, (gate_at(fields[0].goal, 0.0),))


def test_a_later_field_may_be_proved_of_what_its_gate_can_reach():
    chain = past_the_trap()
    whole = certify_chain(chain)
    assert whole.verdict == "refuted"
    assert whole.handovers[0].verdict == "proved"
    assert whole.handovers[0].arrival == "not shown"
    found = certify_chain(chain, start=[-1.5, 0.3])
    assert found.passed, found.reason
    assert found.stages[1].region == found.handovers[0].level
    assert found.stages[0].region is None
    assert_all_arrive(strewn(chain.fields[0], 30, np.random.default_rng(3)), chain)


def test_a_first_field_may_be_proved_of_what_the_start_can_reach():
    fields = (BROADSIDE, make((0.0, 1.5)))
    chain = Chain(fields, (gate_at(BROADSIDE.goal, 0.0),))
    found = certify_chain(chain, start=[0.8, 0.3])
    assert found.passed
    assert found.region is not None
    assert "region" in found.reason
    behind = certify_chain(chain, start=[-1.2, 0.0])
    assert behind.verdict == "refuted"
    assert behind.reason.startswith("stage 0: a minimum besides the goal")
    assert certify_chain(chain, start=[0.0, 0.0]).witness == (0.0, 0.0)


def test_a_gate_behind_a_trap_is_refuted():
    fields = (make((-1.4, 0.0)), BROADSIDE)
    chain = Chain(fields, (gate_at(fields[0].goal, 0.0),))
    found = certify_chain(chain, start=[-1.5, 0.8])
    assert found.verdict == "refuted"
    assert found.witness == pytest.approx((-1.0707, 0.0), abs=1e-4)
    assert chain_rollout([-1.5, 0.8], chain).status is not RolloutStatus.ARRIVED


def test_what_is_simulated_only_is_said(rng):
    found = certify_chain(random_chain(rng))
    assert [text.split(":")[0] for text in found.simulated] == [
        "steps",
        "the robot",
        "the world",
    ]
    assert found.seconds > 0.0
    assert found.boxes == sum(s.boxes for s in found.stages) + sum(
        h.boxes for h in found.handovers
    )


def test_a_small_budget_gives_no_proof_and_no_wrong_word():
    rng = np.random.default_rng(4)
    for _ in range(10):
        found = certify_chain(random_chain(rng), budget=3)
        assert found.verdict != "proved"
    with pytest.raises(ValueError, match="budget must be at least 1, got 0"):
        certify_chain(random_chain(rng), budget=0)


def test_bounds_are_of_the_half_disc_and_not_of_its_disc():
    # Behind the straight side beta falls and psi rises; neither is asked for.
    field = make((1.0, 0.0), [-0.3, 0.0, 0.25, 0.25, 0.0])
    gate = Gate(np.zeros(2), FORWARD, 0.2)
    world = interval_world(field, None)
    _, clearance, _, _ = least_beta(world, gate.as_array(), 1e-9, 10_000)
    assert clearance > 0.9 * ((0.3 / 0.25) ** 2 - 1.0)
    level, _ = most_psi(world, gate.as_array(), 10_000)
    rng = np.random.default_rng(1)
    most = psi(points_of(gate, 4000, rng), field).max()
    assert most <= level <= most + 0.3
