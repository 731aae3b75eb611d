"""The soak's episodes: a random stroke, motion, areas, starts and faults.

Those of one sitting share person, stroke, motion, given areas, and the Diagram.
"""

import ctypes
import gc
import resource
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.diagrams import build_reproduction
from bath_drake.faults.script import AreaFault, SignalFault
from bath_drake.notation import FloatArray
from bath_drake.patient.motion import MotionConfig
from bath_drake.perception.faults import (
    BlankFault,
    CoveredFault,
    FrameFault,
    LateFault,
)
from bath_drake.safety.limits import load_limits
from bath_drake.safety.reasons import Mode
from bath_drake.scenario import Scenario, find_skill
from bath_drake.simulation import run
from bath_drake.simulation_log import SimulationLog
from bath_drake.skill_file import load_skill
from bath_drake.verification import evaluate

SKILLS = ("back_sinusoid.yaml", "figure_eight.yaml", "scrubbing.yaml")
# Of one sitting: episodes, and the longest of them, s.
EPISODES, LONGEST = 12, 20.0
# How far a start is from the skill's own, each way, in N.
START_REACH = 0.1
# Ports that break, and how far an offset of theirs may be.
_SIGNALS = {
    "navigation_controller.canonical_velocity": 2.0,
    "differential_ik.joint_command": 0.3,
    "differential_ik.ik_status": 1.0,
    "surface_reference.surface_status": 1.0,
    "surface_reference.surface_normal": 1.0,
    "canonical_projector.map_status": 1.0,
    "force_sensor.wrench": 40.0,
    "arm_link.robot_stamp": 1.0,
    "arm_link.loop_seconds": 0.1,
}
_ROUNDING = 1e-6
SHORTEST = 0.5  # s, what rounding leaves is no episode
_STARTS = 1  # what a generator is for


@dataclass(frozen=True)
class Episode:
    """What came of one.

    Attributes:
        sitting: The sitting's number, of one body.
        index: Its own, of the sitting.
        runs_before: How many its process had run by then.
        seconds: Simulated, s.
        outcome: Name of a `bath_drake.safety.outcome.LoopOutcome`.
        passed: Share of the samples at which commands passed.
        entries: How often the washed point went into a restricted area.
        not_finite: Samples with anything that is no number behind the guard.
        too_fast: Samples with a joint faster than the limits.
        memory: Of the process by then, MB.
    """

    sitting: int
    index: int
    runs_before: int
    seconds: float
    outcome: str
    passed: float
    entries: int
    not_finite: int
    too_fast: int
    memory: float


def sitting_scenario(person: str, number: int, *, ideal: bool) -> Scenario:
    """Returns a random scenario, the same for the same arguments.

    Its episodes follow each other `LONGEST` apart, each with faults of its own.

    Args:
        person: Who is washed.
        number: Of the sitting, from 0.
        ideal: Whether perception asks the true skin and the arm follows exactly.
    """
    rng = _generator(person, number, ideal)
    scenario = Scenario(
        duration=LONGEST,
        random_seed=int(rng.integers(2**31)),
        skill=str(rng.choice(SKILLS)),
    )
    scenario.scene.person = person
    scenario.scene.motion = _motion(rng)
    scenario.perception.restricted_areas = _areas(rng)
    for index in range(EPISODES):
        begin = index * LONGEST
        scenario.faults.signals += _signals(rng, begin)
        if rng.random() < 0.3:
            scenario.faults.areas.append(_area_fault(rng, begin))
    if ideal:
        scenario.perception.source = "ideal"
        scenario.scene.arm.fidelity = "kinematic"
    else:
        scenario.scene.camera.noise = "kinect_v2"
        _break_camera(rng, scenario)
    return scenario


def run_sitting(
    person: str,
    number: int,
    *,
    ideal: bool,
    first: int = 0,
    seconds: float = float("inf"),
) -> Iterator[Episode]:
    """Runs a sitting's episodes, one Diagram for all; see `sitting_scenario`.

    A process is better not used for another: a Diagram that holds Systems written in
    Python is never freed by some versions of Drake.

    Args:
        person: Who is washed.
        number: Of the sitting.
        ideal: As in `sitting_scenario`.
        first: The episode to begin with.
        seconds: To be simulated in all: what is over when they are is not begun.
    """
    scenario = sitting_scenario(person, number, ideal=ideal)
    skill = load_skill(find_skill(scenario.skill))
    diagram = build_reproduction(scenario, skill)
    rng = _generator(person, number, ideal, _STARTS)
    starts = skill.start + rng.uniform(-START_REACH, START_REACH, (EPISODES, 2))
    for index in range(first, EPISODES):
        if seconds < SHORTEST:
            return
        scenario.duration = min(LONGEST, seconds)
        context = diagram.CreateDefaultContext()
        context.SetTime(index * LONGEST)
        reference: Any = diagram.GetSubsystemByName("canonical_reference")
        reference.set_start(
            reference.GetMyMutableContextFromRoot(context), starts[index]
        )
        log = run(diagram, scenario, context=context)
        entries = evaluate(log, scenario, skill).metrics["restricted_entries"]
        episode = _judged(log, number, index, index - first, int(entries))
        # An episode's own log is no growth: it goes with the next, and is as long as
        # the episode.
        del log, context, reference
        episode = replace(episode, memory=_memory())
        seconds -= episode.seconds
        yield episode


def _judged(
    log: SimulationLog, sitting: int, index: int, runs_before: int, entries: int
) -> Episode:
    emitted = log.checked_command
    speeds: FloatArray = np.abs(emitted[:, 7:])
    allowed = np.array(load_limits().joints.velocity) + _ROUNDING
    return Episode(
        sitting=sitting,
        index=index,
        runs_before=runs_before,
        seconds=float(np.ptp(log.time)),
        outcome=log.outcome,
        passed=float(np.mean(log.guard_mode == Mode.PASS)),
        entries=entries,
        not_finite=int(np.count_nonzero(~np.isfinite(emitted).all(axis=1))),
        too_fast=int(np.count_nonzero((speeds > allowed).any(axis=1))),
        memory=float("nan"),
    )


def _generator(
    person: str, number: int, ideal: bool, purpose: int = 0
) -> np.random.Generator:
    # Not by `hash`: that is another one in every process.
    return np.random.default_rng([number, *person.encode(), int(ideal), purpose])


def as_row(episode: Episode) -> dict[str, int | float | str]:
    """Returns an episode for JSON."""
    return asdict(episode)


def _memory() -> float:
    """What this process holds now, MB; where that cannot be told, at most so far.

    What it has freed is given back first, where the C library can: an allocator keeps
    some of it for later, more after a longer run, and that is no growth.
    """
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
    try:
        pages = int(Path("/proc/self/statm").read_text("ascii").split()[1])
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return pages * resource.getpagesize() / 2**20


def _motion(rng: np.random.Generator) -> MotionConfig:
    turn = np.pi
    return MotionConfig(
        breath_frequency=float(rng.uniform(0.15, 0.4)),
        twist_amplitude=float(np.radians(rng.uniform(0.0, 8.0))),
        lean_amplitude=float(np.radians(rng.uniform(0.0, 6.0))),
        twist_phase=float(rng.uniform(-turn, turn)),
        lean_phase=float(rng.uniform(-turn, turn)),
        flexion_amplitude=float(np.radians(rng.uniform(0.0, 6.0))),
        side_bend_amplitude=float(np.radians(rng.uniform(0.0, 4.0))),
        spine_twist_amplitude=float(np.radians(rng.uniform(0.0, 8.0))),
    )


def _areas(rng: np.random.Generator) -> list[list[list[float]]]:
    areas = []
    for _ in range(rng.integers(0, 3)):
        x, y = rng.uniform(-0.7, 0.7, 2)
        w, h = rng.uniform(0.05, 0.15, 2)
        corners = [[x - w, y - h], [x + w, y - h], [x + w, y + h], [x - w, y + h]]
        areas.append([[float(u), float(v)] for u, v in corners])
    return areas


def _signals(rng: np.random.Generator, begin: float) -> list[SignalFault]:
    count = int(rng.integers(0, 3))
    faults = []
    for port in rng.choice(list(_SIGNALS), count, replace=False):
        starts = begin + float(rng.uniform(0.0, LONGEST))
        kinds = ("nan", "constant", "offset", "frozen")
        lasts = float(rng.uniform(0.05, 2.0))
        faults.append(
            SignalFault(
                port=str(port),
                kind=str(rng.choice(kinds)),
                value=float(_SIGNALS[str(port)] * rng.uniform(-1.0, 1.0)),
                begin=starts,
                # Over with its episode: the next may have one of the same port.
                end=min(starts + lasts, begin + LONGEST),
            )
        )
    return faults


def _area_fault(rng: np.random.Generator, begin: float) -> AreaFault:
    starts = begin + float(rng.uniform(0.0, LONGEST))
    return AreaFault(
        centre=rng.uniform(-0.3, 0.3, 2).tolist(),
        semi_axes=rng.uniform(0.05, 0.2, 2).tolist(),
        from_tool=bool(rng.random() < 0.5),
        velocity=rng.uniform(-0.2, 0.2, 2).tolist(),
        begin=starts,
        end=min(starts + 3.0, begin + LONGEST),
    )


def _break_camera(rng: np.random.Generator, scenario: Scenario) -> None:
    """Each kind of fault once, in an episode of its own."""
    faults = scenario.scene.camera.faults
    episodes = rng.choice(EPISODES, 5, replace=False)
    spells = []
    for episode in episodes:
        begin = float((episode + rng.random()) * LONGEST)
        spells.append((begin, begin + float(rng.uniform(0.05, 1.0))))
    loss, late, frozen, blank, covered = spells
    faults.loss = FrameFault(begin=loss[0], end=loss[1])
    faults.late = LateFault(begin=late[0], end=late[1])
    faults.frozen = FrameFault(begin=frozen[0], end=frozen[1])
    faults.blank = BlankFault(begin=blank[0], end=blank[1])
    faults.covered = CoveredFault(begin=covered[0], end=covered[1])
