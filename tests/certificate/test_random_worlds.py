"""The certificate against brute force on random worlds."""

import collections

import numpy as np
import pytest
from basins import find_minima
from checks import assert_sound, free_points
from random_worlds import KINDS, exotic_world, random_world

from bath_drake.certificate.certify import certify
from bath_drake.certificate.result import Certificate


def _attack(seed: int, count: int, starts: int) -> collections.Counter[str]:
    verdicts: collections.Counter[str] = collections.Counter()
    for i in range(count):
        rng = np.random.default_rng([seed, i])
        field = random_world(KINDS[i % len(KINDS)], rng)
        found = certify(field)
        assert_sound(found, field, rng, starts)
        _assert_complete(found, field)
        verdicts[found.verdict] += 1
    return verdicts


def _assert_complete(found: Certificate, field) -> None:
    """All minima that brute force finds are among the traps of a refuted world."""
    if found.verdict != "refuted" or not found.traps:
        return
    for root in find_minima(field):
        nearest = min(np.hypot(t.x - root.x, t.y - root.y) for t in found.traps)
        assert nearest < 1e-9 * 5.0, root


@pytest.mark.slow
def test_no_random_world_gets_a_false_verdict() -> None:
    verdicts = _attack(seed=1, count=60, starts=30)
    # Both verdicts must occur often, or half of the claims go untested.
    assert min(verdicts["proved"], verdicts["refuted"]) >= 20
    assert verdicts["undecided"] <= 1


@pytest.mark.exhaustive
@pytest.mark.parametrize("count", [2000])
def test_none_of_many_random_worlds_gets_a_false_verdict(count: int) -> None:
    verdicts = _attack(seed=2, count=count, starts=60)
    assert min(verdicts["proved"], verdicts["refuted"]) >= 0.3 * count
    assert verdicts["undecided"] <= 0.01 * count  # the proof aims at 0.1 %


@pytest.mark.exhaustive
def test_two_hundred_starts_arrive_in_each_of_a_hundred_proved_worlds() -> None:
    proved = 0
    i = 0
    while proved < 100:
        rng = np.random.default_rng([3, i])
        field = random_world(KINDS[i % len(KINDS)], rng)
        i += 1
        found = certify(field)
        if found.passed:
            assert_sound(found, field, rng, starts=400)
            assert len(free_points(field, 400, rng)) >= 100
            proved += 1


def _attack_exotic(seed: int, count: int) -> collections.Counter[str]:
    verdicts: collections.Counter[str] = collections.Counter()
    for i in range(count):
        rng = np.random.default_rng([seed, i])
        field = exotic_world(rng)
        found = certify(field)
        # Minima too sharp to be enclosed may be missing from a refuted world's list.
        assert_sound(found, field, rng, starts=30)
        verdicts[found.verdict] += 1
    return verdicts


def test_needles_slits_and_superellipses_get_no_false_verdict() -> None:
    verdicts = _attack_exotic(seed=1, count=30)
    assert min(verdicts["proved"], verdicts["refuted"]) >= 8


@pytest.mark.exhaustive
def test_a_thousand_needles_slits_and_superellipses_get_no_false_verdict() -> None:
    verdicts = _attack_exotic(seed=4, count=1000)
    assert min(verdicts["proved"], verdicts["refuted"]) >= 300
    # Needles 50 times longer than wide, and slits of a millionth: doubt is allowed.
    assert verdicts["undecided"] <= 30
