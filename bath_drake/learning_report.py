"""The picture of what was learned: the canonical plane and the learning curve."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from bath_drake.composition.chain import Chain
from bath_drake.composition.result import whole_verdict
from bath_drake.composition.rollout import ChainRollout
from bath_drake.demonstrations.canonical import CanonicalDemonstration
from bath_drake.errors import BathDrakeError
from bath_drake.field.navigation import NavigationField, flow_direction, min_beta
from bath_drake.learning.learner import LearningResult
from bath_drake.notation import FloatArray
from bath_drake.yaml_io import write_atomically

# Half the side of the plane shown: the body's box and a margin.
VIEW = 1.15
GRID = 80
DPI = 130


def write_learning_figure(
    path: str | Path,
    result: LearningResult,
    demonstrations: Sequence[CanonicalDemonstration],
) -> None:
    """Writes a PNG: what was learned on the left, how the cost fell on the right.

    Raises:
        BathDrakeError: When the file cannot be written.
    """
    figure = learning_figure(result, demonstrations)

    def save(temporary: Path) -> None:
        figure.savefig(temporary, format="png", dpi=DPI)

    write_atomically(path, save, error=BathDrakeError)


def learning_figure(
    result: LearningResult, demonstrations: Sequence[CanonicalDemonstration]
) -> Figure:
    """Draws both panels; the figure belongs to no window."""
    figure = Figure(figsize=(12.0, 5.8), layout="constrained")
    FigureCanvasAgg(figure)
    plane, curve = figure.subplots(1, 2, width_ratios=[1.0, 1.0])
    chain, found = result.chain, result.rollout
    reach = _reach(chain.goal)
    if len(chain) == 1:
        draw_field(plane, chain.fields[0])
    else:
        plane.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
        plane.set(xlabel="canonical x", ylabel="canonical y")
    blues = mpl.colormaps["Blues"](np.linspace(0.45, 0.8, len(demonstrations)))
    for number, (demonstration, colour) in enumerate(
        zip(demonstrations, blues, strict=True)
    ):
        label = "demonstrations" if number == len(demonstrations) - 1 else None
        plane.plot(*demonstration.points.T, color=colour, lw=1.6, label=label)
    mean = result.mean_demonstration
    plane.plot(*mean.T, color="black", lw=1.2, ls="--", label="their mean")
    if len(chain) == 1:
        plane.plot(*found.path.T, color="red", lw=2.0, label="reproduction")
    else:
        draw_stages(plane, chain, found)
    plane.plot(*result.start, "o", color="red", ms=7, label="start")
    plane.plot(*chain.goal, "*", color="red", ms=14, label="goal")
    plane.legend(loc="lower right", fontsize=9, framealpha=0.9)
    fields = "field" if len(chain) == 1 else f"chain of {len(chain)} fields"
    plane.set_title(f"learned {fields}, {chain.obstacle_count} virtual obstacles")
    _draw_curve(curve, result)
    return figure


def draw_stages(axes: Axes, chain: Chain, found: ChainRollout) -> None:
    """Draws each stage's obstacles, gate and part of the motion in its own colour."""
    colours = mpl.colormaps["turbo"](np.linspace(0.08, 0.92, len(chain)))
    for k, (field, colour) in enumerate(zip(chain.fields, colours, strict=True)):
        _draw_obstacles(axes, field, colour)
        at = np.flatnonzero(found.stages == k)
        if len(at):
            part = found.path[at[0] : at[-1] + 2]
            axes.plot(*part.T, color=colour, lw=2.4, label=f"stage {k + 1}")
        if k < len(chain.gates):
            axes.plot(*chain.gates[k].outline().T, color=colour, lw=0.8, ls=":")


def _reach(goal: FloatArray) -> float:
    return float(np.abs(np.append(goal, VIEW - 0.1)).max() + 0.1)


def draw_field(axes: Axes, field: NavigationField) -> None:
    """Draws obstacles, workspace and flow in the plane of N."""
    reach = _reach(field.goal)
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    axes.set(xlabel="canonical x", ylabel="canonical y")
    t = np.linspace(-reach, reach, GRID)
    x, y = np.meshgrid(t, t)
    q = np.stack([x, y], axis=-1)
    free = min_beta(q, field) > 0.0
    flow = np.where(free[..., None], flow_direction(q, field), np.nan)
    axes.streamplot(
        x, y, *_masked(flow), color="0.8", linewidth=0.6, arrowsize=0.7, density=1.3
    )
    _draw_obstacles(axes, field, "0.4")
    if not free.all():
        axes.contour(
            x, y, field.workspace.beta(q), levels=[0.0], colors="0.25", linewidths=1.5
        )


def _draw_obstacles(axes: Axes, field: NavigationField, colour: Any) -> None:
    for centre_x, centre_y, a, b, angle in field.obstacles.theta:
        axes.add_patch(
            Ellipse(
                (centre_x, centre_y),
                2.0 * a,
                2.0 * b,
                angle=float(np.degrees(angle)),
                facecolor=to_rgba(colour, 0.45),
                edgecolor=colour,
            )
        )


def _masked(flow: FloatArray) -> tuple[FloatArray, FloatArray]:
    masked = np.ma.masked_invalid(flow)
    return masked[..., 0], masked[..., 1]


def _draw_curve(axes: Axes, result: LearningResult) -> None:
    evaluations, cost = np.array(result.cost_history, dtype=np.float64).T
    figures = result.frechet
    verdict, _ = whole_verdict(result.certificates)
    axes.step(evaluations, cost, where="post", color="tab:blue", label="best C so far")
    axes.axhline(
        figures["cost"],
        color="red",
        lw=1.2,
        label=f"C of the skill {figures['cost']:.4f}",
    )
    if figures["floor"] > 0.0:
        axes.axhline(
            figures["floor"],
            color="black",
            lw=1.2,
            ls="--",
            label=f"spread of the demonstrations {figures['floor']:.4f}",
        )
    axes.set_yscale("log")
    axes.set(xlabel="evaluations", ylabel="mean Fréchet distance C, over the scale")
    axes.grid(visible=True, which="both", color="0.9", lw=0.6)
    axes.legend(loc="upper right", fontsize=9)
    axes.set_title(
        f"Fréchet to the mean {figures['to_mean']:.4f}, {verdict}, "
        f"{result.seconds:.1f} s"
    )
