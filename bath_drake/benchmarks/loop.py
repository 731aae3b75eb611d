"""`bath-drake bench loop`: how fast the loop runs, how well it tracks, how it presses.

Real-time factors are of one person, washing a moving back with depth and colour at 30
Hz, but for `ideal`: nothing is filmed there.
"""

import logging
from dataclasses import dataclass

from bath_drake.benchmarks.figures import Figure, Progress, Report
from bath_drake.benchmarks.ik_families import (
    Tracking,
    followed_by_pose,
    followed_by_velocity,
    washing_task,
)
from bath_drake.diagrams import build_reproduction
from bath_drake.scenario import Scenario, find_skill, load_scenario
from bath_drake.simulation import run as simulate
from bath_drake.simulation_log import SimulationLog
from bath_drake.skill_file import load_skill
from bath_drake.verification import evaluate

PERSON = "m_avg"
# s simulated for a real-time factor, and of washing for the inverse kinematics.
_TIMED, _FOLLOWED = 8.0, 6.0
Row = dict[str, str | float | bool]


@dataclass(frozen=True)
class Level:
    """One level of fidelity, and the real-time factor that is asked of it."""

    name: str
    scenario: str
    fidelity: str
    perception: str
    factor: float


LEVELS = (
    Level("ideal", "reproduction", "kinematic", "ideal", 5.0),
    Level("kinematic", "reproduction", "kinematic", "camera", 1.0),
    Level("dynamic", "reproduction", "dynamic", "camera", 0.7),
    Level("contact", "wash_contact", "contact", "camera", 0.5),
)


def run(progress: Progress) -> Report:
    """Measures all of it."""
    # Drake tells of every collision checker's threads.
    logging.getLogger("drake").setLevel(logging.WARNING)
    parts = len(LEVELS) + 3
    rows: list[Row] = []
    figures: list[Figure] = []
    for k, level in enumerate(LEVELS):
        progress(level.name, k / parts)
        factor = real_time_factor(level)
        rows.append({"row": level.name, "real-time factor": factor})
        figures.append(
            Figure(f"loop_{level.name}_factor", factor, "", level.factor, "at least")
        )
    progress("tracking", len(LEVELS) / parts)
    figures += _tracking_figures(_washed(load_scenario("bending")))
    progress("force", (len(LEVELS) + 1) / parts)
    figures += _force_figures(_washed(load_scenario("wash_contact")))
    progress("inverse kinematics", (len(LEVELS) + 2) / parts)
    for name, tracking in ik_families().items():
        rows.append(
            {
                "row": name,
                "mean, mm": 1e3 * tracking.mean,
                "max, mm": 1e3 * tracking.greatest,
                "ms a step": tracking.milliseconds,
                "rad/s^2": tracking.acceleration,
            }
        )
        figures += [
            Figure(f"ik_{name}_mean", 1e3 * tracking.mean, "mm"),
            Figure(f"ik_{name}_max", 1e3 * tracking.greatest, "mm"),
            Figure(f"ik_{name}_step", tracking.milliseconds, "ms"),
            Figure(f"ik_{name}_acceleration", tracking.acceleration, "rad/s^2"),
        ]
    progress("done", 1.0)
    return Report(figures, rows)


def timed_scenario(level: Level) -> Scenario:
    """Returns what is run for a level's real-time factor."""
    scenario = load_scenario(level.scenario)
    scenario.scene.person = PERSON
    scenario.scene.arm.fidelity = level.fidelity
    scenario.perception.source = level.perception
    scenario.duration = _TIMED
    return scenario


def real_time_factor(level: Level) -> float:
    """Returns simulated by wall-clock seconds, of the second of two runs.

    In the first, a process loads what is compiled.
    """
    _run(timed_scenario(level))
    _, log = _run(timed_scenario(level))
    return log.real_time_factor


def ik_families() -> dict[str, Tracking]:
    """Follows one task of a bending back with each of Drake's two families."""
    scenario = load_scenario("bending")
    scenario.scene.person = PERSON
    task = washing_task(scenario, _FOLLOWED)
    return {
        "by_velocity": followed_by_velocity(task, scenario),
        "by_pose": followed_by_pose(task, scenario, collisions=False),
        "by_pose_and_collisions": followed_by_pose(task, scenario, collisions=True),
    }


def _run(scenario: Scenario) -> tuple[dict[str, object], SimulationLog]:
    skill = load_skill(find_skill(scenario.skill))
    log = simulate(build_reproduction(scenario, skill), scenario)
    return evaluate(log, scenario, skill).metrics, log


def _washed(scenario: Scenario) -> dict[str, object]:
    scenario.scene.person = PERSON
    metrics, _ = _run(scenario)
    return metrics


def _number(value: object, key: str) -> float:
    """A value of a block of the metrics; NaN where there is none."""
    found = value.get(key) if isinstance(value, dict) else None
    return float("nan") if found is None else float(found)


def _tracking_figures(metrics: dict[str, object]) -> list[Figure]:
    error, normal = metrics["surface_error_mm"], metrics["normal_error_deg"]
    return [
        Figure("loop_tracking_mean", _number(error, "mean"), "mm", 1.5),
        Figure("loop_tracking_max", _number(error, "max"), "mm", 5.0),
        Figure("loop_normal_mean", _number(normal, "mean"), "deg", 5.0),
    ]


def _force_figures(metrics: dict[str, object]) -> list[Figure]:
    force, touched = metrics["force"], metrics["touched_skin_mm"]
    within, held = _number(force, "within_2_n"), _number(force, "contact_share")
    passed = float(metrics["verdict"] == "pass")
    return [
        Figure("loop_force_mean_error", _number(force, "mean_error"), "N", 0.5),
        Figure("loop_force_within_2_n", within, "", 0.99, "at least"),
        Figure("loop_force_peak", _number(force, "peak"), "N", 10.0),
        Figure("loop_contact_share", held, "", 0.98, "at least"),
        Figure("loop_touched_skin_mean", _number(touched, "mean"), "mm", 2.0),
        Figure("loop_wash_passes", passed, "", 1.0, "at least"),
    ]
