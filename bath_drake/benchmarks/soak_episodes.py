"""One episode of the soak: a random body, stroke, motion, areas and faults."""

import resource
from dataclasses import asdict, dataclass
from pathlib import Path

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
from bath_drake.skill_file import load_skill
from bath_drake.verification import evaluate

SKILLS = ("back_sinusoid.yaml", "figure_eight.yaml", "scrubbing.yaml")
LONGEST = 20.0  # s
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


@dataclass(frozen=True)
class Episode:
    """What came of one.

    Attributes:
        index: Its number, of one body.
        seconds: Simulated, s.
        outcome: Name of a `bath_drake.safety.outcome.LoopOutcome`.
        passed: Share of the samples at which commands passed.
        entries: How often the washed point went into a restricted area.
        not_finite: Samples with anything that is no number behind the guard.
        too_fast: Samples with a joint faster than the limits.
        memory: Of the process by then, MB.
    """

    index: int
    seconds: float
    outcome: str
    passed: float
    entries: int
    not_finite: int
    too_fast: int
    memory: float


def episode_scenario(
    person: str, index: int, seconds: float, *, ideal: bool
) -> Scenario:
    """Returns a random scenario, the same for the same arguments.

    Args:
        person: Who is washed.
        index: Of the episode, from 0.
        seconds: Longest run, s.
        ideal: Whether perception asks the true skin and the arm follows exactly.
    """
    # Not by `hash`: that is another one in every process.
    rng = np.random.default_rng([index, *person.encode(), int(ideal)])
    scenario = Scenario(
        duration=seconds,
        random_seed=int(rng.integers(2**31)),
        skill=str(rng.choice(SKILLS)),
    )
    scenario.scene.person = person
    scenario.scene.motion = _motion(rng)
    scenario.perception.restricted_areas = _areas(rng)
    scenario.faults.signals = _signals(rng, seconds)
    if rng.random() < 0.3:
        begin = float(rng.uniform(0.0, seconds))
        scenario.faults.areas = [
            AreaFault(
                centre=rng.uniform(-0.3, 0.3, 2).tolist(),
                semi_axes=rng.uniform(0.05, 0.2, 2).tolist(),
                from_tool=bool(rng.random() < 0.5),
                velocity=rng.uniform(-0.2, 0.2, 2).tolist(),
                begin=begin,
                end=begin + 3.0,
            )
        ]
    if ideal:
        scenario.perception.source = "ideal"
        scenario.scene.arm.fidelity = "kinematic"
    else:
        scenario.scene.camera.noise = "kinect_v2"
        _break_camera(rng, scenario, seconds)
    return scenario


def run_episode(person: str, index: int, seconds: float, *, ideal: bool) -> Episode:
    """Runs one; see `episode_scenario`."""
    scenario = episode_scenario(person, index, seconds, ideal=ideal)
    skill = load_skill(find_skill(scenario.skill))
    log = run(build_reproduction(scenario, skill), scenario)
    emitted = log.checked_command
    speeds: FloatArray = np.abs(emitted[:, 7:])
    allowed = np.array(load_limits().joints.velocity) + _ROUNDING
    return Episode(
        index=index,
        seconds=float(log.time[-1]),
        outcome=log.outcome,
        passed=float(np.mean(log.guard_mode == Mode.PASS)),
        entries=int(evaluate(log, scenario, skill).metrics["restricted_entries"]),
        not_finite=int(np.count_nonzero(~np.isfinite(emitted).all(axis=1))),
        too_fast=int(np.count_nonzero((speeds > allowed).any(axis=1))),
        memory=_memory(),
    )


def as_row(episode: Episode) -> dict[str, int | float | str]:
    """Returns an episode for JSON."""
    return asdict(episode)


def _memory() -> float:
    """What this process holds now, MB; where that cannot be told, at most so far."""
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


def _signals(rng: np.random.Generator, seconds: float) -> list[SignalFault]:
    count = int(rng.integers(0, 3))
    faults = []
    for port in rng.choice(list(_SIGNALS), count, replace=False):
        begin = float(rng.uniform(0.0, seconds))
        kinds = ("nan", "constant", "offset", "frozen")
        faults.append(
            SignalFault(
                port=str(port),
                kind=str(rng.choice(kinds)),
                value=float(_SIGNALS[str(port)] * rng.uniform(-1.0, 1.0)),
                begin=begin,
                end=begin + float(rng.uniform(0.05, 2.0)),
            )
        )
    return faults


def _break_camera(rng: np.random.Generator, scenario: Scenario, seconds: float) -> None:
    begin = float(rng.uniform(0.0, seconds))
    end = begin + float(rng.uniform(0.05, 1.0))
    faults = scenario.scene.camera.faults
    broken = rng.integers(0, 6)
    if broken == 0:
        faults.loss = FrameFault(begin=begin, end=end)
    elif broken == 1:
        faults.late = LateFault(begin=begin, end=end)
    elif broken == 2:
        faults.frozen = FrameFault(begin=begin, end=end)
    elif broken == 3:
        faults.blank = BlankFault(begin=begin, end=end)
    elif broken == 4:
        faults.covered = CoveredFault(begin=begin, end=end)
