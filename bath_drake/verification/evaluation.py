"""Judges a run against the truth: the person's own mesh and the demonstration."""

import importlib.metadata
import platform
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform

from bath_drake import __version__
from bath_drake.composition.rollout import chain_rollout
from bath_drake.control.approach import Phase
from bath_drake.control.certified_world import (
    CertifiedWorld,
    certify_world,
)
from bath_drake.faults.expectation import judge_reaction
from bath_drake.faults.touch import area_touches
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.skill import Skill
from bath_drake.notation import FloatArray, IntArray
from bath_drake.patient.people import Person, load_person
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.skin_segments import segmented_skin
from bath_drake.patient.touched_skin import touched_skin_error
from bath_drake.patient.washed_skin import tracking_lag, washed_skin
from bath_drake.patient.wound import signed_polygon_distance, wound_patch
from bath_drake.perception.frame_delivery import dropped_frames
from bath_drake.rhythm.washed import washed_cycles
from bath_drake.safety.outcome import LoopOutcome
from bath_drake.scenario import Scenario
from bath_drake.simulation_log import SimulationLog
from bath_drake.strokes import is_strung, planned_strokes
from bath_drake.systems._ports import drake_vector
from bath_drake.verification.force_figures import force_figures, normal_force
from bath_drake.verification.limit_checks import fault_checks, limit_checks
from bath_drake.verification.log_figures import (
    certificate_figures,
    driven_world,
    following_error,
    guard_seconds,
    hold_counts,
    least,
    least_betas,
    mean_max,
    most,
    nozzle_jerk,
    stage_figures,
)
from bath_drake.washing.config import washing_tool
from bath_drake.washing.outcome import WashOutcome, wash_outcome
from bath_drake.washing.places import back_places
from bath_drake.washing.washed_places import washed_seconds

# Samples of the log between looks at the touched skin: 0.1 s.
_TOUCHED_EVERY = 10


@dataclass(frozen=True, eq=False, kw_only=True)
class Evaluation:
    """What a run came to; the series run from the first stand-off to its end.

    Attributes:
        metrics: The content of metrics.json.
        time: (n,) s.
        surface_error_mm: (n,) nozzle to true skin, less the stand-off.
        normal_error_deg: (n,) nozzle axis against the true normal.
        speed: (n,) of the washed point along the skin, m/s.
        executed: (n, 2) washed points in true canonical space.
        offsets: (n, 2) of them the periodic motion that was asked for; zero without.
        around: (n, 2) washed points seen from the discrete motion's reference.
        washed_points_M: (n, 3) washed points of the true skin, where they are in M
            while the person is at rest, m.
        normals_M: (n, 3) true outward normals there.
        clearance_mm: (n,) washed point to the nearest wound along the back, less
            than zero inside one; None without wounds and given areas.
        wound_polygons_N: Outlines (m, 2) of wounds and given areas, in true N.
        mean_demonstration: (T, 2) of the skill's demonstrations.
        rollout: (T, 2) of the skill, no simulator.
        world: The world the run ended in, certified anew.
        wash: The skin that jet or sponge reached.
    """

    metrics: dict[str, Any]
    time: FloatArray
    surface_error_mm: FloatArray
    normal_error_deg: FloatArray
    speed: FloatArray
    executed: FloatArray
    offsets: FloatArray
    around: FloatArray
    washed_points_M: FloatArray
    normals_M: FloatArray
    clearance_mm: FloatArray | None
    wound_polygons_N: list[FloatArray]
    mean_demonstration: FloatArray
    rollout: FloatArray
    world: CertifiedWorld
    wash: WashOutcome


def pose_from_row(row: FloatArray) -> RigidTransform:
    """Returns the pose of a row (7,): quaternion w, x, y, z and position."""
    quaternion = Quaternion(drake_vector(row[:4] / np.linalg.norm(row[:4])))
    return RigidTransform(quaternion, drake_vector(row[4:]))


def wound_outlines(scenario: Scenario, person: Person) -> list[FloatArray]:
    """Returns the outlines (m, 3) in M of the wounds on the true skin."""
    wound = scenario.scene.wound
    if wound is None:
        return []
    centre, semi_axes = np.array(wound.centre), np.array(wound.semi_axes)
    return [wound_patch(person, centre, semi_axes, wound.angle).outline]


def evaluate(log: SimulationLog, scenario: Scenario, skill: Skill) -> Evaluation:
    """Measures a run and judges it by the scenario's limits."""
    person = load_person(scenario.scene.person)
    skin = TrueSkin(person)
    washing = np.flatnonzero(log.phase == Phase.WASH)
    time = log.time[washing]
    nozzle, jet, before = _nozzle_in_mesh(log, washing)
    washed = washed_skin(skin, scenario.scene.motion, time, nozzle, jet, before)
    distance, met, hits = washed.distance, washed.met, washed.resting
    cosine = np.clip(-(jet * washed.normals).sum(axis=1), -1.0, 1.0)
    executed = skin.canonical_map.canonical_from_world(hits)
    offsets = log.canonical_offset[washing][met]
    reference = log.canonical_reference[washing][met]
    outlines = [
        skin.canonical_map.plane_from_world(outline)[:, :2]
        for outline in wound_outlines(scenario, person)
    ]
    half = skin.canonical_map.half_extents
    outlines += [
        np.array(corners) * half for corners in scenario.perception.restricted_areas
    ]
    clearance = _clearance(skin.canonical_map.plane_from_world(hits)[:, :2], outlines)
    path = chain_rollout(skill.start, skill.chain).path
    places = back_places(skin, scenario.washing.pitch)
    wash = wash_outcome(
        places,
        washed_seconds(
            skin,
            places,
            scenario.scene.motion,
            time,
            nozzle,
            jet,
            washing_tool(scenario.washing),
        ),
        scenario.washing,
        stroke=skill.mean_demonstration,
        half_extents=half,
        wounds=outlines,
        spared=_spared(scenario),
    )
    # In contact the stand-off asked for is where the face would be, were it hard.
    surface_error = (distance - log.standoff[washing]) * 1e3
    normal_error = np.degrees(np.arccos(cosine))
    speed = _speed(time[met], hits)
    world = certify_world(driven_world(log), log.certified_start[-1])
    touched_at, made_up_entries = area_touches(
        scenario.faults.areas,
        log.time,
        log.canonical_position,
        log.phase >= Phase.DESCEND,
    )
    force = touched = None
    if scenario.scene.arm.fidelity == "contact":
        force = force_figures(log, scenario.control.force)
        touched = _touched_skin(scenario, person, time, nozzle)
    metrics: dict[str, Any] = {
        "frechet": _frechet(skill, executed - offsets, path),
        "periodic": washed_cycles(skill.periodic, executed - reference, offsets),
        "stages": stage_figures(log, skill),
        "certificate": certificate_figures(log, world),
        "reached_goal": log.outcome == LoopOutcome.GOAL_REACHED.name,
        "outcome": log.outcome,
        "time_to_goal_s": float(np.ptp(log.time)),
        "washing_time_s": float(np.ptp(time)) if len(time) else 0.0,
        "surface_error_mm": mean_max(np.abs(surface_error)),
        "surface_lag_s": tracking_lag(surface_error / 1e3, washed.receded, time),
        "normal_error_deg": mean_max(normal_error),
        "standoff_or_force": mean_max(
            distance if force is None else normal_force(log)[washing]
        ),
        "force": force,
        "touched_skin_mm": touched,
        "speed_m_per_s": mean_max(speed),
        "nozzle_jerk_m_per_s3": mean_max(nozzle_jerk(log, scenario)),
        "washed_off_the_body": int(np.count_nonzero(~met)),
        "restricted_entries": _entries(clearance) + made_up_entries,
        "restricted_min_clearance_mm": least(clearance),
        **least_betas(log, washing),
        "coverage": wash.coverage,
        "washing": {**wash.figures(), "strokes": len(planned_strokes(scenario)) or 1},
        "perception": scenario.perception.source,
        "frames": int(log.frames),
        "dropped_frames": dropped_frames(
            scenario.scene.camera.faults,
            seed=scenario.random_seed,
            period=1.0 / scenario.perception.camera_rate,
            count=int(log.frames),
        ),
        "rejected_frames": int(log.rejected_frames.max(initial=0.0)),
        "seen_through": most(log.seen_through),
        "following_error_rad": most(following_error(log)),
        "guard_s": guard_seconds(log),
        "holds": hold_counts(log),
        "robot_hides_at_most": most(log.keyframe_reach[:, 1]),
        "hidden_skin_quality_at_least": least(log.keyframe_reach[:, 2:].ravel()),
        "real_time_factor": log.real_time_factor,
        "versions": versions(),
        "seed": scenario.random_seed,
    }
    if scenario.expect is None:
        checks = limit_checks(metrics, scenario.limits)
    else:
        begins = scenario.expect.begins
        metrics["reaction"] = judge_reaction(
            scenario.expect,
            touched_at if begins is None else begins,
            time=log.time,
            mode=log.guard_mode,
            reason=log.guard_reason,
            emitted=log.checked_command,
        )
        checks = fault_checks(metrics, scenario.expect)
    passed = all(check["pass"] for check in checks.values())
    metrics = {"verdict": "pass" if passed else "fail", "checks": checks, **metrics}
    return Evaluation(
        metrics=metrics,
        time=time,
        surface_error_mm=surface_error,
        normal_error_deg=normal_error,
        speed=speed,
        executed=executed,
        offsets=offsets,
        around=executed - reference,
        washed_points_M=hits,
        normals_M=washed.resting_normals,
        clearance_mm=clearance,
        wound_polygons_N=[outline / half for outline in outlines],
        mean_demonstration=skill.mean_demonstration,
        rollout=path,
        world=world,
        wash=wash,
    )


def versions() -> dict[str, str]:
    """Returns the versions that a figure depends on."""
    packages = ("drake", "numpy", "numba", "open3d-cpu")
    found = {name: importlib.metadata.version(name) for name in packages}
    return {"bath_drake": __version__, "python": platform.python_version(), **found}


def _spared(scenario: Scenario) -> float:
    """How far around wounds skin is not to be washed, m."""
    if scenario.washing.spared is not None:
        return scenario.washing.spared
    return scenario.perception.area_margin


def _nozzle_in_mesh(
    log: SimulationLog, samples: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Nozzle tips and jet directions (n, 3) in frame M at the given samples.

    And where the tips of the sample before are then, for M has moved since.
    """
    tips, jets, before = (np.zeros((len(samples), 3)) for _ in range(3))
    for row, k in enumerate(samples):
        X_MW = pose_from_row(log.body_pose[k]).inverse()
        X_ME = X_MW.multiply(pose_from_row(log.nozzle_pose[k]))
        tips[row], jets[row] = X_ME.translation(), X_ME.rotation().col(2)
        p_WE = drake_vector(log.nozzle_pose[samples[max(row - 1, 0)], 4:])
        before[row] = X_MW.multiply(p_WE)
    return tips, jets, before


def _touched_skin(
    scenario: Scenario, person: Person, time: FloatArray, tips_M: FloatArray
) -> dict[str, float | None]:
    """How far the touched skin lies from the true one under the tool, mm."""
    motion = scenario.scene.motion
    some = slice(None, None, _TOUCHED_EVERY)
    mean, most = touched_skin_error(
        person,
        segmented_skin(person, bends=motion.bends),
        motion,
        time[some],
        tips_M[some],
    )
    if not len(mean):
        return {"mean": None, "max": None}
    # Off the slabs there is no skin to touch: then neither figure is a number.
    return {"mean": float(1e3 * mean.mean()), "max": float(1e3 * most.max())}


def _frechet(
    skill: Skill, executed: FloatArray, path: FloatArray
) -> dict[str, float | None]:
    def distance(a: FloatArray, b: FloatArray) -> float | None:
        if len(a) < 2:
            return None
        return discrete_frechet(a, b) / skill.scale

    return {
        # Of strokes strung together the mean is the plan, not a demonstration.
        "learned": (
            None if is_strung(skill) else distance(path, skill.mean_demonstration)
        ),
        "executed": distance(executed, skill.mean_demonstration),
        "executed_against_learned": distance(executed, path),
        "scale": skill.scale,
    }


def _clearance(points: FloatArray, outlines: list[FloatArray]) -> FloatArray | None:
    if not outlines:
        return None
    distances = [signed_polygon_distance(points, outline) for outline in outlines]
    return np.asarray(np.min(distances, axis=0) * 1e3)


def _entries(clearance: FloatArray | None) -> int:
    """How often the washed point went into a wound."""
    if clearance is None:
        return 0
    inside = np.concatenate([[False], clearance < 0.0])
    return int(np.count_nonzero(inside[1:] & ~inside[:-1]))


def _speed(time: FloatArray, points: FloatArray) -> FloatArray:
    if len(time) < 2:
        return np.zeros(len(time))
    return np.asarray(np.linalg.norm(np.gradient(points, time, axis=0), axis=1))
