"""How stages follow start and goal."""

from itertools import pairwise

import numpy as np
import pytest

from bath_drake.learning.alignment import Alignment, align
from bath_drake.learning.chain.responses import fit_conditioning
from bath_drake.learning.frechet import discrete_frechet

T = np.linspace(0.0, 1.0, 101)
CUTS = (0, 40, 70, 100)
PIECES = list(pairwise(CUTS))


def wave(offset=(0.0, 0.0), height=0.4):
    """A wave that ends at the origin, its start moved and the move fading evenly."""
    base = np.stack([1.5 * (T - 1.0), height * np.sin(2 * np.pi * T)], axis=-1)
    return base + (1.0 - T)[:, None] * np.asarray(offset)


def moved(conditioning, mean, start, goal=None):
    moves = conditioning.similarities(start, goal)
    return [
        move.points(mean[a : b + 1]) for move, (a, b) in zip(moves, PIECES, strict=True)
    ]


@pytest.fixture
def aligned():
    offsets = [(0.0, 0.1), (0.1, -0.05), (-0.1, -0.05)]
    return align(np.array([wave(o) for o in offsets]), wave())


def test_at_the_mean_start_nothing_moves(aligned):
    conditioning = fit_conditioning(aligned, CUTS)
    for move in conditioning.similarities(aligned.mean[0]):
        assert move.is_identity


def test_the_last_stage_keeps_the_goal_wherever_the_motion_starts(aligned):
    conditioning = fit_conditioning(aligned, CUTS)
    *_, last = conditioning.similarities(aligned.mean[0] + [0.3, -0.4])
    np.testing.assert_array_equal(last.points(aligned.mean[-1]), aligned.mean[-1])


def test_another_goal_is_met_exactly(aligned):
    conditioning = fit_conditioning(aligned, CUTS)
    goal = aligned.mean[-1] + [0.07, -0.03]
    *_, last = conditioning.similarities(aligned.mean[0], goal)
    # One rounding of pivot + shift.
    np.testing.assert_allclose(last.points(aligned.mean[-1]), goal, atol=1e-15)


def test_moved_stages_are_nearer_to_each_demonstration_than_the_mean(aligned):
    conditioning = fit_conditioning(aligned, CUTS)
    for stroke in aligned.points:
        found = np.concatenate(moved(conditioning, aligned.mean, stroke[0]))
        left = discrete_frechet(found, stroke)
        assert left < 0.6 * discrete_frechet(aligned.mean, stroke)


def test_similarities_turn_and_scale_along(aligned):
    turn = 1.7 * np.array([[0.6, -0.8], [0.8, 0.6]])
    other = Alignment(aligned.points @ turn.T, aligned.mean @ turn.T)
    start = aligned.mean[0] + [0.05, 0.08]
    here = moved(fit_conditioning(aligned, CUTS), aligned.mean, start)
    there = moved(fit_conditioning(other, CUTS), other.mean, turn @ start)
    for a, b in zip(here, there, strict=True):
        # Two least-squares fits of a dozen numbers: rounding only.
        np.testing.assert_allclose(a @ turn.T, b, atol=1e-9)


def test_one_demonstration_is_enough():
    stroke = wave()
    conditioning = fit_conditioning(align(stroke[None]), CUTS)
    found = moved(conditioning, stroke, stroke[0] + [0.02, 0.03])
    assert all(np.isfinite(piece).all() for piece in found)


def test_a_closed_stroke_is_not_turned_about_its_end():
    angle = 2 * np.pi * T
    ring = np.stack([np.cos(angle) - 1.0, np.sin(angle)], axis=-1)
    strokes = np.array([ring + (1.0 - T)[:, None] * [0.0, d] for d in (0.02, -0.02)])
    conditioning = fit_conditioning(align(strokes, ring), CUTS)
    for move in conditioning.similarities(ring[0] + [0.02, 0.0]):
        # The ends are together: a turn that takes one to the other has no measure.
        assert abs(move.stretch - 1.0) < 0.05
