"""Areas are kept off at once, confirmed if they stay, and forgotten only as noise."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bath_drake.field.obstacles import ObstacleSet
from bath_drake.perception.area_memory import (
    AreaKeeper,
    AreaMemory,
    merge_areas,
    seen_in_full,
)
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.completion import BackTemplate
from bath_drake.perception.ellipses import level, meet, outline

DT = 1.0 / 30.0
ROW = np.array([0.2, 0.1, 0.15, 0.1, 0.4])
OTHER = np.array([-0.5, -0.5, 0.1, 0.1, 0.0])
NUMBER = st.floats(-0.8, 0.8)
SIZE = st.floats(0.05, 0.3)
ELLIPSE = st.tuples(NUMBER, NUMBER, SIZE, SIZE, st.floats(-3.0, 3.0)).map(np.array)


def areas(*rows):
    return ObstacleSet(np.array(rows).reshape(-1, 5))


def remember(frames, in_view=True, keeper=None, memory=None):
    """What is known after frames of such areas; `in_view` of each, or of all."""
    keeper = AreaKeeper() if keeper is None else keeper
    memory = AreaMemory() if memory is None else memory
    for k, seen in enumerate(frames):
        view = in_view[k] if isinstance(in_view, list) else in_view
        memory = keeper.next(memory, seen, k * DT, lambda _, view=view: view)
    return memory


def test_an_area_is_kept_off_from_its_first_frame():
    assert remember([areas(ROW)]).areas == areas(ROW)


def test_five_frames_confirm_an_area_and_then_no_clear_skin_clears_it():
    memory = remember([areas(ROW)] * 5 + [areas()] * 300)
    assert memory.confirmed == areas(ROW)
    assert memory.tentative == ()


def test_an_area_of_four_frames_goes_after_a_second_in_full_view():
    frames = [areas(ROW)] * 4 + [areas()] * 31
    # The first clear frame is the fourth; thirty later it is a second.
    assert len(remember(frames[:-1]).areas) == 1
    assert len(remember(frames).areas) == 0


def test_hidden_skin_is_no_clear_skin():
    view = [True] + [k % 20 != 0 for k in range(1, 200)]
    frames = [areas(ROW)] + [areas()] * 199
    assert remember(frames, in_view=view).areas == areas(ROW)


def test_a_flickering_area_is_confirmed_in_the_end():
    frames = [areas(ROW) if k % 20 == 0 else areas() for k in range(100)]
    assert remember(frames).confirmed == areas(ROW)


def test_areas_apart_are_remembered_apart():
    memory = remember([areas(ROW), areas(OTHER), areas(ROW, OTHER)])
    assert sorted(one.frames for one in memory.tentative) == [2, 2]


@given(st.lists(st.lists(ELLIPSE, max_size=3), min_size=1, max_size=8))
@settings(max_examples=60, deadline=None)
def test_whatever_is_seen_is_kept_off_in_that_very_frame(frames):
    keeper, memory = AreaKeeper(), AreaMemory()
    for k, rows in enumerate(frames):
        memory = keeper.next(memory, areas(*rows), k * DT, lambda _: True)
        for row in rows:
            corners = outline(row)
            covered = [level(known, corners) for known in memory.areas.theta]
            # What sticks out by 5 % is noise; merging twice may add it twice.
            assert min(lev.max() for lev in covered) <= 1.05**4 + 1e-6


@given(st.lists(ELLIPSE, max_size=5))
@settings(max_examples=60, deadline=None)
def test_the_areas_that_are_kept_off_do_not_meet_a_confirmed_one_anew(rows):
    memory = remember([areas(*rows)] * 6)
    assert memory.tentative == ()
    again = AreaKeeper().next(memory, areas(*rows), 1.0, lambda _: True)
    assert len(again.confirmed) <= len(memory.confirmed)


def test_what_the_carer_gave_stays_whatever_is_seen():
    given_one = AreaMemory(confirmed=areas(OTHER))
    assert remember([areas()] * 200, memory=given_one).areas == areas(OTHER)


BODY = CanonicalMap(np.eye(3), np.zeros(3), np.array([0.17, 0.25]))


@pytest.mark.parametrize(("hidden", "expected"), [(0.0, True), (0.4, True), (1, False)])
def test_a_place_is_in_full_view_if_most_of_its_skin_is_seen(hidden, expected):
    x, y = np.meshgrid(np.arange(-0.17, 0.17, 0.004), np.arange(-0.25, 0.25, 0.004))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    ellipse = np.array([0.0, 0.0, 0.3, 0.2, 0.0])
    inside = level(ellipse, BODY.canonical_from_world(points)) <= 1.0
    rng = np.random.default_rng(0)
    points = points[~inside | (rng.random(len(points)) >= hidden)]
    observation = dataclasses.replace(
        BodyObservation(), points_W=points, point_areas=np.full(len(points), 0.004**2)
    )
    assert seen_in_full(ellipse, observation, BODY) is expected


@pytest.mark.parametrize(
    ("y", "hidden", "expected"),
    # At the rim half of the ellipse is beside the back; farther out there is nothing.
    [(-1.0, 0.0, True), (-1.0, 0.8, False), (-1.5, 0.0, False)],
)
def test_at_the_rim_what_is_beside_the_back_need_not_be_seen(y, hidden, expected):
    x, y_P = np.meshgrid(np.arange(-0.17, 0.17, 0.004), np.arange(-0.25, 0.25, 0.004))
    points = np.column_stack([x.ravel(), y_P.ravel(), np.zeros(x.size)])
    template = BackTemplate(points, np.full(len(points), 0.004**2), 0.0)
    ellipse = np.array([-0.5, y, 0.16, 0.13, 0.0])
    inside = level(ellipse, BODY.canonical_from_world(points)) <= 1.0
    rng = np.random.default_rng(0)
    points = points[~inside | (rng.random(len(points)) >= hidden)]
    observation = dataclasses.replace(
        BodyObservation(),
        points_W=points,
        point_areas=np.full(len(points), 0.004**2),
        template=template,
        tracked_map=BODY,
    )
    assert seen_in_full(ellipse, observation, BODY) is expected


@pytest.mark.parametrize("name", ["confirm_frames", "forget_time"])
@pytest.mark.parametrize("value", [0, np.inf])
def test_the_keepers_numbers_are_checked(name, value):
    with pytest.raises(ValueError, match=name):
        AreaKeeper(**{name: value})


@given(a=ELLIPSE, b=ELLIPSE)
def test_ellipses_meet_each_other_alike_and_apart_they_do_not(a, b):
    assert meet(a, b) == meet(b, a)
    apart = b + np.array([5.0, 0.0, 0.0, 0.0, 0.0])
    assert not meet(a, apart)


def test_merging_nothing_changes_nothing():
    known = areas(ROW, OTHER)
    assert merge_areas(known, areas()) == known
