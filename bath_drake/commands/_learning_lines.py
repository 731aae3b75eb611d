"""What `bath-drake learn` says: lines for a terminal."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bath_drake.demonstrations.canonical import CanonicalDemonstration
    from bath_drake.learning.generalisation import Generalisation
    from bath_drake.learning.held_out import HeldOut
    from bath_drake.learning.learner import LearningResult
    from bath_drake.learning.periodic import PeriodicFit


def result_lines(
    result: "LearningResult", demonstrations: Sequence["CanonicalDemonstration"]
) -> list[str]:
    """What came of learning, demonstration by demonstration."""
    from bath_drake.composition.result import whole_verdict
    from bath_drake.learning.learner import CONVERGED_FRECHET

    figures = result.frechet
    fields = sum(len(branch.chain) for branch in result.branches)
    verdict, reason = whole_verdict(result.certificates)
    lines = [
        f"converged        {'yes' if result.converged else 'NO'}"
        f"{'' if result.finished else ', UNFINISHED'}",
        f"Frechet to mean  {figures['to_mean']:.4f} (at most {CONVERGED_FRECHET})",
        f"C                {figures['cost']:.4f} (spread of the demonstrations "
        f"{figures['floor']:.4f})",
        f"fields           {fields}"
        + (f" in {len(result.branches)} branches" if len(result.branches) > 1 else ""),
        f"obstacles        {result.obstacle_count}",
        f"verdict          {verdict}: {reason}",
        f"seconds          {result.seconds:.1f}",
    ]
    if result.failures:
        lines.append(f"failed members   {result.failures} (dropped)")
    left_out = {outlier.index: outlier.reason for outlier in result.outliers}
    for i, (demonstration, distance) in enumerate(
        zip(demonstrations, result.per_demonstration, strict=True)
    ):
        x, y = demonstration.goal_offset
        said = (
            f"LEFT OUT, {left_out[i]}" if i in left_out else f"Frechet {distance:.4f}"
        )
        lines.append(
            f"  {demonstration.name}: {said}, goal moved by ({-x:+.4f}, {-y:+.4f})"
        )
    return lines


def periodic_lines(found: "PeriodicFit") -> list[str]:
    """The cycle, and demonstrations that did not count for it."""
    lines = []
    if found.cycle is not None:
        cycle = found.cycle
        lines.append(
            f"periodic         {cycle.period:.2f} s a cycle, {cycle.radius:.3f} from "
            f"the stroke, a cycle every {cycle.pitch:.3f} of it (both of N); the "
            f"demonstrations differ by {found.spread:.2f} of its size"
        )
    for outlier in found.left_out:
        lines.append(f"  {outlier.name}: not for the cycle, {outlier.reason}")
    return lines


def ring_lines(found: "Generalisation") -> list[str]:
    """How the skill does between other ends."""
    from bath_drake.report.generalisation_table import HEADER, generalisation_rows

    lines = ["other starts and goals, medians of the paths that arrive:"]
    for row in (HEADER, *generalisation_rows(found)):
        lines.append(("  " + "".join(f"{cell:17s}" for cell in row)).rstrip())
    return lines


def held_out_lines(found: "HeldOut") -> list[str]:
    """How well each demonstration is foreseen from the others."""
    import numpy as np

    lines = [
        "held out (learned from the others), Frechet in-sample and held out:",
    ]
    for i, name in enumerate(found.names):
        said = "" if found.arrived[i] else ", DID NOT ARRIVE"
        said += "" if found.proved[i] else ", not proved"
        inside = found.in_sample[i]
        shown = f"{inside:.4f}" if np.isfinite(inside) else "left out"
        lines.append(f"  {name}: {shown}, {found.distances[i]:.4f}{said}")
    if found.names:
        median = float(np.median(found.distances))
        lines.append(f"  median held out: {median:.4f}")
    if not found.finished:
        lines.append("  UNFINISHED")
    return lines
