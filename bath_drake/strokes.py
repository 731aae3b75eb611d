"""The skill that a scenario washes with: one, or several strokes strung together."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.composition.branch import Branch
from bath_drake.composition.certify import certify_chain
from bath_drake.composition.chain import Chain
from bath_drake.composition.rollout import chain_rollout
from bath_drake.composition.stroke_config import StrokeConfig
from bath_drake.composition.strokes import carried, lanes, strung
from bath_drake.errors import ScenarioError
from bath_drake.learning.skill import Skill
from bath_drake.notation import FloatArray
from bath_drake.scenario import Scenario, find_skill
from bath_drake.skill_file import certified, load_skill

_STROKES = "strokes"


def scenario_skill(scenario: Scenario, path: str | Path | None = None) -> Skill:
    """Reads the skill of a scenario, strung together where it has several strokes.

    Args:
        scenario: Names the skill.
        path: Of another to take in its place.

    Raises:
        SkillFileError: A skill's file is missing or damaged.
        ScenarioError: See `string_strokes`.
    """
    return string_strokes(scenario, load_skill(find_skill(path or scenario.skill)))


def planned_strokes(scenario: Scenario) -> list[StrokeConfig]:
    """The strokes that a scenario asks for; none where it is the skill's own."""
    if scenario.lanes is None:
        return scenario.strokes
    ends = lanes(scenario.lanes.low, scenario.lanes.high, scenario.lanes.spacing)
    return [StrokeConfig(start=a.tolist(), goal=b.tolist()) for a, b in ends]


def is_strung(skill: Skill) -> bool:
    """Whether a skill is of several strokes, which nobody demonstrated as a whole."""
    return _STROKES in skill.config


def string_strokes(scenario: Scenario, skill: Skill) -> Skill:
    """A skill of a scenario's strokes in turn, each carried to its start and goal.

    It is another world than the skill's: it is certified anew, whole or from its first
    start, and its `config` says what it was made of.

    Args:
        scenario: Has strokes or lanes, or neither.
        skill: Of all strokes that name none of their own.

    Returns:
        The very skill where there are no strokes, or where it is of these already.

    Raises:
        ScenarioError: A stroke's skill cannot be carried, or has a periodic motion.
        SkillFileError: A stroke's skill is missing or damaged.
    """
    strokes = planned_strokes(scenario)
    asked: list[dict[str, Any]] = [dataclasses.asdict(stroke) for stroke in strokes]
    if not strokes or skill.config.get(_STROKES) == asked:
        return skill
    parts: list[tuple[FloatArray, Chain]] = []
    hashes = list(skill.demonstration_hashes)
    for k, stroke in enumerate(strokes):
        of_it = skill
        if stroke.skill is not None:
            of_it = load_skill(find_skill(stroke.skill))
            hashes += of_it.demonstration_hashes
        start = np.array(stroke.start)
        try:
            _check(of_it)
            chain = carried(of_it.chain, of_it.start, start, stroke.goal)
        except ValueError as error:
            raise ScenarioError(f"strokes[{k}]: {error}") from error
        parts.append((start, chain))
    return _strung_skill(skill, parts, {_STROKES: asked}, hashes)


def _check(skill: Skill) -> None:
    if skill.periodic is not None:
        raise ValueError("found a skill with a periodic motion, allowed one without")


def _strung_skill(
    skill: Skill,
    parts: list[tuple[FloatArray, Chain]],
    config: dict[str, Any],
    hashes: list[str],
) -> Skill:
    chain, start = strung(parts), parts[0][0]
    path = chain_rollout(start, chain).path
    branch = Branch(chain=chain, start=start, starts=start[None], mean=path)
    made = dataclasses.replace(
        skill,
        branches=(branch,),
        config=config,
        demonstration_hashes=tuple(dict.fromkeys(hashes)),
        scale=float(np.ptp(path, axis=0).max()),
        frechet={},
    )
    return certified(made, certify_chain(chain, start=start))
