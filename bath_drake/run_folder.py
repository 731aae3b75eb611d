"""A run's folder: simulate into it, so that each later step can start from it."""

import json
from pathlib import Path
from typing import Any

from pydrake.geometry import Meshcat

from bath_drake.diagrams import build_reproduction
from bath_drake.errors import RunFolderError
from bath_drake.files import remove, write_atomically
from bath_drake.learning.skill import Skill
from bath_drake.meshcat.skin import BackPose, record_skin
from bath_drake.meshcat.view import record_overlays, write_static_page
from bath_drake.report.page import write_report
from bath_drake.scenario import Scenario, dump_scenario
from bath_drake.simulation import Progress, run
from bath_drake.skill_file import save_skill
from bath_drake.systems.frame_recorder import WriteFrame
from bath_drake.verification import Evaluation, evaluate

SCENARIO, SKILL, LOG = "scenario.yaml", "skill.yaml", "log.npz"
METRICS, REPORT, PAGE = "metrics.json", "report.html", "meshcat.html"


def make_run_folder(folder: Path) -> None:
    """Makes the folder, its parents included; RunFolderError if it cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".writable"
        probe.touch()
        probe.unlink()
    except OSError as error:
        reason = error.strerror or str(error)
        raise RunFolderError(f"{folder}: not a folder to write to ({reason})") from None


def simulate_into(
    folder: Path,
    scenario: Scenario,
    skill: Skill,
    *,
    meshcat: Meshcat,
    progress: Progress | None = None,
    reach: dict[str, Any] | None = None,
    write_frame: WriteFrame | None = None,
) -> Evaluation:
    """Runs a scenario and leaves everything it came to in `folder`.

    Args:
        folder: Exists; files of an earlier run are replaced.
        scenario: What to run.
        skill: What to reproduce.
        meshcat: Shows the run live and records it.
        progress: See `bath_drake.simulation.run`.
        reach: What was said of the reach beforehand, for metrics.json.
        write_frame: Takes every frame of the camera; None records nothing.
    """
    # A stale verdict must not stand beside a run that fails half-way.
    for name in (LOG, METRICS, REPORT, PAGE):
        remove(folder / name, error=RunFolderError)
    write_atomically(folder / SCENARIO, dump_scenario(scenario), error=RunFolderError)
    save_skill(folder / SKILL, skill)
    diagram = build_reproduction(
        scenario, skill, meshcat=meshcat, write_frame=write_frame
    )
    meshcat.StartRecording(set_visualizations_while_recording=True)
    log = run(diagram, scenario, progress)
    meshcat.StopRecording()
    log.save(folder / LOG)
    evaluation = evaluate(log, scenario, skill)
    if reach is not None:
        evaluation.metrics["reachability"] = reach
    write_metrics(folder / METRICS, evaluation.metrics)
    record_skin(meshcat, scenario, float(log.time[-1]))
    record_overlays(meshcat, log, evaluation, skill, BackPose(scenario))
    meshcat.PublishRecording()
    write_static_page(meshcat, folder / PAGE)
    write_report(folder)
    return evaluation


def write_metrics(path: Path, metrics: dict[str, Any]) -> None:
    """Writes metrics.json: strict JSON, no NaN."""
    text = json.dumps(metrics, indent=2, allow_nan=False) + "\n"
    write_atomically(path, text, error=RunFolderError)


def verdict_lines(metrics: dict[str, Any]) -> list[str]:
    """Returns the verdict as lines for a terminal."""
    lines = []
    for name, check in metrics["checks"].items():
        value = check["value"]
        shown = f"{value:.4g}" if isinstance(value, float) else str(value)
        mark = "pass" if check["pass"] else "FAIL"
        lines.append(f"{mark}  {name:24s} {shown:>14s}   limit {check['limit']}")
    factor = metrics["real_time_factor"]
    lines.append(f"      {'real_time_factor':24s} {factor:14.2f}")
    lines.append(f"verdict: {metrics['verdict']}")
    return lines
