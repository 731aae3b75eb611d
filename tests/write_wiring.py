"""Renews the wiring records of the shipped Diagrams: python tests/write_wiring.py."""

import functools
from collections.abc import Callable
from dataclasses import replace

from made_up_run import make_skill
from pydrake.systems.framework import Diagram

from bath_drake.diagrams import (
    build_perception,
    build_reproduction,
)
from bath_drake.diagrams.block_diagram import wiring_lines
from bath_drake.diagrams.canonical import build_canonical_loop
from bath_drake.diagrams.recording import build_recording
from bath_drake.resources import diagrams_folder
from bath_drake.scenario import Scenario, find_skill, load_scenario
from bath_drake.skill_file import load_skill

RECORDS = diagrams_folder() / "wiring"


@functools.cache
def made_up_skill():
    # Of a skill the wiring depends on one thing: whether it has a periodic motion.
    return make_skill(Scenario())


def _skill_like(scenario: Scenario):
    cycle = load_skill(find_skill(scenario.skill)).periodic
    return replace(made_up_skill(), periodic=cycle)


def _filmed(scenario: Scenario) -> Diagram:
    return build_recording(scenario).diagram


def _builders() -> dict[str, Callable[[], Diagram]]:
    builders = {"canonical_loop": lambda: build_canonical_loop(made_up_skill())}
    for path in sorted(diagrams_folder().glob("*.yaml")):
        scenario = load_scenario(path)
        if scenario.scene.carer is not None:
            builders[path.stem] = functools.partial(_filmed, scenario)
            continue
        builders[path.stem] = functools.partial(
            build_reproduction, scenario, _skill_like(scenario)
        )
        builders[f"{path.stem}_perception"] = functools.partial(
            build_perception, scenario
        )
    return builders


BUILDERS = _builders()


@functools.cache
def shipped_diagram(name: str) -> Diagram:
    """A shipped Diagram, built once in a process."""
    return BUILDERS[name]()


def wiring_text(name: str) -> str:
    return "\n".join(wiring_lines(shipped_diagram(name))) + "\n"


if __name__ == "__main__":
    RECORDS.mkdir(exist_ok=True)
    for old in RECORDS.glob("*.txt"):
        old.unlink()
    for name in BUILDERS:
        (RECORDS / f"{name}.txt").write_text(wiring_text(name), encoding="utf-8")
        print(RECORDS / f"{name}.txt")
