"""report.html: one page that holds everything, out of a run's folder."""

from pathlib import Path
from typing import Any

import jinja2
import numpy as np

from bath_drake.control.approach import Phase
from bath_drake.errors import RunFolderError
from bath_drake.files import write_atomically
from bath_drake.report import style
from bath_drake.report.chain import ChainFigures, draw_chain
from bath_drake.report.generalisation_table import HEADER, generalisation_rows
from bath_drake.report.pictures import draw_pictures
from bath_drake.report.run_data import RunData, load_run
from bath_drake.report.tables import (
    certificate_rows,
    certificate_text,
    check_rows,
    frechet_rows,
    guard_rows,
    milliseconds,
    number,
    provenance,
    washing_rows,
)
from bath_drake.safety.outcome import LoopOutcome
from bath_drake.scenario import Scenario

REPORT_NAME = "report.html"

_OUTCOMES = {
    LoopOutcome.GOAL_REACHED.name: "The nozzle reached the goal",
    LoopOutcome.TIMED_OUT.name: "The run timed out before the goal",
    LoopOutcome.TOO_CLOSE.name: "The run was stopped: the nozzle came too close",
    LoopOutcome.RUNNING.name: "The run was cut off before its end",
}


# As long as no motion model bends a person, whatever rig its folder holds.
_RIGID = "The person is rigid in this run: it breathes, twists and leans as one body."
_BENDS = (
    "The person's skin bends in this run, but it does not give way: nothing touches it."
)

_TOUCHED = (
    "A soft sponge touches it: slabs of skin that move with the true one and give way "
    "as compliant hydroelastic bodies do."
)

_IDEAL = (
    "Perception was ideal: the loop was told the true back, and no image was rendered."
)
_KINEMATIC = "The arm was kinematic: exactly where it was told to be."


def write_report(folder: Path) -> Path:
    """Writes report.html into a run's folder, anew from its files.

    Args:
        folder: Holds scenario.yaml, skill.yaml, log.npz and metrics.json; a
            meshcat.html beside them is linked.

    Returns:
        The path of report.html: one file, without scripts, that loads nothing.

    Raises:
        RunFolderError: If a file is missing or damaged, naming it.
    """
    run = load_run(Path(folder))
    path = run.folder / REPORT_NAME
    write_atomically(path, render_report(run), error=RunFolderError)
    return path


def render_report(run: RunData) -> str:
    """Returns the page; the same run gives the same page."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("bath_drake.report", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    with style.figure_style():
        pictures = draw_pictures(run)
    return environment.get_template("report.html.jinja").render(
        passed=run.metrics["verdict"] == "pass",
        person=run.scenario.scene.person,
        summary=_summary(run),
        rigidity=_conditions(run.scenario),
        chain=draw_chain(_chain_figures(run)),
        headline=_headline(run),
        checks=check_rows(run.metrics["checks"]),
        figures=pictures,
        frechet=frechet_rows(run),
        generalisation_header=HEADER,
        generalisation=generalisation_rows(run.generalisation),
        washing=washing_rows(run),
        certificate=certificate_rows(run),
        certificate_text=certificate_text(run.evaluation.world.certificate),
        guard=guard_rows(run.metrics.get("guard_s", {}), run.metrics["holds"]),
        provenance=provenance(run),
        command=_command(run),
        meshcat=(run.folder / "meshcat.html").is_file(),
    )


def _conditions(scenario: Scenario) -> str:
    """What is simpler in the run than in a bathroom."""
    parts = [_BENDS if scenario.scene.motion.bends else _RIGID]
    if scenario.scene.arm.fidelity == "contact":
        parts = [parts[0].split(", but")[0].rstrip(".") + ".", _TOUCHED]
    if scenario.perception.source == "ideal":
        parts.append(_IDEAL)
    if scenario.scene.arm.fidelity == "kinematic":
        parts.append(_KINEMATIC)
    return " ".join(parts)


def _summary(run: RunData) -> str:
    metrics, scenario = run.metrics, run.scenario
    outcome = _OUTCOMES.get(run.log.outcome, f"The run ended with {run.log.outcome}")
    when = metrics.get("time_to_goal_s")
    after = f" after {when:.1f} s" if isinstance(when, int | float) else ""
    count, stages = len(run.skill.demonstration_hashes), len(run.skill.chain)
    fields = f" in {stages} fields, followed in turn" if stages > 1 else ""
    return (
        f"{scenario.description} Person {scenario.scene.person}; skill learned from "
        f"{count} demonstration{'s' if count != 1 else ''} with "
        f"{run.skill.chain.obstacle_count} virtual obstacles{fields}. "
        f"{outcome}{after}. "
        f"Random seed {metrics['seed']}."
    ).strip()


def _headline(run: RunData) -> list[tuple[str, str]]:
    """The figures a reader looks for first."""
    m = run.metrics
    surface, normal = m.get("surface_error_mm", {}), m.get("normal_error_deg", {})
    return [
        ("off the stand-off distance, mean", f"{number(surface.get('mean'))} mm"),
        ("axis against the true normal, mean", f"{number(normal.get('mean'))}°"),
        ("late behind moving skin", milliseconds(m.get("surface_lag_s")) or "–"),
        ("Fréchet, learned", number(m["frechet"].get("learned"))),
        ("Fréchet, executed", number(m["frechet"].get("executed"))),
        ("real-time factor", number(m.get("real_time_factor"))),
    ]


def _chain_figures(run: RunData) -> ChainFigures:
    m, log, chain = run.metrics, run.log, run.skill.chain
    frame = run.main_keyframe
    reach = log.keyframe_reach[frame.index] if frame else (float("nan"),) * 2
    half = frame.canonical_map.half_extents if frame else np.full(2, np.nan)
    sensed = len(frame.areas) if frame else 0
    shape = f"κ {number(chain.fields[0].kappa)}"
    if len(chain) > 1:
        shape = f"{len(chain)} fields"
    stuck = m["holds"]["no_joint_solution"]
    held = sum(m["guard_s"].values())
    periodic = m.get("periodic")
    least = number(m.get("min_beta_reference", m.get("min_beta")))
    beta = f"min β {least}"
    if periodic:
        beta = f"β ≥ {least}, {periodic['cycles']:.0f} cycles"
    return ChainFigures(
        camera=f"{int(log.frames)} frames",
        camera_kind=_camera_kind(run.scenario),
        segmenter=f"{100 * reach[0]:.0f} % of it visible",
        projector=f"box {200 * half[0]:.0f} × {200 * half[1]:.0f} cm{_jumps(m)}",
        controller=beta,
        obstacles=f"{chain.obstacle_count} ellipses, {shape}",
        areas=f"{sensed} found",
        proof=str(m["certificate"]["verdict"]),
        surface=f"normal {number(m.get('normal_error_deg', {}).get('mean'))}° off",
        ik=f"{stuck} times stuck",
        guard=f"{number(held)} s not passed",
        arm=f"{number(m.get('surface_error_mm', {}).get('mean'))} mm off",
        tracker=f"{number(_lag(run))} mm behind",
    )


def _jumps(metrics: dict[str, Any]) -> str:
    rejected = metrics.get("rejected_frames", 0)
    return f", {rejected} jumps refused" if rejected else ""


def _camera_kind(scenario: Scenario) -> str:
    """The noise it has, in a few words."""
    if scenario.perception.source == "ideal":
        return "none: ideal"
    camera = scenario.scene.camera
    if camera.noise == "none" and camera.colour_noise is None:
        return "without noise"
    return "colour noise" if camera.noise == "none" else f"{camera.noise} noise"


def _lag(run: RunData) -> float:
    """Mean distance of the nozzle behind its reference while washing, mm."""
    log, frame = run.log, run.main_keyframe
    if frame is None:
        return float("nan")
    target = log.canonical_reference + log.canonical_offset
    apart = (target - log.canonical_position)[log.phase == Phase.WASH]
    apart = apart * frame.canonical_map.half_extents
    return 1e3 * float(np.linalg.norm(apart, axis=1).mean()) if len(apart) else 0.0


def _command(run: RunData) -> str:
    return "bath-drake simulate scenario.yaml --skill skill.yaml"
