"""The numeric search on worlds whose critical points are known."""

import numpy as np
import pytest

from bath_drake.field.critical_points import check_field, find_critical_points
from bath_drake.field.navigation import NavigationField, grad_psi
from bath_drake.field.obstacles import ObstacleSet, Workspace

Row = list[float]


def _world(kappa: float, *rows: Row) -> NavigationField:
    theta = np.array(rows, dtype=np.float64).reshape(-1, 5)
    disc = Workspace(np.zeros(2), np.array([5.0, 5.0]))
    return NavigationField(disc, np.array([3.0, 0.0]), kappa, ObstacleSet(theta))


KNOWN = {
    "one disc": (_world(4, [0, 0, 1, 1, 0]), "numeric-pass", [(-1.67172, 0)], []),
    "broadside ellipse": (
        _world(10, [-0.5, 0, 0.2, 1.6, 0]),
        "refuted",
        [(-0.55205, -1.97946), (-0.55205, 1.97946)],
        [(-0.97537, 0)],
    ),
    "overlapping, across": (
        _world(10, [0, 0.6, 0.8, 0.8, 0], [0, -0.6, 0.8, 0.8, 0]),
        "refuted",
        None,
        [(-1.06166, 0)],
    ),
    "overlapping, in line": (
        _world(10, [0.6, 0, 0.8, 0.8, 0], [-0.6, 0, 0.8, 0.8, 0]),
        "numeric-pass",
        [(-1.74547, 0)],
        [],
    ),
}


@pytest.mark.parametrize("name", KNOWN)
def test_known_worlds_get_their_verdict_and_critical_points(name: str) -> None:
    field, verdict, saddles, minima = KNOWN[name]
    check = check_field(field)
    assert check.verdict == verdict
    for kind, expected in (("saddle", saddles), ("minimum", minima)):
        if expected is None:
            continue
        found = [(p.x, p.y) for p in check.critical_points if p.kind == kind]
        # The reference gives five decimals.
        np.testing.assert_allclose(
            np.reshape(found, (-1, 2)), np.reshape(expected, (-1, 2)), atol=1e-5
        )
    if verdict == "refuted":
        assert check.witness == pytest.approx(minima[0], abs=1e-5)


@pytest.mark.parametrize(
    ("offset", "verdict"), [(0.805, "refuted"), (0.85, "numeric-pass")]
)
def test_a_slit_between_two_discs_traps_only_when_narrow(
    offset: float, verdict: str
) -> None:
    field = _world(20, [-0.5, offset, 0.8, 0.8, 0], [-0.5, -offset, 0.8, 0.8, 0])
    assert check_field(field).verdict == verdict


def test_an_empty_workspace_has_no_critical_point_but_the_goal() -> None:
    check = check_field(_world(2))
    assert check.passed
    assert check.critical_points == ()


def test_random_disjoint_discs_have_one_saddle_each() -> None:
    rng = np.random.default_rng(5)
    for _ in range(8):
        rows: list[Row] = []
        while len(rows) < 6:
            x, y, r = *rng.uniform(-3.5, 3.5, 2), rng.uniform(0.2, 0.6)
            apart = all(np.hypot(x - q[0], y - q[1]) > r + q[2] + 0.2 for q in rows)
            inside = np.hypot(x, y) + r < 4.8
            if apart and inside and np.hypot(x - 3, y) > r + 0.5:
                rows.append([x, y, r, r, 0.0])
        field = _world(80, *rows)
        check = check_field(field)
        assert check.verdict == "numeric-pass", check.reason
        kinds = [p.kind for p in check.critical_points]
        assert kinds == ["saddle"] * 6


def test_the_points_found_are_roots() -> None:
    field = _world(12, [0, 0.2, 1, 0.5, 0.3], [-2, -1, 0.5, 0.9, 1])
    points = find_critical_points(field)
    assert len(points) == 2
    for p in points:
        q = np.array([p.x, p.y])
        # Against 2 kappa / distance, the size of the attracting term alone.
        scale = 24.0 / np.hypot(*(q - field.goal))
        assert np.hypot(*grad_psi(q, field)) < 1e-8 * scale


def test_a_goal_or_a_start_inside_an_obstacle_refutes() -> None:
    check = check_field(_world(5, [3, 0.1, 0.5, 0.5, 0]))
    assert check.verdict == "refuted"
    assert check.witness == (3.0, 0.0)
    assert "goal" in check.reason
    assert "obstacle 0" in check.reason
    field = _world(5, [0, 0, 1, 1, 0])
    check = check_field(field, np.array([[-3.0, 1.0], [0.5, 0.0]]))
    assert check.verdict == "refuted"
    assert check.witness == (0.5, 0.0)
    assert "start 1" in check.reason
    assert "outside the workspace" in check_field(field, np.array([6.0, 0])).reason


def test_contacts_are_reported_as_facts_and_do_not_decide() -> None:
    field = _world(10, [0.6, 0, 0.8, 0.8, 0], [-0.6, 0, 0.8, 0.8, 0])
    assert check_field(field).notes == ("obstacles 0 and 1 overlap",)
    crossing = check_field(_world(10, [0, 4.9, 0.8, 0.8, 0]))
    assert crossing.notes == ("obstacle 0 crosses the rim",)
    assert crossing.verdict == "numeric-pass"
