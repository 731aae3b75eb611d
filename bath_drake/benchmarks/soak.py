"""`bath-drake bench soak`: hours of the closed loop under random faults.

One body is seen by the camera, the others with ideal perception. Every sitting of a
body is a process of its own, with one Diagram for all its episodes.
With `--data DIR` every episode is kept there, and a run that was broken off goes on.
"""

import json
import os
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from bath_drake.benchmarks.figures import Figure, Progress, Report, Settings
from bath_drake.benchmarks.soak_episodes import (
    EPISODES,
    SHORTEST,
    Episode,
    as_row,
    run_sitting,
)
from bath_drake.errors import BathDrakeError
from bath_drake.files import append
from bath_drake.patient.people import shipped_people

HOURS = 8.0
# Who is seen by the camera; the others are seven of the eight.
THROUGH_THE_CAMERA = "m_avg"
# How much longer a second takes through the camera.
CAMERA_WORK = 3.0
GROWTH_MB = 5.0
# Kernels, meshes and caches are there after so many episodes in which most passed: one
# that is held all the while needs few of them.
WARM_UP, MOST = 3, 0.5


def run(settings: Settings, progress: Progress) -> Report:
    """Soaks every body for its share of the hours."""
    hours = HOURS if settings.hours is None else settings.hours
    people = list(shipped_people())
    share = hours * 3600.0 / len(people)
    found = {person: list(_kept(settings.data, person)) for person in people}
    workers = max(1, min(os.cpu_count() or 1, len(people)))
    with ProcessPoolExecutor(
        max_workers=workers,
        # A fork would copy what this process has loaded, and judge its growth too.
        mp_context=get_context("spawn"),
        max_tasks_per_child=1,
    ) as pool:
        running: dict[Future[list[Episode]], str] = {}
        while True:
            for person in next_people(found, share, set(running.values())):
                if len(running) == workers:
                    break
                sitting, first, seconds = what_is_left(found[person], share)
                ideal = person != THROUGH_THE_CAMERA
                task = (person, sitting, first, seconds, ideal, settings.data)
                running[pool.submit(soak_sitting, *task)] = person
            if not running:
                break
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                found[running.pop(future)] += future.result()
            soaked = sum(e.seconds for episodes in found.values() for e in episodes)
            progress("soak", min(soaked / (hours * 3600.0), 1.0))
    rows = [body_row(person, found[person]) for person in people]
    return Report(figures(hours, rows), rows)


def next_people(
    found: dict[str, list[Episode]], share: float, busy: set[str]
) -> list[str]:
    """Returns who may sit next, those of whom most is left first.

    So that none is left alone at the end, with all other processors idle.
    """

    def work(person: str) -> float:
        seconds = what_is_left(found[person], share)[2]
        return seconds * (CAMERA_WORK if person == THROUGH_THE_CAMERA else 1.0)

    due = {person: work(person) for person in found if person not in busy}
    due = {person: left for person, left in due.items() if left >= SHORTEST}
    return sorted(due, key=lambda person: -due[person])


def what_is_left(episodes: list[Episode], share: float) -> tuple[int, int, float]:
    """Returns the sitting to go on with, its next episode, and the seconds left."""
    left = share - sum(episode.seconds for episode in episodes)
    if not episodes:
        return 0, 0, left
    last = episodes[-1]
    if last.index + 1 < EPISODES:
        return last.sitting, last.index + 1, left
    return last.sitting + 1, 0, left


def soak_sitting(
    person: str,
    sitting: int,
    first: int,
    seconds: float,
    ideal: bool,
    folder: Path | None,
) -> list[Episode]:
    """Runs what is left of a sitting, in a process of its own; keeps every episode."""
    episodes = []
    for episode in run_sitting(
        person, sitting, ideal=ideal, first=first, seconds=seconds
    ):
        episodes.append(episode)
        if folder is not None:
            append(_file(folder, person), json.dumps(as_row(episode)) + "\n")
    return episodes


def _file(folder: Path, person: str) -> Path:
    return folder / f"soak_{person}.jsonl"


def _kept(folder: Path | None, person: str) -> Iterator[Episode]:
    if folder is None or not _file(folder, person).exists():
        return
    path = _file(folder, person)
    for k, line in enumerate(path.read_text("utf-8").splitlines()):
        try:
            yield Episode(**json.loads(line))
        except (ValueError, TypeError):
            raise BathDrakeError(
                f"{path}: line {k + 1}: found {line[:40]!r}, allowed an episode; "
                "delete the file to begin anew"
            ) from None


def largest_growth(episodes: list[Episode]) -> float:
    """Returns the most that a process grew by after its warm-up, MB; NaN of none."""
    growths, warm, washed = [], np.nan, 0
    for episode in episodes:
        if episode.runs_before == 0:
            warm, washed = np.nan, 0
        washed += episode.passed >= MOST
        if washed > WARM_UP and np.isnan(warm):
            warm = episode.memory
        growths.append(episode.memory - warm)
    known = [growth for growth in growths if np.isfinite(growth)]
    return float(max(known)) if known else float("nan")


def body_row(person: str, episodes: list[Episode]) -> dict[str, str | float | bool]:
    """Sums one body's episodes up."""
    return {
        "person": person,
        "episodes": float(len(episodes)),
        "seconds": round(sum(e.seconds for e in episodes), 1),
        "at goal": float(sum(e.outcome == "GOAL_REACHED" for e in episodes)),
        "passed": round(float(np.mean([e.passed for e in episodes])), 3),
        "entries": float(sum(e.entries for e in episodes)),
        "not finite": float(sum(e.not_finite for e in episodes)),
        "too fast": float(sum(e.too_fast for e in episodes)),
        "growth, MB": round(largest_growth(episodes), 2),
    }


def figures(hours: float, rows: list[dict[str, str | float | bool]]) -> list[Figure]:
    """Sums the bodies up."""

    def total(key: str) -> float:
        return sum(float(row[key]) for row in rows)

    grown = [float(row["growth, MB"]) for row in rows]
    known = [value for value in grown if np.isfinite(value)]
    asked = 0.99 * hours
    growth = Figure("soak_memory_growth_of_a_body", np.nan, "MB")
    if known:
        growth = Figure("soak_memory_growth_of_a_body", max(known), "MB", GROWTH_MB)
    return [
        Figure("soak_hours", total("seconds") / 3600.0, "h", asked, "at least"),
        Figure("soak_episodes", total("episodes")),
        Figure("soak_restricted_entries", total("entries"), "", 0.0),
        Figure("soak_not_finite", total("not finite"), "", 0.0),
        Figure("soak_too_fast", total("too fast"), "", 0.0),
        growth,
    ]
