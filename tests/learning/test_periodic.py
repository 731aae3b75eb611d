"""One cycle is learned of several hands; those that differ are named."""

import numpy as np
import pytest

from bath_drake.demonstrations.canonical import CanonicalDemonstration, PeriodicPart
from bath_drake.demonstrations.processing import canonical_demonstrations
from bath_drake.demonstrations.recording import read_recording
from bath_drake.demonstrations.synthetic import BACK_HEIGHT, BACK_WIDTH
from bath_drake.demonstrations.synthetic_scrubbing import (
    TAKES,
    ovals,
    slow_stroke,
    write_scrubbing,
)
from bath_drake.learning.periodic import learn_cycle
from bath_drake.resources import models_folder
from bath_drake.rhythm.limit_cycle import LimitCycle

OVAL = np.array([[0.10, 0.03], [-0.02, 0.06]])


def shown(
    name="one", cycle=OVAL, *, begin=0.7, period=1.2, direction=1.0, periodic=True
):
    """A straight stroke of length 1.2 with ten cycles from a phase of its own."""
    t = np.linspace(0.0, 10.0 * period, 400)
    phase = 2.0 * np.pi * t / period
    curve = LimitCycle(cycle, 1.0, 1.0)
    part = PeriodicPart(
        times=t,
        offsets=curve.offset(direction * (phase + begin)),
        phase=phase,
        envelope=np.ones_like(t),
        period=period,
    )
    line = np.linspace([-0.6, 0.0], [0.6, 0.0], 200)
    return CanonicalDemonstration(
        name=name,
        times=np.linspace(0.0, t[-1], 200),
        points=line,
        raw=line,
        sha256="",
        periodic=part if periodic else None,
    )


def same_curve(found, expected):
    """The distance of two cycles as curves, wherever they begin."""
    turn = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    a, b = found.offset(turn), LimitCycle(expected, 1.0, 1.0).offset(turn)
    return np.linalg.norm(a[:, None] - b[None], axis=-1).min(axis=1).max()


def test_demonstrations_that_begin_at_other_phases_make_one_cycle():
    fit = learn_cycle([shown(begin=b) for b in (0.0, 2.0, 4.5)])
    # Phases are matched to a half of 2 degrees, on a cycle of 0.1.
    assert same_curve(fit.cycle, OVAL) <= 0.002
    assert fit.spread <= 0.04
    assert fit.left_out == ()
    assert fit.cycle.period == pytest.approx(1.2)
    # Ten cycles on a length of 1.2.
    assert fit.cycle.pitch == pytest.approx(0.12, rel=1e-6)


def test_without_cycles_there_is_none():
    fit = learn_cycle([shown(periodic=False), shown(periodic=False)])
    assert fit.cycle is None
    assert fit.left_out == ()


def test_one_that_goes_the_other_way_round_is_named():
    strokes = [shown("a"), shown("b"), shown("c", direction=-1.0)]
    fit = learn_cycle(strokes)
    assert [(o.index, o.name) for o in fit.left_out] == [(2, "c")]
    assert "other way round" in fit.left_out[0].reason
    assert same_curve(fit.cycle, OVAL) <= 0.002


def test_one_with_another_cycle_is_named():
    strokes = [shown("a"), shown("b"), shown("c", cycle=4.0 * OVAL)]
    fit = learn_cycle(strokes)
    assert [o.name for o in fit.left_out] == ["c"]
    assert "allowed: 0.5" in fit.left_out[0].reason


def test_one_without_cycles_among_those_with_is_named():
    fit = learn_cycle([shown("a"), shown("b", periodic=False), shown("c")])
    assert [o.name for o in fit.left_out] == ["b"]
    assert fit.cycle is not None


def test_cycles_of_a_few_are_not_the_skill_s_and_that_is_said():
    fit = learn_cycle([shown("a"), shown("b", periodic=False)])
    assert fit.cycle is None
    assert [o.name for o in fit.left_out] == ["a"]
    assert "1 of 2" in fit.left_out[0].reason


def test_the_shipped_scrubbing_is_learned_as_it_was_made():
    paths = sorted((models_folder() / "demonstrations").glob("scrubbing_?.csv"))
    recordings = [read_recording(path) for path in paths]
    demonstrations, frame = canonical_demonstrations(recordings)
    fit = learn_cycle(demonstrations)
    assert fit.left_out == ()
    share = np.linspace(0.4, 0.6, 800)
    sizes = [
        np.linalg.norm(ovals(take, share) / frame.scales, axis=1).max()
        for take in TAKES
    ]
    # Tremor of up to 0.9 mm a direction on ovals of 26 mm, averaged over 35 of them.
    assert fit.cycle.radius == pytest.approx(np.mean(sizes), rel=0.03)
    periods = [take.duration / take.cycles for take in TAKES]
    assert fit.cycle.period == pytest.approx(np.median(periods), rel=0.02)
    way = slow_stroke(np.linspace(0.0, 1.0, 500)) / np.array(
        [BACK_WIDTH / 2.0, BACK_HEIGHT / 2.0]
    )
    length = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
    pitches = [length / take.cycles for take in TAKES]
    # Of the middle part alone, where the stroke is faster than at its ends.
    assert fit.cycle.pitch == pytest.approx(np.median(pitches), rel=0.08)


def test_the_shipped_scrubbing_is_what_the_generator_writes(tmp_path):
    shipped = models_folder() / "demonstrations"
    for path in write_scrubbing(tmp_path):
        for made in (path, path.with_suffix(".yaml")):
            assert made.read_bytes() == (shipped / made.name).read_bytes()
