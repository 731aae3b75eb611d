"""`bath-drake perceive`: what perception makes of a recorded folder, no simulator."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bath_drake.diagrams.recorded_perception import PerceivedFrame
    from bath_drake.scenario import Scenario


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the recording, where a person may be, and the table."""
    parser.add_argument(
        "folder",
        type=Path,
        metavar="FOLDER",
        help="the recording, with the camera's pose X_WC (docs/rgbd.md)",
    )
    parser.add_argument(
        "--scenario",
        metavar="SCENARIO.yaml",
        help="whose perception it is: workspace box, margin of restricted areas",
    )
    parser.add_argument(
        "--workspace",
        type=float,
        nargs=6,
        metavar=("X0", "Y0", "Z0", "X1", "Y1", "Z1"),
        help="the box in which a back may be, m in W, instead of the scenario's",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="TABLE.csv",
        help="a row a frame: t_s, found, visible_fraction, area_m2, the map's origin "
        "x_m, y_m, z_m and half extents half_x_m, half_y_m, restricted_areas",
    )


def run(options: argparse.Namespace) -> int:
    """Returns 0 if a back was found in any frame, 1 if in none."""
    import time

    from bath_drake.commands._progress import progress_bar
    from bath_drake.demonstrations.rgbd.folder import open_rgbd
    from bath_drake.diagrams.recorded_perception import perceive
    from bath_drake.errors import DemonstrationError
    from bath_drake.files import check_output, write_atomically

    scenario = _scenario(options)
    if options.output is not None:
        if options.output.suffix != ".csv":
            raise DemonstrationError(
                f"{options.output}: expected a name that ends in .csv"
            )
        check_output(options.output, error=DemonstrationError)
        if options.output.resolve().parent == options.folder.resolve():
            raise DemonstrationError(f"{options.output}: is inside the recording")
    recording = open_rgbd(options.folder)
    begin = time.perf_counter()
    with progress_bar(desc="perceiving", unit="frame") as bar:

        def progress(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        frames = perceive(recording, scenario, progress)
    seconds = time.perf_counter() - begin
    if options.output is not None:
        write_atomically(options.output, _table(frames), error=DemonstrationError)
    print("\n".join(_summary(frames, len(recording), seconds)))
    if options.output is not None:
        print(f"written:  {options.output}")
    return 0 if any(frame.observation.found for frame in frames) else 1


def _scenario(options: argparse.Namespace) -> "Scenario":
    from bath_drake.errors import ScenarioError
    from bath_drake.scenario import Scenario, check_scenario, load_scenario

    scenario = Scenario()
    if options.scenario is not None:
        scenario = load_scenario(options.scenario)
    if options.workspace is not None:
        scenario.perception.workspace_low = options.workspace[:3]
        scenario.perception.workspace_high = options.workspace[3:]
        try:
            check_scenario(scenario)
        except ValueError as error:
            raise ScenarioError(f"--workspace: {error}") from error
    return scenario


def _table(frames: Sequence["PerceivedFrame"]) -> str:
    lines = [
        "t_s,found,visible_fraction,area_m2,x_m,y_m,z_m,half_x_m,half_y_m,"
        "restricted_areas,hidden_share,hidden_quality,rejected_frames"
    ]
    known = False
    for frame in frames:
        seen, body = frame.observation, frame.canonical_map
        known = known or seen.found
        numbers = [*body.p_WP, *body.half_extents] if known else []
        cells = [f"{number:.5f}" for number in numbers] or [""] * 5
        lines.append(
            f"{frame.t:.6f},{int(seen.found)},{seen.visible_fraction:.4f},"
            f"{seen.area:.5f},{','.join(cells)},{len(frame.areas)},"
            f"{seen.hidden_share:.4f},{seen.completion_quality:.4f},"
            f"{frame.rejected}"
        )
    return "\n".join(lines) + "\n"


def _summary(
    frames: Sequence["PerceivedFrame"], recorded: int, seconds: float
) -> list[str]:
    found = [frame for frame in frames if frame.observation.found]
    lines = [
        f"frames:   {len(frames)} of {recorded} seen, {frames[-1].t:.1f} s, "
        f"{1e3 * seconds / len(frames):.0f} ms each",
        f"back:     found in {len(found)} frames",
    ]
    if found:
        last = found[-1]
        wide, tall = 2e2 * last.canonical_map.half_extents[:2]
        x, y, z = last.canonical_map.p_WP
        area = 1e4 * last.observation.area
        lines += [
            f"at last:  {wide:.1f} x {tall:.1f} cm at {x:.3f}, {y:.3f}, {z:.3f} m, "
            f"{area:.0f} cm2 of skin in sight",
            f"areas:    {len(frames[-1].areas)} restricted",
            f"jumps:    {frames[-1].rejected} frames not believed",
        ]
    else:
        lines.append(
            "          nothing in the workspace box has a back's colour and shape; see "
            "--workspace"
        )
    return lines
