"""The paper's learner for the judge that ranks all learners' fields."""

import numpy as np

from bath_drake.field.navigation import NavigationField
from bath_drake.learning import genome
from bath_drake.learning.checkpoint import Arrays
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.cost import LearningProblem
from bath_drake.learning.journal import Journal
from bath_drake.learning.paper import cost as paper_cost
from bath_drake.learning.paper import learner as paper
from bath_drake.learning.seeding import obstacle_counts
from bath_drake.notation import FloatArray


def paper_fields(
    problem: LearningProblem, config: LearnerConfig, journal: Journal
) -> list[NavigationField]:
    """The one result of the paper's learner.

    The paper fixes the number of obstacles beforehand: unless ``config.obstacles`` says
    it, two more than the stroke has bends.
    """
    counts = obstacle_counts(problem.strokes.mean)
    count = counts[min(2, len(counts) - 1)]
    count = count if config.obstacles is None else config.obstacles
    xs = _search_paper(problem, count, config, journal)
    return [genome.decode(x, problem.workspace, problem.strokes.goal) for x in xs]


def _search_paper(
    problem: LearningProblem, count: int, config: LearnerConfig, journal: Journal
) -> list[FloatArray]:
    """The one result of the paper's learner."""
    settings = paper.settings_for(config.population, config.generations)
    journal.plan(settings.genetic.generations + 1)
    before, entered = journal.evaluations, len(journal.history) + 1

    def encode(best: FloatArray) -> FloatArray:
        return genome.encode(paper_cost.decode(best, problem, settings.kappa))

    def report(state: Arrays) -> None:
        journal.evaluations = before + int(state["evaluations"][0])
        cost = float(state["best_cost"][0])  # which has no penalties
        journal.enter(cost / journal.scale, encode(state["best"]), cost)
        order = np.argsort(state["costs"], kind="stable")
        centres = [state["members"][i].reshape(-1, 4)[:, :2] for i in order]
        name = f"generation {len(journal.history) - entered}"
        journal.watch(name, problem, state["costs"][order], centres)

    found = paper.learn(
        problem,
        count,
        settings,
        config.seed,
        step=lambda key, compute: journal.checkpoint.step(f"{count}: {key}", compute),
        report=report,
    )
    return [genome.encode(found.field)]
