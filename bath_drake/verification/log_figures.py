"""Figures of a run that its log alone tells, no truth: fields, proofs, holds."""

from typing import Any

import numpy as np

from bath_drake.control.certified_world import CertifiedWorld, WorldVerdict
from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.field.parameters import unpack_field
from bath_drake.learning.skill import Skill
from bath_drake.notation import FloatArray, IntArray
from bath_drake.reach.kinematics import ArmModel
from bath_drake.safety.limits import JOINTS
from bath_drake.safety.reasons import Mode, Reason
from bath_drake.scenario import Scenario
from bath_drake.simulation_log import SimulationLog


def stage_figures(log: SimulationLog, skill: Skill) -> dict[str, int]:
    """How many fields the skill's chain has, and how many the motion came to."""
    return {"count": len(skill.chain), "reached": int(log.stage.max()) + 1}


def driven_world(log: SimulationLog) -> NavigationField:
    """Returns the field the run ended in, its sensed areas included."""
    return unpack_field(log.keyframe_world[-1])


def certificate_figures(log: SimulationLog, world: CertifiedWorld) -> dict[str, Any]:
    """The verdict on the world that was driven in: sensed areas make another one."""
    areas = np.count_nonzero(log.keyframe_areas[:, 0] == len(log.keyframe_time) - 1)
    certificate = world.certificate
    # The guard hears of a world at its next tick, two of which are a sample.
    moving = log.guard_mode[1:] == Mode.PASS
    unproved = log.certificate_verdict[:-1] != WorldVerdict.PROVED
    return {
        "verdict": certificate.verdict,
        "reason": certificate.reason,
        "covers": "all free space" if certificate.region is None else "this start",
        "world": "skill and sensed areas" if areas else "skill",
        "sensed_areas": int(areas),
        "samples_moved_unproved": int(np.count_nonzero(moving & unproved)),
        "proofs": len(_proof_times(log)),
        "proof_seconds": mean_max(_proof_times(log)),
    }


def _proof_times(log: SimulationLog) -> FloatArray:
    """What each certificate of the run took, s."""
    known = log.certificate_seconds[log.certificate_verdict != WorldVerdict.UNKNOWN]
    # No two proofs take the same time to the last bit; one stays until the next.
    fresh = np.append(True, np.diff(known) != 0.0)[: len(known)]
    return np.asarray(known[fresh])


def least_betas(log: SimulationLog, washing: IntArray) -> dict[str, float | None]:
    """The least beta of all that were met at samples (n,) of the log; None of none.

    `min_beta` is the washed point's, which trails the reference and may cut a virtual
    obstacle's corner; `min_beta_reference` that of where the field is asked.
    """
    # Each point in the world that was driven in then.
    at = np.searchsorted(log.world_time, log.time[washing], side="right") - 1
    # Virtual obstacles shape the discrete motion; cycles on it may cross them.
    followed = (log.canonical_position - log.canonical_offset)[washing]
    worlds = {k: unpack_field(log.worlds[k]) for k in np.unique(at)}

    def least_of(points: FloatArray) -> float | None:
        met = [min_beta(points[at == k], world).min() for k, world in worlds.items()]
        return float(min(met)) if met else None

    return {
        "min_beta": least_of(followed),
        "min_beta_reference": least_of(log.canonical_reference[washing]),
    }


def guard_seconds(log: SimulationLog) -> dict[str, float]:
    """For how long the joint guard let nothing pass, s, by its reasons."""
    step = float(np.median(np.diff(log.time))) if len(log.time) > 1 else 0.0
    seconds = {
        reason.name.lower(): round(step * int((log.guard_reason == reason).sum()), 3)
        for reason in Reason
        if reason is not Reason.NONE
    }
    return {name: time for name, time in seconds.items() if time > 0.0}


def hold_counts(log: SimulationLog) -> dict[str, int]:
    """How often the joint guard began to let nothing pass, by its reasons."""
    return {
        reason.name.lower(): int(count)
        for reason, count in zip(Reason, log.guard_counts, strict=True)
        if reason is not Reason.NONE
    }


def following_error(log: SimulationLog) -> FloatArray:
    """The most that a joint was off what the guard had emitted, (T,), rad."""
    off = log.arm_state[:, :JOINTS] - log.checked_command[:, :JOINTS]
    return np.asarray(np.abs(off).max(axis=1))


def nozzle_jerk(log: SimulationLog, scenario: Scenario) -> FloatArray:
    """The jerk's size of the nozzle's tip, as the guard emitted it, (T - 3,), m/s^3.

    Mean ones over the log's steps: third differences of places.
    """
    if len(log.time) < 4:
        return np.zeros(0)
    arm = ArmModel.of(scenario.scene.arm)
    step = float(np.median(np.diff(log.time)))
    tips = np.array([arm.nozzle(row[:JOINTS])[0] for row in log.checked_command])
    return np.asarray(np.linalg.norm(np.diff(tips, 3, axis=0), axis=1) / step**3)


def least(values: FloatArray | None) -> float | None:
    """Returns the least of values (n,); None of none."""
    return float(np.min(values)) if values is not None and len(values) else None


def most(values: FloatArray) -> float | None:
    """Returns the greatest of values (n,); None of none."""
    return float(np.max(values)) if len(values) else None


def mean_max(values: FloatArray) -> dict[str, float | None]:
    """Returns mean and greatest of values (n,), each None of none."""
    if not len(values):
        return {"mean": None, "max": None}
    return {"mean": float(np.mean(values)), "max": float(np.max(values))}
