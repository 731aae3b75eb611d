"""What several verbs share: progress bars, a Meshcat, the end of a run."""

import contextlib
import logging
import sys
from collections.abc import Iterator
from pathlib import Path

from pydrake.geometry import Meshcat
from tqdm import tqdm

from bath_drake.carer_recording import record_carer
from bath_drake.demonstrations.rgbd.writer import RgbdWriter, check_recording_output
from bath_drake.diagrams.recording import build_recording
from bath_drake.errors import ScenarioError
from bath_drake.folder_lock import locked
from bath_drake.learning.skill import Skill
from bath_drake.reach.precheck import reachability
from bath_drake.run_folder import (
    PAGE,
    REPORT,
    make_run_folder,
    simulate_into,
    verdict_lines,
)
from bath_drake.scenario import Scenario
from bath_drake.scene.sensing import begin_recording
from bath_drake.simulation import Progress


@contextlib.contextmanager
def simulation_bar(duration: float, what: str = "simulating") -> Iterator[Progress]:
    """A bar of simulated seconds on a terminal; silent in a pipe."""
    bar = tqdm(
        total=duration,
        desc=what,
        disable=not sys.stderr.isatty(),
        bar_format="{desc} {bar} {n:.1f}/{total:.0f} s [{elapsed}]",
    )

    def progress(now: float, longest: float) -> None:
        bar.total = longest
        bar.n = min(now, longest)
        bar.refresh()

    with bar:
        yield progress


def record_and_report(folder: Path, scenario: Scenario) -> int:
    """Films the scenario's carer into `folder`, says what is there; returns 0."""
    check_recording_output(folder)
    # Whatever is wrong with the scenario is told before the folder is made.
    build_recording(scenario)
    writer = begin_recording(folder, scenario.scene.camera)
    with simulation_bar(scenario.duration, "recording") as progress:
        truth = record_carer(writer, scenario, progress)
    print(recording_line(writer))
    print(f"marker:   to be seen in {truth.seen} of {len(truth.t)} frames")
    return 0


def recording_line(writer: RgbdWriter) -> str:
    """What was recorded, as a line for a terminal."""
    size = sum(path.stat().st_size for path in writer.folder.rglob("*.*"))
    last = writer.times[-1] if writer.times else 0.0
    return (
        f"recorded: {writer.folder} ({len(writer.times)} frames, {last:.1f} s, "
        f"{size / 1e6:.0f} MB)"
    )


def run_and_report(
    folder: Path,
    scenario: Scenario,
    skill: Skill,
    live: bool,
    record: Path | None = None,
) -> int:
    """Simulates into `folder`, prints the verdict; 0 if it passes, 1 if not.

    With `record` the camera's frames go into that folder.
    """
    if record is not None:
        if scenario.perception.source == "ideal":
            raise ScenarioError(
                "--record: perception.source: found 'ideal', allowed camera: there are"
                " no frames to record"
            )
        check_recording_output(record)
    make_run_folder(folder)
    # Said before anything moves; what is not reached is no reason not to try.
    reach = reachability(scenario, skill)
    print("\n".join(reach.lines()), flush=True)
    writer = None if record is None else begin_recording(record, scenario.scene.camera)
    # Drake sets its own level on import; the address is printed below if wanted.
    logging.getLogger("drake").setLevel(logging.WARNING)
    meshcat = Meshcat()
    if live:
        print(f"Meshcat: {meshcat.web_url()}", flush=True)
    with locked(folder), simulation_bar(scenario.duration) as progress:
        evaluation = simulate_into(
            folder,
            scenario,
            skill,
            meshcat=meshcat,
            progress=progress,
            reach=reach.metrics(),
            write_frame=None if writer is None else writer.write,
        )
    print("\n".join(verdict_lines(evaluation.metrics)))
    print(f"report:  {folder / REPORT}\nmeshcat: {folder / PAGE}")
    if writer is not None:
        print(recording_line(writer))
    if live:
        input("press Enter to close Meshcat ") if sys.stdin.isatty() else None
    return 0 if evaluation.metrics["verdict"] == "pass" else 1
