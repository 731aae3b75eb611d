"""What the report is made of, read from a run's folder."""

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.composition.chain import Chain
from bath_drake.composition.rollout import chain_rollout
from bath_drake.control.approach import Phase
from bath_drake.control.staging import around_areas, gate_at
from bath_drake.demonstrations.canonical import CanonicalDemonstration
from bath_drake.demonstrations.processing import (
    canonical_demonstrations,
    without_strays,
)
from bath_drake.demonstrations.recording import read_recording
from bath_drake.errors import BathDrakeError, RunFolderError
from bath_drake.files import read_bytes
from bath_drake.learning.generalisation import (
    Generalisation,
    evaluate_generalisation,
)
from bath_drake.learning.skill import Skill
from bath_drake.notation import FloatArray
from bath_drake.report.keyframe import Keyframe
from bath_drake.scenario import Scenario, find_demonstration, load_scenario
from bath_drake.simulation_log import SimulationLog
from bath_drake.skill_file import load_skill
from bath_drake.verification import Evaluation, evaluate

FILES = ("scenario.yaml", "skill.yaml", "log.npz", "metrics.json")
_MAX_METRICS_BYTES = 4 * 1024 * 1024
_KEYS = ("verdict", "checks", "frechet", "versions", "seed", "holds")


@dataclass(frozen=True, eq=False, kw_only=True)
class RunData:
    """One run, as its folder tells it.

    Attributes:
        folder: Where it lies.
        scenario: What was asked for.
        skill: The learned motion.
        log: What happened.
        metrics: The content of metrics.json.
        evaluation: The series behind the figures of `metrics`.
        demonstrations: Those it was learned from; empty if not at hand.
    """

    folder: Path
    scenario: Scenario
    skill: Skill
    log: SimulationLog
    metrics: dict[str, Any]
    evaluation: Evaluation
    demonstrations: tuple[CanonicalDemonstration, ...] = ()

    @cached_property
    def keyframes(self) -> list[Keyframe]:
        """All frames that show a back."""
        frames = [Keyframe(self.log, k) for k in range(len(self.log.keyframe_time))]
        return [frame for frame in frames if frame.mask.sum() > 200]

    @cached_property
    def generalisation(self) -> Generalisation:
        """The skill's trials, beside the demonstrations or else their means."""
        paths = [demonstration.points for demonstration in self.demonstrations]
        return evaluate_generalisation(self.skill.branches, paths)

    @cached_property
    def main_keyframe(self) -> Keyframe | None:
        """The frame nearest to the middle of the washing."""
        washing = self.log.time[self.log.phase == Phase.WASH]
        if not self.keyframes:
            return None
        middle = float(np.median(washing if washing.size else self.log.time))
        return min(self.keyframes, key=lambda frame: abs(frame.time - middle))

    def path_until(self, time: float) -> FloatArray:
        """Washed points (n, 2) up to a time, in N as the loop saw it."""
        chosen = (self.log.phase == Phase.WASH) & (self.log.time <= time)
        return np.asarray(self.log.canonical_position[chosen])

    def path_from(self, frame: Keyframe) -> FloatArray:
        """The plan (n, 2) from where the nozzle was, in the world it was driven in."""
        done = self.path_until(frame.time)
        start = done[-1] if len(done) else self.skill.start
        return chain_rollout(start, self.chain_from(frame)).path

    def chain_from(self, frame: Keyframe) -> Chain:
        """The world that was driven in and, with the areas seen, those to come."""
        left = around_areas(self.skill.chain, frame.areas).rest(self.stage(frame))
        later = [field.with_obstacles(frame.areas) for field in left.fields[1:]]
        gates = list(left.gates)
        if gates and not gates[0].holds(frame.world.goal):
            # The loop moved the goal for the areas as it allows for them, with slack.
            gates[0] = gate_at(frame.world.goal, gates[0])
        return Chain((frame.world, *later), tuple(gates))

    def stage(self, frame: Keyframe) -> int:
        """Which field of the chain was followed then."""
        at = int(np.searchsorted(self.log.time, frame.time, side="right")) - 1
        return int(self.log.stage[max(at, 0)])


def load_run(folder: Path) -> RunData:
    """Reads a run's folder and evaluates its log anew.

    Raises:
        RunFolderError: If a file is missing or damaged, naming it.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise RunFolderError(f"{folder}: no such folder, expected that of a run")
    for name in FILES:
        if not (folder / name).is_file():
            raise RunFolderError(
                f"{folder / name}: missing; a run folder holds {', '.join(FILES)}"
            )
    metrics = _read_metrics(folder / "metrics.json")
    log = SimulationLog.load(folder / "log.npz")
    try:
        scenario = load_scenario(folder / "scenario.yaml")
        skill = load_skill(folder / "skill.yaml")
        evaluation = evaluate(log, scenario, skill)
        demonstrations = _demonstrations(scenario, skill)
    except RunFolderError:
        raise
    except BathDrakeError as error:
        raise RunFolderError(str(error)) from error
    return RunData(
        folder=folder,
        scenario=scenario,
        skill=skill,
        log=log,
        metrics=metrics,
        evaluation=evaluation,
        demonstrations=demonstrations,
    )


def _read_metrics(path: Path) -> dict[str, Any]:
    data = read_bytes(path, limit=_MAX_METRICS_BYTES, error=RunFolderError)
    try:
        metrics = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise RunFolderError(f"{path}: not JSON ({error})") from error
    if not isinstance(metrics, dict):
        raise RunFolderError(f"{path}: found {type(metrics).__name__}, expected object")
    missing = [key for key in _KEYS if key not in metrics]
    if missing:
        raise RunFolderError(f"{path}: lacks {', '.join(missing)}")
    return metrics


def _demonstrations(
    scenario: Scenario, skill: Skill
) -> tuple[CanonicalDemonstration, ...]:
    """The recordings, if those the skill was learned from are still there."""
    paths = [find_demonstration(name) for name in scenario.demonstrations]
    if not paths or not all(path.is_file() for path in paths):
        return ()
    found, _ = canonical_demonstrations([read_recording(p) for p in paths])
    demonstrations = without_strays(found)
    if {d.sha256 for d in demonstrations} != set(skill.demonstration_hashes):
        return ()
    return demonstrations
