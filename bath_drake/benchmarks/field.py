"""`bath-drake bench field`: how fast and how true the field and its proof are.

Worlds are those of `random_worlds`, from fixed seeds: every run measures the same.
Everything is warmed up first. A proof of 12 obstacles is timed three times and the
median taken, one of 20 once; batches and roll-outs are the best of several calls.

Targets are for a machine that does nothing else, and for the time on the clock. Others
that want the same cores make proofs and first calls longer in proportion: at a load of
5 on 2 cores, proofs took three times as long. What is short and the best of several
calls (directions, a roll-out) hardly changes, a batch on all cores up to twice. Then
look at the figures called cpu, which count only the time the processor spent on the
work, and at the ratios, both sides of which are measured in the same run. The JSON
file holds the load the run began with.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from bath_drake.benchmarks import numpy_field
from bath_drake.benchmarks.chains import chain_proof
from bath_drake.benchmarks.figures import Figure, Progress
from bath_drake.benchmarks.fresh import (
    first_calls,
    proof_worlds,
    uncompiled_proof_seconds,
)
from bath_drake.benchmarks.random_worlds import (
    RADIUS,
    disjoint_world,
    free_points,
    overlapping_world,
)
from bath_drake.benchmarks.soundness import varied_world, wrong_boxes
from bath_drake.benchmarks.timing import best_seconds, one_core, seconds
from bath_drake.certificate.certify import certify
from bath_drake.field.navigation import NavigationField, flow_direction
from bath_drake.field.rollout import rollout, rollouts
from bath_drake.notation import FloatArray

_STEPS = 200
_STEP = 0.004 * RADIUS
_Tick = Callable[[float], None]


@dataclass(frozen=True, kw_only=True)
class Effort:
    """How much is measured; the defaults are what the targets are meant for.

    Attributes:
        disjoint: Worlds of 12 disjoint ellipses.
        overlapping: Worlds of 20 overlapping ones.
        boxes: Random boxes the proof's test is asked about.
        box_worlds: Over how many worlds they are spread.
        proved: Proved worlds whose roll-outs are followed.
        starts: Roll-outs in each.
        points: Of the batch of directions.
        batch: Roll-outs in the batch.
        repeats: Calls of which the best counts.
        uncompiled: Worlds proved without a compiler.
    """

    disjoint: int = 500
    overlapping: int = 1000
    boxes: int = 1_000_000
    box_worlds: int = 200
    proved: int = 100
    starts: int = 200
    points: int = 100_000
    batch: int = 1000
    repeats: int = 10
    uncompiled: int = 3


def run(progress: Progress, effort: Effort | None = None) -> list[Figure]:
    """Measures everything; about three minutes with the effort of the targets."""
    effort = effort or Effort()
    stages: list[tuple[str, float, Callable[[Effort, _Tick], list[Figure]]]] = [
        ("proving disjoint ellipses", 15.0, disjoint_proofs),
        ("proving overlapping ellipses", 20.0, overlapping_proofs),
        ("proving without a compiler", 15.0, uncompiled_proofs),
        ("proving a chain", 1.0, chains),
        ("random boxes", 75.0, soundness_of_boxes),
        ("roll-outs in proved worlds", 18.0, soundness_of_proofs),
        ("directions", 3.0, directions),
        ("roll-outs", 10.0, roll_outs),
        ("first calls", 40.0, first_call),
    ]
    total = sum(share for _, share, _ in stages)
    figures: list[Figure] = []
    done = 0.0
    for title, share, measure in stages:
        tick = partial(_advance, progress, title, done / total, share / total)
        tick(0.0)
        figures += measure(effort, tick)
        done += share
    progress("done", 1.0)
    return figures


def _advance(
    progress: Progress, title: str, before: float, share: float, done: float
) -> None:
    progress(title, before + share * done)


def disjoint_proofs(effort: Effort, tick: _Tick) -> list[Figure]:
    """Proofs of worlds of 12 disjoint ellipses, kappa uniform in 2..150."""
    rng = np.random.default_rng(1)
    fields = [
        disjoint_world(rng, 12, rng.uniform(2.0, 150.0)) for _ in range(effort.disjoint)
    ]
    times, cpu, verdicts = _prove(fields, 3, tick)
    name = "proof_12_disjoint"
    return [
        Figure(f"{name}_median", 1e3 * float(np.median(times)), "ms", 6.0),
        Figure(f"{name}_median_cpu", 1e3 * float(np.median(cpu)), "ms"),
        Figure(f"{name}_worst", 1e3 * max(times), "ms", 50.0),
        Figure(f"{name}_worst_cpu", 1e3 * max(cpu), "ms"),
        Figure(f"{name}_undecided", verdicts.count("undecided"), "", 0.0),
        Figure(f"{name}_proved", verdicts.count("proved")),
        Figure(f"{name}_refuted", verdicts.count("refuted")),
    ]


def overlapping_proofs(effort: Effort, tick: _Tick) -> list[Figure]:
    """Proofs of worlds of 20 overlapping and rim-cut ellipses, kappa in 2..150."""
    rng = np.random.default_rng(2)
    fields = [
        overlapping_world(rng, 20, rng.uniform(2.0, 150.0))
        for _ in range(effort.overlapping)
    ]
    times, cpu, verdicts = _prove(fields, 1, tick)
    name = "proof_20_overlapping"
    share = 100.0 * verdicts.count("undecided") / len(verdicts)
    return [
        Figure(f"{name}_median", 1e3 * float(np.median(times)), "ms", 15.0),
        Figure(f"{name}_median_cpu", 1e3 * float(np.median(cpu)), "ms"),
        Figure(f"{name}_worst", 1e3 * max(times), "ms"),
        Figure(f"{name}_worst_cpu", 1e3 * max(cpu), "ms"),
        Figure(f"{name}_undecided", share, "%", 0.1),
        Figure(f"{name}_proved", verdicts.count("proved")),
        Figure(f"{name}_refuted", verdicts.count("refuted")),
    ]


def uncompiled_proofs(effort: Effort, tick: _Tick) -> list[Figure]:
    """The same proofs by the same code as plain Python and numpy, in another process.

    There is no numpy version of the proof to compare with: each box decides what
    becomes of it, which whole arrays cannot.
    """
    plain = uncompiled_proof_seconds(effort.uncompiled)
    compiled = [
        best_seconds(partial(certify, field), 3)
        for field in proof_worlds(effort.uncompiled)
    ]
    ratios = [p / c for p, c in zip(plain, compiled, strict=True)]
    return [Figure("proof_12_disjoint_speedup", float(np.median(ratios)), "x plain")]


def chains(effort: Effort, tick: _Tick) -> list[Figure]:
    """The proof of a whole composition."""
    return chain_proof()


def soundness_of_boxes(effort: Effort, tick: _Tick) -> list[Figure]:
    """Random boxes about critical points, boundaries and goals of varied worlds."""
    rng = np.random.default_rng(3)
    shares = np.diff(np.linspace(0, effort.boxes, effort.box_worlds + 1).astype(int))
    wrong = 0
    for i, count in enumerate(shares.tolist()):
        field, uncertainty = varied_world(rng, i)
        wrong += wrong_boxes(rng, field, count, uncertainty)
        tick((i + 1) / effort.box_worlds)
    return [
        Figure("soundness_boxes", effort.boxes, "", 1_000_000, "at least"),
        Figure("soundness_boxes_wrong", wrong, "", 0.0),
    ]


def soundness_of_proofs(effort: Effort, tick: _Tick) -> list[Figure]:
    """Roll-outs from anywhere in worlds that were proved, half of each kind.

    Kappa is uniform in 60..150: with less, few worlds of 20 obstacles have no trap.
    """
    rng = np.random.default_rng(4)
    lost = 0
    for i in range(effort.proved):
        field = _proved_world(rng, overlapping=i % 2 == 1)
        starts = free_points(rng, field, effort.starts)
        lost += int((~rollouts(starts, field, step=0.02).arrived).sum())
        tick((i + 1) / effort.proved)
    count = effort.proved * effort.starts
    return [
        Figure("soundness_roll_outs", count, "", 20_000, "at least"),
        Figure("soundness_roll_outs_lost", lost, "", 0.0),
    ]


def directions(effort: Effort, tick: _Tick) -> list[Figure]:
    """A batch of flow directions among 12 ellipses, on one core."""
    rng = np.random.default_rng(5)
    field = disjoint_world(rng, 12, 20.0)
    q = free_points(rng, field, effort.points)
    with one_core():
        ours = best_seconds(partial(flow_direction, q, field), effort.repeats)
        tick(0.3)
        plain = best_seconds(partial(numpy_field.flow_direction, q, field), 3)
    each = effort.points * len(field.obstacles)
    return [
        Figure("flow_direction", 1e9 * ours / each, "ns", 10.0),
        Figure("flow_direction_speedup", plain / ours, "x numpy"),
    ]


def roll_outs(effort: Effort, tick: _Tick) -> list[Figure]:
    """Roll-outs of 200 steps among 12 ellipses: one by one, and a batch."""
    rng = np.random.default_rng(6)
    field = disjoint_world(rng, 12, 20.0)
    starts = _long_starts(rng, field, effort.batch)
    few = starts[:20]

    def one_by_one() -> None:
        for start in few:
            rollout(start, field, step=_STEP, max_steps=_STEPS)

    single = best_seconds(one_by_one, effort.repeats) / len(few)
    batch = best_seconds(
        partial(rollouts, starts, field, step=_STEP, max_steps=_STEPS),
        effort.repeats,
    )
    tick(0.3)
    numpy_ends = partial(
        numpy_field.rollout_ends, field=field, step=_STEP, max_steps=_STEPS
    )
    plain_single = best_seconds(partial(numpy_ends, starts[:1]), 3)
    tick(0.6)
    plain_batch = seconds(partial(numpy_ends, starts))
    return [
        Figure("roll_out_200_steps", 1e6 * single, "us", 40.0),
        Figure("roll_out_200_steps_speedup", plain_single / single, "x numpy"),
        Figure("roll_out_batch_of_1000", 1e3 * batch, "ms", 25.0),
        Figure("roll_out_batch_of_1000_speedup", plain_batch / batch, "x numpy"),
    ]


def first_call(effort: Effort, tick: _Tick) -> list[Figure]:
    """First certificate, flow and roll-outs of a fresh interpreter."""
    cold, *warm = first_calls(3)
    return [
        Figure("first_call_cold", cold["call"], "s", 40.0),
        Figure("first_call_cold_cpu", cold["cpu"], "s"),
        Figure("first_call_warm", min(found["call"] for found in warm), "s", 1.0),
        Figure("first_call_warm_cpu", min(found["cpu"] for found in warm), "s"),
        Figure("import_of_numba", min(found["numba"] for found in warm), "s"),
    ]


def _prove(
    fields: list[NavigationField], repeats: int, tick: _Tick
) -> tuple[list[float], list[float], list[str]]:
    """Of each field's proof: median seconds by the clock and by the CPU, verdict."""
    certify(fields[0])
    times: list[float] = []
    cpu: list[float] = []
    verdicts: list[str] = []
    for i, field in enumerate(fields):
        taken = np.empty((repeats, 2))
        for k in range(repeats):
            clock, work = time.perf_counter(), time.process_time()
            found = certify(field)
            taken[k] = time.perf_counter() - clock, time.process_time() - work
        times.append(float(np.median(taken[:, 0])))
        cpu.append(float(np.median(taken[:, 1])))
        verdicts.append(found.verdict)
        tick((i + 1) / len(fields))
    return times, cpu, verdicts


def _proved_world(rng: np.random.Generator, overlapping: bool) -> NavigationField:
    while True:
        kappa = rng.uniform(60.0, 150.0)
        if overlapping:
            field = overlapping_world(rng, 20, kappa)
        else:
            field = disjoint_world(rng, 12, kappa)
        if certify(field).passed:
            return field


def _long_starts(
    rng: np.random.Generator, field: NavigationField, count: int
) -> FloatArray:
    """Starts whose roll-outs take all their 200 steps, shape (count, 2)."""
    found = np.empty((0, 2))
    while len(found) < count:
        q = free_points(rng, field, count)
        counts = rollouts(q, field, step=_STEP, max_steps=_STEPS).counts
        found = np.concatenate([found, q[counts == _STEPS + 1]])
    return found[:count]
