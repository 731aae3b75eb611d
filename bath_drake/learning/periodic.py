"""Learns the periodic motion of several demonstrations: one cycle for all.

Each demonstration's cycle is a Fourier series fitted to its offsets over their phase.
Where a hand begins its circles is by chance: the series are turned onto each other
before they are averaged. One whose cycle is another is left out, and why is said.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bath_drake.demonstrations.canonical import CanonicalDemonstration, PeriodicPart
from bath_drake.learning.grouping import Outlier
from bath_drake.notation import FloatArray
from bath_drake.rhythm.limit_cycle import LimitCycle, harmonics

HARMONICS = 3
# Cycles that differ by less than this share of their size are the same motion.
ALIKE = 0.5
# Of the demonstrations, more than this share must have cycles.
QUORUM = 0.5
# Turns at which two cycles are compared.
_TURNS = 180


@dataclass(frozen=True, eq=False)
class PeriodicFit:
    """What the demonstrations have in common of cycles.

    Attributes:
        cycle: None where the demonstrations have no cycles, or too few have.
        left_out: Demonstrations that did not count for the cycle, each with the
            reason; for the discrete motion they may count all the same.
        spread: Mean distance of the demonstrations' cycles to the learned one, as a
            share of its size; 0 without one.
    """

    cycle: LimitCycle | None
    left_out: tuple[Outlier, ...] = ()
    spread: float = 0.0


def learn_cycle(demonstrations: Sequence[CanonicalDemonstration]) -> PeriodicFit:
    """Fits one limit cycle to the demonstrations' periodic parts."""
    shown = [i for i, d in enumerate(demonstrations) if d.periodic is not None]
    if not shown:
        return PeriodicFit(None)
    if len(shown) <= QUORUM * len(demonstrations):
        reason = (
            f"has cycles, as have {len(shown)} of {len(demonstrations)} in all: no "
            "more than half, so that the skill has none"
        )
        return PeriodicFit(
            None, tuple(Outlier(i, demonstrations[i].name, reason) for i in shown)
        )
    series = [_series(part) for part in map(_part, demonstrations) if part is not None]
    middle, aligned = _around_medoid(series)
    left_out = [
        Outlier(i, d.name, "has no cycles; the others have")
        for i, d in enumerate(demonstrations)
        if d.periodic is None
    ]
    kept = []
    for i, own, turned in zip(shown, series, aligned, strict=True):
        reason = _strangeness(own, turned, middle)
        if reason:
            left_out.append(Outlier(i, demonstrations[i].name, reason))
        else:
            kept.append((i, turned))
    mean = np.mean([turned for _, turned in kept], axis=0)
    spread = float(np.mean([_apart(turned, mean) for _, turned in kept]))
    measured = np.array([_lengths(demonstrations[i]) for i, _ in kept])
    pitch, begin, end = np.median(measured[:, 1:], axis=0)
    cycle = LimitCycle(
        mean,
        period=float(np.median(measured[:, 0])),
        pitch=float(pitch),
        begin=float(begin),
        end=float(end),
    )
    left_out.sort(key=lambda outlier: outlier.index)
    return PeriodicFit(cycle, tuple(left_out), spread)


def _part(demonstration: CanonicalDemonstration) -> PeriodicPart | None:
    return demonstration.periodic


def _series(part: PeriodicPart) -> FloatArray:
    """The cycle's series by least squares, shape (2 HARMONICS, 2)."""
    basis = part.envelope[:, None] * harmonics(part.phase, HARMONICS)
    found = np.linalg.lstsq(basis, part.offsets, rcond=None)[0]
    return np.asarray(found, dtype=np.float64)


def _around_medoid(series: list[FloatArray]) -> tuple[FloatArray, list[FloatArray]]:
    """The one nearest to all others, and all turned onto it."""
    sums, turned = [], []
    for reference in series:
        onto = [_turned_onto(own, reference) for own in series]
        sums.append(sum(float(np.linalg.norm(a - reference)) for a in onto))
        turned.append(onto)
    best = int(np.argmin(sums))
    return series[best], turned[best]


def _turned_onto(series: FloatArray, reference: FloatArray) -> FloatArray:
    """c(phi + delta) for the delta that brings it nearest to the reference."""
    turns = np.linspace(0.0, 2.0 * np.pi, _TURNS, endpoint=False)
    candidates = np.array([_turned(series, turn) for turn in turns])
    apart = np.linalg.norm(candidates - reference, axis=(1, 2))
    return np.asarray(candidates[int(np.argmin(apart))])


def _turned(series: FloatArray, turn: float) -> FloatArray:
    """The series of c(phi + turn)."""
    k = np.arange(1, HARMONICS + 1)
    cos, sin = np.cos(k * turn)[:, None], np.sin(k * turn)[:, None]
    a, b = series[0::2], series[1::2]
    turned = np.empty_like(series)
    turned[0::2], turned[1::2] = a * cos + b * sin, b * cos - a * sin
    return turned


def _apart(series: FloatArray, reference: FloatArray) -> float:
    """Root mean square distance over a turn, as a share of the reference's size."""
    return float(np.linalg.norm(series - reference) / np.linalg.norm(reference))


def _strangeness(own: FloatArray, turned: FloatArray, middle: FloatArray) -> str:
    """Why a cycle is another than the middle one; empty if it is not."""
    apart = _apart(turned, middle)
    if apart <= ALIKE:
        return ""
    # c(-phi): the same curve, the other way round.
    backwards = own * np.tile([[1.0], [-1.0]], (HARMONICS, 1))
    if _apart(_turned_onto(backwards, middle), middle) <= ALIKE:
        return "its cycles go the other way round"
    return (
        f"its cycle differs from the others' by {apart:.2f} of its size, allowed: "
        f"{ALIKE}"
    )


def _lengths(
    demonstration: CanonicalDemonstration,
) -> tuple[float, float, float, float]:
    """Period (s), and pitch, begin and end as in `LimitCycle` (in N)."""
    part = demonstration.periodic
    assert part is not None
    steps = np.linalg.norm(np.diff(demonstration.points, axis=0), axis=1)
    along = np.interp(
        part.times, demonstration.times, np.concatenate([[0.0], np.cumsum(steps)])
    )
    active = np.flatnonzero(part.envelope >= 0.5)
    first, last = active[0], active[-1]
    cycles = (part.phase[last] - part.phase[first]) / (2.0 * np.pi)
    pitch = float(along[last] - along[first]) / float(cycles)
    # Half grown where the envelope is one half: cycles grow and fade over a pitch.
    begin = max(0.0, float(along[first]) - 0.5 * pitch)
    end = max(0.0, float(along[-1] - along[last]) - 0.5 * pitch)
    return part.period, max(pitch, 1e-6), begin, end
