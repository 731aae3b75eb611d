"""`bath-drake reproduce`: roll a skill out, no simulator."""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bath_drake.learning.skill import Skill
    from bath_drake.notation import FloatArray

# Along the skin, m/s, as the shipped scenarios wash.
SPEED = 0.07


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the skill, the ends of the motion and where the path goes."""
    parser.add_argument("skill", metavar="SKILL.yaml")
    for name, required in (("start", True), ("goal", False)):
        parser.add_argument(
            f"--{name}", type=float, nargs=2, metavar=("X", "Y"), required=required
        )
    parser.add_argument(
        "--frame",
        choices=["canonical", "demonstration"],
        default="canonical",
        help="of start, goal and path; demonstration: skills of 2-D recordings only",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="PATH.csv",
        help="write the path: columns t (s), x, y",
    )


def run(options: argparse.Namespace) -> int:
    """Returns 0 if the goal is reached, 1 if not.

    The times are those of a nozzle at `SPEED` over a body as large as the
    demonstrations'. A periodic motion is on the path. A composed skill's fields are
    followed in turn, as the branch that was shown nearest to this start has them for
    these ends. The world with these ends is certified anew, whole or else for this
    start; its verdict is printed, never the skill's.
    """
    import numpy as np

    from bath_drake.composition.certify import certify_chain
    from bath_drake.composition.rollout import chain_rollout, chain_times
    from bath_drake.errors import BathDrakeError
    from bath_drake.field.navigation import min_beta
    from bath_drake.field.obstacles import ObstacleSet
    from bath_drake.field.rollout import RolloutStatus
    from bath_drake.files import check_output, write_atomically
    from bath_drake.rhythm.superposition import Room
    from bath_drake.rhythm.whole_motion import whole_motion
    from bath_drake.skill_file import load_skill

    if options.output is not None:
        check_output(options.output)
    skill = load_skill(options.skill)
    planar = options.frame == "demonstration"
    if planar and skill.canonical.kind != "planar":
        raise BathDrakeError(
            f"{options.skill}: --frame demonstration is for skills of 2-D recordings, "
            f"this one's frame is {skill.canonical.kind}; allowed: canonical"
        )
    start = _canonical("--start", options.start, skill, planar)
    goal = None
    if options.goal is not None:
        goal = _canonical("--goal", options.goal, skill, planar)
    chain = skill.chain_for(start, goal)
    for name, point, field in (
        ("--start", start, chain.fields[0]),
        ("--goal", chain.goal, chain.fields[-1]),
    ):
        if not min_beta(point, field) > 0.0:
            raise BathDrakeError(
                f"{name}: ({point[0]:.6g}, {point[1]:.6g}) in canonical space is in an "
                "obstacle or outside the workspace, allowed: free space"
            )
    found = chain_rollout(start, chain)
    times = chain_times(found, chain, speed=SPEED, half_extents=skill.canonical.scales)
    path = found.path
    if skill.periodic is not None and len(path) > 1:
        box = 1.0 if skill.canonical.kind == "body_box" else np.inf
        room = Room(ObstacleSet(), chain.fields[-1].workspace, box)
        times, path = whole_motion(
            skill.periodic,
            path,
            room,
            speed=SPEED,
            half_extents=skill.canonical.scales,
        )
    if planar:
        path = skill.canonical.to_demonstration(path)
    certificate = certify_chain(chain, start=start)
    if options.output is not None:
        rows = np.column_stack([times, path]).tolist()
        lines = [",".join(f"{value:.9g}" for value in row) for row in rows]
        write_atomically(options.output, "\n".join(["t,x,y", *lines, ""]))
    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    print(f"goal     {found.status.name.lower().replace('_', ' ')}")
    print(f"path     {len(path)} points, length {length:.4g} ({options.frame} frame)")
    print(f"time     {times[-1]:.2f} s at {SPEED} m/s")
    if len(chain) > 1:
        print(f"fields   {found.stages[-1] + 1} of {len(chain)} followed")
    if skill.periodic is not None:
        print(
            f"cycles   {skill.periodic.period:.2f} s each as shown, in the path; the "
            "verdict is on the discrete motion"
        )
    print(f"verdict  {certificate.verdict}: {certificate.reason}")
    return 0 if found.status is RolloutStatus.ARRIVED else 1


def _canonical(
    name: str, point: list[float], skill: "Skill", planar: bool
) -> "FloatArray":
    """A point of the command line in canonical space."""
    import numpy as np

    from bath_drake.errors import BathDrakeError

    if not all(math.isfinite(value) for value in point):
        raise BathDrakeError(f"{name}: found {point}, allowed: two finite numbers")
    given = np.array(point)
    return skill.canonical.to_canonical(given) if planar else given
