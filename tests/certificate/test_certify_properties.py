"""What must hold of certificates of any world."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import hypothesis.strategies as st
import numpy as np
import pytest
from checks import assert_all_arrive, assert_enclosures_hold, free_points
from hypothesis import given, settings
from random_worlds import KINDS, random_world
from strategies import any_worlds, disjoint_worlds, kappas, moved, worlds
from worlds import make

from bath_drake.certificate.certify import Uncertainty, certify
from bath_drake.certificate.result import Certificate
from bath_drake.field.critical_points import find_critical_points
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace

angles = st.floats(-3.2, 3.2)


def _untimed(found: Certificate) -> Certificate:
    return replace(found, seconds=0.0)


def _agree(one: Certificate, other: Certificate) -> None:
    if "undecided" not in (one.verdict, other.verdict):
        assert one.verdict == other.verdict


@settings(max_examples=60)
@given(
    worlds,
    st.floats(-3.0, 3.0).map(lambda e: 10.0**e),
    angles,
    st.booleans(),
    st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0)),
)
def test_a_world_moved_turned_mirrored_or_scaled_keeps_its_verdict(
    field: NavigationField,
    scale: float,
    angle: float,
    mirrored: bool,
    shift: tuple[float, float],
) -> None:
    shift = (shift[0] * scale, shift[1] * scale)
    other, matrix = moved(
        field, scale=scale, angle=angle, mirrored=mirrored, shift=shift
    )
    one, two = certify(field), certify(other)
    _agree(one, two)
    if one.verdict == two.verdict == "refuted":
        here = np.array([(t.x, t.y) for t in one.traps]) @ matrix.T + shift
        there = np.array([(t.x, t.y) for t in two.traps])
        for q in here:
            # Coordinates of up to 75 radii lose 1e-14, and a minimum is as
            # uncertain as that over its lower eigenvalue: 1e-6 is ample.
            assert np.hypot(*(there - q).T).min() < 1e-6 * 5.0 * scale


@settings(max_examples=40)
@given(worlds, st.sampled_from([2.0**-20, 0.25, 4.0, 2.0**30]))
def test_a_world_scaled_by_a_power_of_two_takes_the_very_same_boxes(
    field: NavigationField, scale: float
) -> None:
    # Nothing is rounded on the way, and nothing in the proof has a unit but the
    # widening's 1e-300.
    other, _ = moved(field, scale=scale)
    one, two = certify(field), certify(other)
    assert (one.verdict, one.boxes) == (two.verdict, two.boxes)
    for p, q in zip(one.critical_points, two.critical_points, strict=True):
        assert (p.x * scale, p.y * scale, p.kind) == (q.x, q.y, q.kind)


@settings(max_examples=40)
@given(worlds, st.randoms(use_true_random=False))
def test_the_order_of_obstacles_does_not_matter(field: NavigationField, random) -> None:
    order = list(range(len(field.obstacles)))
    random.shuffle(order)
    shuffled = ObstacleSet(field.obstacles.theta[order], field.obstacles.powers[order])
    other = NavigationField(field.workspace, field.goal, field.kappa, shuffled)
    one, two = certify(field), certify(other)
    _agree(one, two)
    assert len(one.traps) == len(two.traps)


@settings(max_examples=60)
@given(disjoint_worlds(kappas=kappas))
def test_critical_points_of_disjoint_worlds_sum_to_the_number_of_holes(
    field: NavigationField,
) -> None:
    found = certify(field)
    if found.verdict == "undecided":
        return
    kinds = [p.kind for p in found.critical_points]
    # Poincare-Hopf with the goal's minimum: 1 + #min - #saddle + #max = 1 - holes.
    count = kinds.count("saddle") - kinds.count("minimum") - kinds.count("maximum")
    assert count == len(field.obstacles)
    if found.passed:
        assert "minimum" not in kinds


@settings(max_examples=40)
@given(worlds)
def test_every_critical_point_that_a_search_finds_is_on_the_list(
    field: NavigationField,
) -> None:
    found = certify(field)
    if found.verdict == "undecided":
        return
    assert_enclosures_hold(found, field)
    listed = np.array([(p.x, p.y) for p in found.critical_points]).reshape(-1, 2)
    for p in find_critical_points(field, resolution=16):
        assert len(listed)
        # Both polish to about 1e-11 of the radius.
        assert np.hypot(*(listed - (p.x, p.y)).T).min() < 1e-7
    for p in found.critical_points:
        inside = [q.box for q in found.critical_points if q.box is not None]
        others = [box for box in inside if box is not p.box and box.holds(p.x, p.y)]
        assert others == []  # each box holds one critical point


@settings(max_examples=30)
@given(worlds, st.integers(0, 2**32 - 1))
def test_starts_in_a_proved_world_arrive(field: NavigationField, seed: int) -> None:
    if certify(field).passed:
        starts = free_points(field, 40, np.random.default_rng(seed))
        assert_all_arrive(starts, field)


@settings(max_examples=25)
@given(worlds)
def test_a_certificate_is_the_same_every_time(field: NavigationField) -> None:
    assert _untimed(certify(field)) == _untimed(certify(field))


@settings(max_examples=25)
@given(any_worlds(most=4), disjoint_worlds(most=3))
def test_an_area_added_at_run_time_makes_the_world_of_all_obstacles(
    field: NavigationField, other: NavigationField
) -> None:
    extra = other.obstacles
    joined = certify(field.with_obstacles(extra))
    rows = np.concatenate([field.obstacles.theta, extra.theta]).tolist()
    powers = np.concatenate([field.obstacles.powers, extra.powers]).tolist()
    goal = (float(field.goal[0]), float(field.goal[1]))
    whole = certify(make(field.kappa, *rows, exponents=powers, goal=goal))
    assert _untimed(joined) == _untimed(whole)
    _agree(
        joined,
        certify(
            NavigationField(
                field.workspace, field.goal, field.kappa, extra + field.obstacles
            )
        ),
    )


def test_certificates_made_at_once_in_threads_are_those_made_in_turn() -> None:
    fields = [
        random_world(KINDS[i % 3], np.random.default_rng([5, i])) for i in range(24)
    ]
    with ThreadPoolExecutor(4) as pool:
        at_once = list(pool.map(certify, fields))
    for field, found in zip(fields, at_once, strict=True):
        assert _untimed(found) == _untimed(certify(field))


@pytest.mark.parametrize("offset", [1e3, 1e6, 1e9, 1e12, 1e15])
def test_far_from_the_origin_a_verdict_is_the_true_one_or_none(offset: float) -> None:
    def far(kappa: float, row: list[float]) -> NavigationField:
        return make(
            kappa,
            [row[0] + offset, row[1] - offset, *row[2:]],
            goal=(offset + 3.0, -offset),
            centre=(offset, -offset),
        )

    # All coordinates are multiples of 1/4 or so: exact up to 1e15.
    passing = certify(far(4, [0.0, 0.0, 1.0, 1.0, 0.0]), budget=20_000)
    trapping = certify(far(10, [-0.5, 0.0, 0.25, 1.5, 0.0]), budget=20_000)
    assert passing.verdict in ("proved", "undecided")
    assert trapping.verdict in ("refuted", "undecided")
    if offset <= 1e3:
        assert passing.passed
        assert trapping.verdict == "refuted"


@pytest.mark.parametrize(
    "field",
    [
        make(1e12, [0, 0, 1, 1, 0]),
        make(1e-12, [0, 0, 1, 1, 0]),
        make(10, [0, 0, 1e-14, 1e-14, 0]),
        make(10, [0, 0, 1, 1, 1e9]),
        make(10, [0, 0, 1, 1, 0], exponents=[1e14]),
        make(10, [0, 0, 1, 1, 0], exponents=[1e-14]),
        make(10, [1e14, 0, 1, 1, 0]),
        make(10, [0, 0, 1e-14, 3, 0.5]),
        make(10, semi_axes=(1e-14, 1e14), goal=(0, 0)),
        make(10, [1e-70, 0, 1e-70, 1e-70, 0]),
        make(10, [1e200, 0, 1e200, 1e200, 0]),
        make(10, [0, 0, 1e-200, 1e-200, 0]),
        make(1e300, [0, 0, 1, 1, 0]),
        make(10, goal=(5.0 - 1e-15, 0)),
        make(10, centre=(1e300, 0), goal=(1e300, 0)),
    ],
    ids=str,
)
def test_numbers_of_any_size_give_a_verdict(field: NavigationField) -> None:
    for uncertainty in (None, Uncertainty(1e-16, 0.0)):
        found = certify(field, uncertainty=uncertainty, budget=5000)
        assert found.verdict in ("proved", "refuted", "undecided")
        assert found.reason
        assert found.boxes <= 5000


def test_a_budget_too_small_is_named_as_the_cause() -> None:
    field = make(4, [0, 0, 1, 1, 0])
    found = certify(field, budget=100)
    assert found.verdict == "undecided"
    assert found.boxes == 100
    assert {d.cause for d in found.doubts} == {"budget"}
    assert certify(field, budget=10_000).passed


@settings(max_examples=30)
@given(worlds, st.integers(1, 400), st.floats(-8.0, -1.0))
def test_less_effort_never_changes_one_decided_verdict_into_another(
    field: NavigationField, budget: int, log_resolution: float
) -> None:
    found = certify(field, budget=budget, resolution=10.0**log_resolution)
    _agree(found, certify(field))
    assert found.boxes <= budget


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"budget": 0}, "budget"),
        ({"resolution": 0.0}, "resolution"),
        ({"resolution": 1.0}, "resolution"),
        ({"starts": [[np.nan, 0.0]]}, "starts"),
        ({"starts": [[0.0, 1.0, 2.0]]}, "starts"),
        ({"starts": []}, "starts"),
    ],
)
def test_bad_arguments_are_refused(arguments, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        certify(make(4, [0, 0, 1, 1, 0]), **arguments)


def test_a_long_workspace_is_no_obstacle() -> None:
    field = NavigationField(
        Workspace(np.zeros(2), np.array([100.0, 1.0])),
        np.array([90.0, 0.0]),
        3000.0,  # the pull 2 kappa / distance must pass an obstacle 90 away
        ObstacleSet(np.array([[0.0, 0.2, 0.3, 0.3, 0.0]])),
    )
    found = certify(field)
    assert found.passed, found.reason
    assert [p.kind for p in found.critical_points] == ["saddle"]
