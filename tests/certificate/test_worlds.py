"""The certificate on worlds whose verdict follows from a reason."""

import numpy as np
import pytest
from basins import polish
from checks import assert_is_a_trap, assert_sound
from folds import broadside, fold, pitchfork, tilted, tilted_by_kappa
from worlds import BORDERLINE, WORLDS, World, make

from bath_drake.certificate.certify import certify
from bath_drake.certificate.result import Certificate


@pytest.mark.parametrize("name", WORLDS)
def test_a_world_gets_the_verdict_it_deserves(name: str, rng) -> None:
    world: World = WORLDS[name]
    found = certify(world.field)
    assert found.verdict in world.verdicts, (found.reason, world.why)
    assert_sound(found, world.field, rng, starts=40)
    if found.verdict == "undecided":
        assert world.cause is None or {d.cause for d in found.doubts} == {world.cause}
        assert all(d.remedy for d in found.doubts)
    if world.witness is not None and found.verdict == "refuted":
        assert found.witness == world.witness


@pytest.mark.parametrize(
    "name", [n for n, w in WORLDS.items() if w.minima and "proved" not in w.verdicts]
)
def test_the_traps_are_the_minima_that_are_known(name: str) -> None:
    world = WORLDS[name]
    traps = certify(world.field).traps
    # The catalogue gives five decimals.
    np.testing.assert_allclose([(t.x, t.y) for t in traps], world.minima, atol=1e-5)
    assert {t.component for t in traps} == {"pocket" if world.pocket else "goal"}
    for trap in traps:
        assert_is_a_trap(trap, world.field)


@pytest.mark.parametrize(
    "name", [n for n, w in WORLDS.items() if w.saddles is not None]
)
def test_the_saddles_are_the_ones_that_are_known(name: str) -> None:
    world = WORLDS[name]
    points = certify(world.field).critical_points
    saddles = [(p.x, p.y) for p in points if p.kind == "saddle"]
    np.testing.assert_allclose(
        np.reshape(saddles, (-1, 2)), np.reshape(world.saddles, (-1, 2)), atol=1e-5
    )
    for p in points:
        root = polish(p.x, p.y, world.field)
        assert root is not None
        # Of the larger eigenvalue; both sides polish to 1e-13 of the workspace.
        np.testing.assert_allclose(
            p.eigenvalues, (root.low, root.high), rtol=1e-9, atol=1e-9 * root.high
        )


def test_a_start_that_is_not_free_refutes_and_is_named() -> None:
    field = make(4, [0, 0, 1, 1, 0])
    found = certify(field, starts=[[-3.0, 1.0], [0.5, 0.0]])
    assert found.verdict == "refuted"
    assert found.witness == (0.5, 0.0)
    assert "start 1" in found.reason
    found = certify(field, starts=[[6.0, 1.0]])
    assert found.verdict == "refuted"
    assert found.witness == (6.0, 1.0)


def test_a_start_on_a_boundary_is_never_proved() -> None:
    field = make(4, [0, 0, 1, 1, 0])
    for start in ([-1.0, 0.0], [0.0, 5.0], [np.cos(2.0), np.sin(2.0)]):
        assert certify(field, starts=[start]).verdict != "proved"


def _sides(build, birth, distance: float) -> tuple[Certificate, Certificate]:
    return (
        certify(build(birth.below * (1.0 - distance))),
        certify(build(birth.above * (1.0 + distance))),
    )


_FAMILIES = {
    "an ellipse off the axis grows": (
        lambda: fold(tilted, 1.4, 1.6, (-1.1, -0.65)),
        tilted,
        ("proved", "refuted"),
        1e-9,
    ),
    "kappa grows": (
        lambda: fold(tilted_by_kappa, 20.0, 30.0, (-1.0, -0.65)),
        tilted_by_kappa,
        ("refuted", "proved"),
        1e-6,
    ),
    "an ellipse on the axis grows": (
        lambda: pitchfork(broadside, 0.8, 1.4, -1.25),
        broadside,
        ("proved", "refuted"),
        1e-6,
    ),
}


@pytest.mark.parametrize("name", _FAMILIES)
def test_a_family_is_decided_on_both_sides_of_where_its_trap_is_born(
    name: str,
) -> None:
    find, build, sides, nearest = _FAMILIES[name]
    birth = find()
    for distance in (1e-1, 1e-2, 1e-4, nearest):
        below, above = _sides(build, birth, distance)
        assert (below.verdict, above.verdict) == sides, distance
        for found in (below, above):
            for trap in found.traps:
                assert np.hypot(trap.x - birth.x, trap.y - birth.y) < 0.6
    # Nearer, doubt is allowed, an error is not.
    for distance in (1e-8, 1e-10, 1e-12, 1e-14, 0.0):
        for found, truth in zip(_sides(build, birth, distance), sides, strict=True):
            assert found.verdict in (truth, "undecided"), distance
            if found.verdict == "undecided":
                assert {d.cause for d in found.doubts} <= {"degeneracy", "budget"}
                where = found.doubts[0].box
                reach = where.width + 1e-2
                assert np.hypot(
                    where.centre[0] - birth.x, where.centre[1] - birth.y
                ) < max(reach, 0.05)


def test_the_gap_at_which_two_discs_begin_to_trap_is_bracketed() -> None:
    def verdict(gap: float) -> str:
        offset = 0.8 + 0.5 * gap
        rows = [[-0.5, offset, 0.8, 0.8, 0.0], [-0.5, -offset, 0.8, 0.8, 0.0]]
        return certify(make(20, *rows)).verdict

    # 0.2 % of the radius traps, 2 % does not. One change between.
    gaps = np.linspace(0.002, 0.1, 25)
    verdicts = [verdict(g) for g in gaps.tolist()]
    change = verdicts.index("proved")
    assert 0 < change < len(gaps)
    assert verdicts == ["refuted"] * change + ["proved"] * (len(gaps) - change)


@pytest.mark.parametrize("name", ["goal a billionth", "boundary up to rounding"])
def test_what_is_undecided_is_said_in_words(name: str) -> None:
    (world,) = [w for n, w in BORDERLINE.items() if name in n]
    found = certify(world.field)
    if found.verdict == "undecided":
        assert found.reason
        assert not found.passed
        for doubt in found.doubts:
            # The doubt is about the goal's surroundings.
            near = np.hypot(
                doubt.box.centre[0] - world.field.goal[0],
                doubt.box.centre[1] - world.field.goal[1],
            )
            assert near < 1e-3
