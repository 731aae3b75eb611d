"""Chains learned stage by stage, and how they are judged."""

from dataclasses import replace

import numpy as np
import pytest

from bath_drake.composition.branch import Branch
from bath_drake.composition.certify import certify_chain
from bath_drake.composition.chain import Chain
from bath_drake.composition.rollout import chain_rollout
from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.rollout import RolloutStatus
from bath_drake.learning.alignment import align
from bath_drake.learning.chain.composer import compose, plan, plans
from bath_drake.learning.chain.stage import LearnedStage, learn_stage, stage_problem
from bath_drake.learning.checkpoint import Checkpoint
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.cost import ValidityMargins
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.judge import judge
from bath_drake.learning.learner import learn_skill

DISC = Workspace(np.zeros(2), np.array([2.0, 2.0]))


@pytest.fixture(scope="module")
def loop():
    """Three demonstrations of a loop, aligned."""
    t = np.linspace(0.0, 1.0, 160)
    bump = 0.5 * np.sin(np.pi * t)
    x = 1.4 * t - 0.7 + bump * np.sin(4 * np.pi * t)
    curve = np.stack([x, -bump * np.cos(4 * np.pi * t)], axis=-1)
    offsets = np.array([[0.0, 0.04], [0.04, -0.03], [-0.04, -0.01]])
    return np.array([curve + (1.0 - t)[:, None] * offset for offset in offsets])


@pytest.fixture(scope="module")
def learned(loop):
    aligned = align(loop)
    way = plans(aligned)[0]
    branch, _ = compose(aligned, way, DISC, ValidityMargins(), (0,), 2, Checkpoint())
    return aligned, way, branch


def test_a_stroke_that_crosses_itself_is_proved_and_followed(loop, learned):
    _, way, branch = learned
    assert len(branch.chain) == len(way.stages) >= 4
    assert certify_chain(branch.chain).passed
    judged = judge(branch, loop, 1.4)
    assert judged.valid
    # A single field cannot come within a third of this stroke's size.
    assert judged.to_mean < 0.03
    assert judged.cost < 0.06


def test_from_every_demonstrated_start_the_moved_chain_is_proved(loop, learned):
    _, _, branch = learned
    for stroke in loop:
        chain = branch.chain_for(stroke[0])
        assert certify_chain(chain).passed
        found = chain_rollout(stroke[0], chain, goal_tolerance=2e-3)
        assert found.status is RolloutStatus.ARRIVED
        assert found.min_beta > 0.0


def test_following_the_start_brings_the_motion_nearer(loop, learned):
    _, _, branch = learned
    still = replace(branch, conditioning=None)
    assert judge(branch, loop, 1.4).cost < judge(still, loop, 1.4).cost


def test_a_chain_is_charged_for_its_fields_and_obstacles(loop, learned):
    _, _, branch = learned
    judged = judge(branch, loop, 1.4)
    distances = judged.to_mean + judged.cost
    stages, obstacles = len(branch.chain), branch.chain.obstacle_count
    # The prices as documented: 0.0005 an obstacle, 0.001 a field more.
    expected = distances + 0.0005 * obstacles + 0.001 * (stages - 1)
    expected += 0.1 * judged.strays
    assert judged.price == pytest.approx(expected, rel=1e-12)


def test_a_motion_that_goes_round_the_other_way_from_nearby_strays(loop):
    # A wide disc on a straight way: from a little beside it, left or right decides.
    t = np.linspace(0.0, 1.0, 160)
    mean = np.stack([1.4 * t - 0.7, 0.45 * np.sin(np.pi * t)], axis=-1)
    disc = ObstacleSet(np.array([[0.0, 0.0, 0.35, 0.35, 0.0]]))
    field = NavigationField(DISC, mean[-1], 4.0, disc)
    starts = mean[0] + np.array([[0.0, 0.0], [0.0, 0.06]])
    branch = Branch(Chain((field,)), starts.mean(axis=0), starts, mean)
    judged = judge(branch, mean[None] + [0.0, 0.03], 1.4)
    assert 0.0 < judged.strays < 1.0
    clear = replace(branch, chain=Chain((replace(field, obstacles=ObstacleSet()),)))
    assert judge(clear, mean[None], 1.4).strays == 1.0  # straight on: never the bow


def test_one_unproved_field_makes_a_branch_invalid(loop, learned):
    _, _, branch = learned
    first, *rest = branch.chain.fields
    x, y = first.goal
    away = first.workspace.centre - first.goal
    # Broadside behind the goal: what starts behind the wall is trapped.
    wall = ObstacleSet(
        np.array([[x, y, 0.02, 0.5, np.arctan2(*away[::-1])]])
        - np.array([[*(0.6 * away / np.hypot(*away)), 0.0, 0.0, 0.0]])
    )
    bad = replace(first.with_obstacles(wall), kappa=20.0)
    broken = replace(branch, chain=replace(branch.chain, fields=(bad, *rest)))
    assert not judge(broken, loop, 1.4).valid


def test_a_plan_covers_the_stroke_and_its_entries_are_the_gates(loop):
    aligned = align(loop)
    found = plan(aligned, 5)
    assert len(found.stages) == len(found.gates) + 1 == len(found.cuts) - 1
    assert found.stages[0].entry.size == 0
    for gate, stage in zip(found.gates, found.stages[1:], strict=True):
        np.testing.assert_array_equal(stage.curve[0], gate.centre)
        # For the mean start, the first of all, the gate's own edge.
        assert np.linalg.norm(stage.entry[0] - gate.outline(7)[0]) < 1e-9
    np.testing.assert_array_equal(found.stages[-1].curve[-1], aligned.mean[-1])


def test_a_stage_leaves_its_entry_free(loop):
    aligned = align(loop)
    stage = plan(aligned, 6).stages[2]
    problem = stage_problem(stage, DISC, ValidityMargins())
    found = learn_stage(problem, 2, np.random.default_rng(0), 2)
    assert found.proved
    assert min_beta(stage.entry, found.field).min() > 0.0


def test_a_stage_comes_back_from_a_checkpoint_bit_by_bit(loop):
    stage = plan(align(loop), 6).stages[1]
    problem = stage_problem(stage, DISC, ValidityMargins())
    found = learn_stage(problem, 1, np.random.default_rng(3), 2)
    again = LearnedStage.unpack(found.pack(), problem)
    assert again.field == found.field
    assert (again.error, again.proved) == (found.error, found.proved)


def test_an_obstacle_bends_what_a_goal_alone_cannot(loop):
    stage = plan(align(loop), 6).stages[3]
    problem = stage_problem(stage, DISC, ValidityMargins())
    none = learn_stage(problem, 0, np.random.default_rng(0), 2)
    one = learn_stage(problem, 1, np.random.default_rng(0), 2)
    # This stage bends by more than a radian: the flow to a goal alone is straight.
    assert one.error < 0.5 * none.error


class Plain:
    sha256 = ""

    def __init__(self, name, points):
        self.name, self.points = name, points


def test_two_ways_become_two_branches_with_one_goal():
    t = np.linspace(0.0, 1.0, 100)
    strokes = [
        Plain(
            f"take {i}",
            np.stack([1.4 * t - 0.7, b * np.sin(np.pi * t) + 0.2 * b * (1 - t)], -1),
        )
        for i, b in enumerate((0.5, 0.52, -0.5, -0.48, 0.51))
    ]
    config = replace(LearnerConfig.quick(), fields="many")
    result = learn_skill(strokes, config)
    assert result.converged
    assert [len(b.starts) for b in result.branches] == [3, 2]
    np.testing.assert_array_equal(*(b.chain.goal for b in result.branches))
    middle = [b.mean[50, 1] for b in result.branches]
    assert middle[0] > 0.3
    assert middle[1] < -0.3


def test_a_stray_demonstration_is_named_and_hardly_matters():
    t = np.linspace(0.0, 1.0, 100)
    good = [
        Plain(f"take {i}", np.stack([1.4 * t - 0.7, b * np.sin(np.pi * t)], -1))
        for i, b in enumerate((0.4, 0.42, 0.44))
    ]
    stray = Plain("stray", np.stack([1.4 * t - 0.7, -0.7 * np.sin(np.pi * t)], -1))
    config = replace(LearnerConfig.quick(), fields="many")
    found = learn_skill([*good, stray], config)
    assert [o.name for o in found.outliers] == ["stray"]
    assert np.isnan(found.per_demonstration[3])
    without = learn_skill(good, config)
    # The common goal and the scale are computed with it: rounding, no more.
    assert discrete_frechet(found.rollout.path, without.rollout.path) < 0.02


def test_a_turned_stroke_gives_a_turned_motion(loop, learned):
    turn = np.array([[0.28, -0.96], [0.96, 0.28]])
    aligned = align(loop @ turn.T)
    way = plans(aligned)[0]
    assert way.cuts == learned[1].cuts
    branch, _ = compose(aligned, way, DISC, ValidityMargins(), (0,), 2, Checkpoint())
    here = chain_rollout(learned[2].start, learned[2].chain)
    there = chain_rollout(branch.start, branch.chain)
    # First guesses are not drawn along the turn: other obstacles, the same motion, as
    # near as two that are each within 0.015 of the mean.
    assert discrete_frechet(here.path @ turn.T, there.path) < 0.03


@pytest.mark.parametrize(("scale", "shift"), [(1.0, (0.1, -0.08)), (0.8, (0.0, 0.0))])
def test_a_moved_or_smaller_stroke_gives_a_moved_or_smaller_motion(
    loop, learned, scale, shift
):
    aligned = align(scale * loop + np.array(shift))
    way = plans(aligned)[0]
    assert way.cuts == learned[1].cuts
    branch, _ = compose(aligned, way, DISC, ValidityMargins(), (0,), 2, Checkpoint())
    here = chain_rollout(learned[2].start, learned[2].chain)
    there = chain_rollout(branch.start, branch.chain)
    # The workspace and the margins stay where and what they are: as above.
    moved = scale * here.path + np.array(shift)
    assert discrete_frechet(moved, there.path) < 0.03
