"""`bath-drake bench soak`: hours of the closed loop under random faults.

One process a body, one body through the camera and the others with ideal perception.
With `--data DIR` every episode is kept there, and a run that was broken off goes on.
"""

import json
import os
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from bath_drake.benchmarks.figures import Figure, Progress, Report, Settings
from bath_drake.benchmarks.soak_episodes import LONGEST, Episode, as_row, run_episode
from bath_drake.errors import BathDrakeError
from bath_drake.patient.people import shipped_people

HOURS = 8.0
# Who is seen by the camera; the others are seven of the eight.
THROUGH_THE_CAMERA = "m_avg"
GROWTH_MB = 5.0
# Kernels, meshes and caches are there after so many episodes.
WARM_UP = 3


def run(settings: Settings, progress: Progress) -> Report:
    """Soaks every body for its share of the hours."""
    hours = HOURS if settings.hours is None else settings.hours
    people = list(shipped_people())
    share = hours * 3600.0 / len(people)
    found: dict[str, list[Episode]] = {}
    with ProcessPoolExecutor(
        max_workers=max(1, min(os.cpu_count() or 1, len(people))),
        # A fork would copy what this process has loaded, and judge its growth too.
        mp_context=get_context("spawn"),
        max_tasks_per_child=1,
    ) as pool:
        started: dict[Future[list[Episode]], str] = {
            pool.submit(soak_body, person, share, settings.data): person
            for person in people
        }
        for k, done in enumerate(as_completed(started)):
            found[started[done]] = done.result()
            progress("soak", (k + 1) / len(people))
    rows = [body_row(person, found[person]) for person in people]
    return Report(figures(hours, rows), rows)


def soak_body(person: str, seconds: float, folder: Path | None) -> list[Episode]:
    """Runs episodes of one body until it has been washed for so long, s."""
    path = None if folder is None else folder / f"soak_{person}.jsonl"
    episodes = list(_kept(path))
    ideal = person != THROUGH_THE_CAMERA
    while True:
        left = seconds - sum(episode.seconds for episode in episodes)
        # Runs end at goals, on multiples of a period: what rounding leaves is none.
        if left < 0.5:
            return episodes
        longest = min(LONGEST, left)
        episode = run_episode(person, len(episodes), longest, ideal=ideal)
        episodes.append(episode)
        if path is not None:
            with path.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps(as_row(episode)) + "\n")
                lines.flush()
                os.fsync(lines.fileno())


def _kept(path: Path | None) -> Iterator[Episode]:
    if path is None or not path.exists():
        return
    for k, line in enumerate(path.read_text("utf-8").splitlines()):
        try:
            yield Episode(**json.loads(line))
        except (ValueError, TypeError):
            raise BathDrakeError(
                f"{path}: line {k + 1}: found {line[:40]!r}, allowed an episode; "
                "delete the file to begin anew"
            ) from None


def body_row(person: str, episodes: list[Episode]) -> dict[str, str | float | bool]:
    """Sums one body's episodes up; its memory from after the warm-up on, MB."""
    memory = [episode.memory for episode in episodes]
    growth = np.nan
    if len(memory) > WARM_UP + 1:
        growth = memory[-1] - memory[WARM_UP]
    return {
        "person": person,
        "episodes": float(len(episodes)),
        "seconds": round(sum(e.seconds for e in episodes), 1),
        "at goal": float(sum(e.outcome == "GOAL_REACHED" for e in episodes)),
        "passed": round(float(np.mean([e.passed for e in episodes])), 3),
        "entries": float(sum(e.entries for e in episodes)),
        "not finite": float(sum(e.not_finite for e in episodes)),
        "too fast": float(sum(e.too_fast for e in episodes)),
        "growth, MB": round(float(growth), 2),
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
