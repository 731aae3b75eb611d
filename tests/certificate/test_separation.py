"""What a start can reach: a trap in another component of its sublevel set is none."""

import numpy as np
import pytest
from worlds import make

from bath_drake.certificate.certify import certify, certify_from
from bath_drake.certificate.evaluation import new_table
from bath_drake.certificate.levels import psi_at
from bath_drake.certificate.regions import level_of
from bath_drake.certificate.separation import _CELLS, _build_walls
from bath_drake.certificate.world import Uncertainty, interval_world
from bath_drake.field.rollout import RolloutStatus, rollout_ends

# An ellipse broadside to the goal traps at (-0.975, 0), behind it.
BROADSIDE = make(10, [-0.5, 0, 0.2, 1.6, 0])
IN_FRONT, BEHIND = (-0.2, 3.0), (-2.0, 0.0)


def level(q) -> float:
    return level_of(interval_world(BROADSIDE, None), np.array([q]))[1]


def test_a_start_is_proved_although_its_level_is_above_a_trap_elsewhere():
    trap = certify(BROADSIDE).traps[0]
    assert level(IN_FRONT) > level((trap.x, trap.y))
    found = certify(BROADSIDE, starts=IN_FRONT)
    assert found.verdict == "proved"
    assert found.apart
    assert not found.traps
    assert all(p.kind != "minimum" for p in found.critical_points)


def test_a_start_in_the_trap_s_component_is_not():
    found = certify(BROADSIDE, starts=BEHIND)
    assert found.verdict == "refuted"
    assert not found.apart
    both = certify(BROADSIDE, starts=[IN_FRONT, BEHIND])
    assert both.verdict == "refuted"


def test_nothing_is_apart_where_there_is_no_trap():
    found = certify(make(4, [0, 0, 1, 1, 0]), starts=BEHIND)
    assert found.verdict == "proved"
    assert not found.apart


def test_certify_from_takes_what_can_be_had():
    assert certify_from(BROADSIDE, IN_FRONT).apart
    assert certify_from(BROADSIDE, BEHIND).region is None


def test_a_closed_pocket_does_not_matter_to_a_start_outside_it():
    t = np.arange(8) * (np.pi / 4.0)
    ring = [[-1 + np.cos(a), np.sin(a), 0.5, 0.5, 0.0] for a in t]
    field = make(30, *ring)
    assert certify(field).verdict == "refuted"
    found = certify(field, starts=(-4.0, 1.0))
    assert found.verdict == "proved"
    assert certify(field, starts=(-1.0, 0.1)).verdict == "refuted"


def test_uncertain_obstacles_are_told_apart_too():
    # The walls stand for every realisation, the level is the highest of all.
    uncertainty = Uncertainty(centres=1e-4, semi_axes=1e-4)
    found = certify(BROADSIDE, starts=IN_FRONT, uncertainty=uncertainty)
    assert found.verdict == "proved"
    assert found.apart


@pytest.mark.parametrize("c", [-5.0, 5.0, 20.0, 30.0])
def test_no_wall_stands_where_psi_is_at_most_the_level(c, rng):
    world = interval_world(BROADSIDE, None)
    walls = np.zeros((_CELLS, _CELLS), dtype=np.bool_)
    _build_walls(world, c, walls)
    assert walls.any()
    assert not walls.all()
    q = rng.uniform(-5.0, 5.0, (4000, 2))
    cells = np.floor((q / 5.0 + 1.0) / 2.0 * _CELLS).astype(int)
    table = new_table(world)
    seen = 0
    for (i, j), (x, y) in zip(cells, q, strict=True):
        free = np.hypot(x, y) < 5.0
        free &= ((x + 0.5) / 0.2) ** 2 + (y / 1.6) ** 2 > 1.0
        if walls[i, j] and free:
            seen += 1
            assert psi_at(x, y, world, table)[1] > c
    # At the highest level little more than a layer along the boundaries is walled.
    assert seen > 20


def test_proved_starts_arrive_and_others_may_not(rng):
    # Random starts of a world with a trap: of those proved, each arrives.
    q = rng.uniform(-4.0, 4.0, (60, 2))
    statuses, _ = rollout_ends(q, BROADSIDE, step=0.02)
    verdicts = [
        "outside" if s is RolloutStatus.LEFT else certify(BROADSIDE, starts=p).verdict
        for p, s in zip(q, statuses, strict=True)
    ]
    for verdict, status in zip(verdicts, statuses, strict=True):
        if verdict == "proved":
            assert status is RolloutStatus.ARRIVED
    assert verdicts.count("proved") > 20
    assert verdicts.count("refuted") > 5
