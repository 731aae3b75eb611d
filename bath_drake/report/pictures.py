"""The report's pictures, each with its caption and what it shows in words."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from bath_drake.field.obstacles import ObstacleSet
from bath_drake.reach.precheck import reachability
from bath_drake.report import camera_figures, field_figures, style, time_figures
from bath_drake.report.certificate_figure import draw_certificate
from bath_drake.report.coverage_figure import draw_coverage
from bath_drake.report.cycle_figure import draw_cycle
from bath_drake.report.force_figure import draw_force
from bath_drake.report.generalisation_figure import draw_generalisation
from bath_drake.report.reach_figures import draw_placement, draw_reachability
from bath_drake.report.run_data import RunData
from bath_drake.report.tables import frechet_text, number

_KEYFRAMES = 3
# Figures in which pixels dominate.
_RASTERS = ("camera", "sequence", "cloud", "generalisation", "coverage")


@dataclass(frozen=True)
class Picture:
    """A figure as the template shows it.

    Attributes:
        source: The figure itself, as a data URI.
        text: What it shows, for who cannot see it.
        caption: Below it.
    """

    source: str
    text: str
    caption: str


_FIELD_CAPTION = (
    "Left: the virtual obstacles shape the field so that its flow is the stroke. "
    "Right: the field's own path (red) on the demonstrations (blue)."
)
_CHAIN_CAPTION = (
    "Left: each field has obstacles, a part of the path and a gate (half-disc) of one "
    "colour; in the gate the next field takes over. Right: the path (red) on the "
    "demonstrations (blue)."
)


def draw_pictures(run: RunData) -> dict[str, Picture]:
    """All figures by name; those the run gives nothing for are left out."""
    pictures: dict[str, Picture] = {}

    def add(name: str, figure: Figure | None, text: str, caption: str) -> None:
        if figure is not None:
            raster = name in _RASTERS
            source = style.as_data_uri(figure, raster=raster)
            pictures[name] = Picture(source, text, caption)

    series, chain = run.evaluation, run.skill.chain
    paths = [demonstration.points for demonstration in run.demonstrations]
    add(
        "demonstrations",
        field_figures.draw_demonstrations(
            [demonstration.raw for demonstration in run.demonstrations],
            paths,
            series.mean_demonstration,
        ),
        "Demonstrations in canonical space, raw and processed",
        "The carer's strokes in canonical space, where the back's box is the "
        "square from −1 to 1 (dotted).",
    )
    add(
        "field",
        field_figures.draw_chain(
            chain,
            paths,
            series.mean_demonstration,
            series.rollout,
            frechet_text(run),
        ),
        "The learned navigation field and its path on the demonstrations",
        _FIELD_CAPTION if len(chain) == 1 else _CHAIN_CAPTION,
    )
    add(
        "generalisation",
        draw_generalisation(run.generalisation, run.skill.branches),
        "The skill between random starts and goals",
        "The learned skill alone, rolled out between ends that nobody demonstrated, "
        "drawn at random as the paper's evaluation does (Sec. V). Each world is "
        "certified anew.",
    )
    world = run.evaluation.world
    add(
        "certificate",
        draw_certificate(
            world.field,
            world.certificate,
            world.start,
            run.metrics["certificate"].get("sensed_areas", 0),
        ),
        "The world that was driven in, with its certificate"
        if len(chain) == 1
        else "The last world that was driven in, with its certificate",
        "Learned and sensed obstacles together. The colours tell where roll-outs from "
        "a grid of starts end; the dot is the start that the proof was made for.",
    )
    executed = number(run.metrics["frechet"].get("executed"))
    periodic = bool(series.offsets.any())
    frame = run.main_keyframe
    add(
        "executed",
        field_figures.draw_executed(
            series.executed,
            series.mean_demonstration,
            paths,
            series.rollout,
            series.wound_polygons_N,
            run.keyframes[-1].areas if run.keyframes else ObstacleSet(),
            f"Fréchet {executed}" + (" without the cycles" if periodic else ""),
            series.executed - series.offsets if periodic else None,
        ),
        "The executed path against the demonstrations",
        "Where the jet met the true skin, in the person's true canonical space: "
        "judged from outside the loop.",
    )
    if run.skill.periodic is not None:
        add(
            "cycle",
            draw_cycle(
                run.skill.periodic, run.demonstrations, series.offsets, series.around
            ),
            "The periodic motion as demonstrated, learned, asked for and washed",
            "The cycle that the skill adds to its discrete motion. Near restricted "
            "areas and the body's edge it shrinks; what is washed includes the arm's "
            "lag and the body's motion.",
        )
    share = run.evaluation.wash.coverage
    add(
        "coverage",
        draw_coverage(
            series.wash,
            series.executed,
            series.wound_polygons_N,
            "–" if share is None else f"{100 * share:.1f} %",
            run.scenario.limits.coverage,
        ),
        "Coverage: the skin that was washed, and what was missed",
        "The true skin that was in the footprint of the jet or the sponge, carried "
        "along where the back bends. Dashed: what was to be washed, without what is to "
        "be spared around wounds.",
    )
    add(
        "clearance",
        time_figures.draw_clearance(run),
        "Clearance from the wound over time",
        "Distance on the skin between the washed point and the wound's true outline.",
    )
    add(
        "time",
        time_figures.draw_over_time(run),
        "Distances, errors, speed and timing over time",
        "Shaded: lining up and coming down. The guard: yellow where it holds, orange "
        "where it retreats, red where it has stopped. Dashed: limits.",
    )
    if run.metrics.get("reachability") is not None:
        _add_reach_pictures(run, add)
    add(
        "force",
        draw_force(run),
        "The force over time: asked for, measured and true",
        "The sponge's force along its own axis. The true one is the sum of the "
        "contact's pressures; the measured one has the sensor's bias and noise, and is "
        "what the regulator and the guard go by. Below, how far off the skin the "
        "nozzle's tip is asked to be: the sponge's face is 60 mm ahead of it.",
    )
    # Ideal perception takes no images.
    if frame is not None and run.scenario.perception.source != "ideal":
        _add_camera_pictures(run, add)
    return pictures


def _add_reach_pictures(run: RunData, add: Any) -> None:
    found = reachability(run.scenario, run.skill, floor=True)
    add(
        "reach",
        draw_reachability(found),
        "The back in canonical space, coloured by condition number and joint margin",
        "Where the arm gets on this back, with the person as twisted and leant as it "
        "ever is, and the path on it. "
        + " ".join(_sentence(line.partition(":")[2]) for line in found.lines()),
    )
    add(
        "base",
        draw_placement(found),
        "Places of the base, coloured by what they would reach",
        "What the same arm would reach from other places on the floor.",
    )


def _add_camera_pictures(run: RunData, add: Any) -> None:
    frame = run.main_keyframe
    assert frame is not None
    done, to_come = run.path_until(frame.time), run.path_from(frame)
    add(
        "camera",
        camera_figures.draw_camera_view(frame, done, to_come),
        "The camera's view with mask, canonical box and path",
        "What the loop knows of the person: the segmented back, its canonical box and "
        "the path laid onto the skin it sees.",
    )
    add(
        "cloud",
        camera_figures.draw_point_cloud(frame, done, to_come),
        "The depth image as a point cloud with path and normals",
        "The depth image as a point cloud, with the path and the normals that the loop "
        "estimates along it.",
    )
    count = len(run.keyframes)
    chosen = np.unique(np.linspace(0, count - 1, min(count, _KEYFRAMES)).astype(int))
    frames = [run.keyframes[k] for k in chosen]
    add(
        "sequence",
        camera_figures.draw_sequence(
            frames,
            [run.path_until(f.time) for f in frames],
            [run.path_from(f) for f in frames],
        ),
        "Key frames over time",
        "The map follows the person's motion; the path stays where it belongs on "
        "the back.",
    )


def _sentence(words: str) -> str:
    words = words.strip()
    return f"{words[:1].upper()}{words[1:]}."
