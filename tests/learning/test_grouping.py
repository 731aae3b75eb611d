"""Demonstrations that go different ways."""

import numpy as np

from bath_drake.learning.grouping import ALIKE, group_strokes


def arcs(*bends):
    """From (-1, 0) to the origin, bent by so much."""
    t = np.linspace(0.0, 1.0, 60)
    return np.array([np.stack([t - 1.0, b * np.sin(np.pi * t)], -1) for b in bends])


def names(strokes):
    return [f"take {i}" for i in range(len(strokes))]


def test_strokes_that_go_one_way_are_one_group():
    strokes = arcs(0.3, 0.4, 0.5)
    groups, outliers = group_strokes(strokes, 1.0, names(strokes))
    assert [g.tolist() for g in groups] == [[0, 1, 2]]
    assert outliers == ()


def test_two_ways_are_two_groups_the_larger_first():
    strokes = arcs(-0.6, 0.5, -0.5, 0.6, 0.55)
    groups, outliers = group_strokes(strokes, 1.0, names(strokes))
    assert [g.tolist() for g in groups] == [[1, 3, 4], [0, 2]]
    assert outliers == ()


def test_neighbours_of_neighbours_go_the_same_way():
    step = 0.8 * ALIKE
    strokes = arcs(0.0, step, 2 * step, 3 * step)
    groups, _ = group_strokes(strokes, 1.0, names(strokes))
    assert [g.tolist() for g in groups] == [[0, 1, 2, 3]]


def test_a_lone_stroke_among_many_is_named_and_left_out():
    strokes = arcs(0.5, 0.5, -0.6, 0.52)
    groups, outliers = group_strokes(strokes, 1.0, names(strokes))
    assert [g.tolist() for g in groups] == [[0, 1, 3]]
    (outlier,) = outliers
    assert (outlier.index, outlier.name) == (2, "take 2")
    assert "another way" in outlier.reason
    assert f"below {ALIKE}" in outlier.reason


def test_a_lone_stroke_from_elsewhere_is_a_way_of_its_own():
    strokes = arcs(0.5, 0.5, -0.6, 0.52)
    strokes[2] += np.linspace([-0.1, -0.3], [0.0, 0.0], 60)
    groups, outliers = group_strokes(strokes, 1.0, names(strokes))
    assert [g.tolist() for g in groups] == [[0, 1, 3], [2]]
    assert outliers == ()


def test_of_two_strokes_none_is_an_outlier():
    strokes = arcs(0.5, -0.5)
    groups, outliers = group_strokes(strokes, 1.0, names(strokes))
    assert [g.tolist() for g in groups] == [[0], [1]]
    assert outliers == ()


def test_what_is_far_depends_on_the_scale():
    strokes = arcs(0.5, -0.5)
    groups, _ = group_strokes(strokes, 10.0, names(strokes))
    assert len(groups) == 1
