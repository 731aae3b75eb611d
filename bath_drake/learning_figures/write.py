"""Writes the pictures of learning beside a skill."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from bath_drake.demonstrations.canonical import CanonicalDemonstration
from bath_drake.errors import BathDrakeError
from bath_drake.files import remove, write_atomically
from bath_drake.learning.generalisation import Generalisation
from bath_drake.learning.held_out import HeldOut
from bath_drake.learning.learner import LearningResult
from bath_drake.learning_figures.fields import fields_figure
from bath_drake.learning_figures.held_out import held_out_figure
from bath_drake.learning_figures.overview import overview_figure
from bath_drake.learning_figures.paths import NAMES, picture_path
from bath_drake.learning_figures.population import population_figure
from bath_drake.learning_figures.stages import stages_figure
from bath_drake.notation import FloatArray
from bath_drake.report import style
from bath_drake.report.cycle_figure import draw_cycle
from bath_drake.report.generalisation_figure import draw_generalisation
from bath_drake.rhythm.limit_cycle import LimitCycle

DPI = 120


def write_learning_figures(
    skill: Path,
    result: LearningResult,
    demonstrations: Sequence[FloatArray],
    generalisation: Generalisation | None = None,
    held_out: HeldOut | None = None,
    *,
    rhythm: tuple[LimitCycle, Sequence[CanonicalDemonstration]] | None = None,
    overview_only: bool = False,
) -> list[Path]:
    """Writes PNGs beside a skill file, and removes those of an earlier skill there.

    Args:
        skill: The skill file, SKILL.yaml.
        result: What was learned.
        demonstrations: What it was learned from, (T, 2) each, in N.
        generalisation: Draws SKILL_generalisation.png.
        held_out: Draws SKILL_held_out.png.
        rhythm: The cycle learned and the demonstrations it is of: draws
            SKILL_cycle.png.
        overview_only: Write SKILL.png, and SKILL_held_out.png if there is one.

    Returns:
        The pictures: SKILL.png, SKILL_fields.png and, where there is something to
        show, SKILL_population.png (of a single field's search), SKILL_stages.png (of
        a chain's) and the two above.

    Raises:
        BathDrakeError: When a file cannot be written.
    """
    branches = result.branches
    written = []
    with style.figure_style():
        figures: dict[str, Figure | None] = {
            "": overview_figure(result, demonstrations)
        }
        if not overview_only:
            figures["fields"] = fields_figure(result, demonstrations)
            figures["population"] = population_figure(result.trace, len(branches))
            figures["stages"] = stages_figure(result)
            if rhythm is not None:
                figures["cycle"] = draw_cycle(*rhythm)
        if generalisation is not None and not overview_only:
            figures["generalisation"] = draw_generalisation(generalisation, branches)
        if held_out is not None and held_out.names:
            figures["held_out"] = held_out_figure(held_out)
        for name in NAMES:
            path, figure = picture_path(skill, name), figures.get(name)
            if figure is None:
                remove(path)
                continue
            _write(path, figure)
            written.append(path)
    return written


def _write(path: Path, figure: Figure) -> None:
    def save(temporary: Path) -> None:
        figure.savefig(temporary, format="png", dpi=DPI, metadata={"Software": None})

    write_atomically(path, save, error=BathDrakeError)
