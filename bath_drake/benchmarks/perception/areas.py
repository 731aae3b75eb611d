"""Restricted areas: of which colours they are found, and how many are not there."""

import time
from dataclasses import dataclass, field, replace

import numpy as np

from bath_drake.benchmarks.figures import Figure, Progress
from bath_drake.benchmarks.perception.filmed import (
    BENDING,
    Filmed,
    Frame,
    filmed,
    observed,
)
from bath_drake.notation import ByteArray, FloatArray
from bath_drake.patient.people import shipped_people
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.colour_noise import ColourNoiseConfig, noisy_colour
from bath_drake.perception.ellipses import level
from bath_drake.perception.map_follower import frame_map
from bath_drake.perception.restricted import find_restricted_areas

# What each does to red, green and blue of the skin it is on.
KINDS = {
    "dark": (0.4, 0.35, 0.35),
    "red": (1.05, 0.6, 0.6),
    "mildly_red": (1.0, 0.82, 0.82),
    "bruised": (0.75, 0.75, 1.0),
    "pale": (1.0, 1.2, 1.35),
}
# s: ten bends of the back; each with one kind in turn, by two lights.
TIMES = np.arange(0.0, 15.0, 1.5)
EXPOSURES = (1.0, 0.5)
MARGIN_M = 0.02
# In N.
REACH, SEMI_AXES = 0.6, (0.15, 0.1)
# An area counts as found if so much of it is inside one ellipse.
WHOLE = 0.98


@dataclass(eq=False)
class Counted:
    """What was counted.

    Attributes:
        clear: Frames of plain skin.
        false_alarms: Those of them in which something was found.
        found: Whether each of the areas was found, by kind.
        seconds: For each search.
    """

    clear: int = 0
    false_alarms: int = 0
    found: dict[str, list[bool]] = field(
        default_factory=lambda: {kind: [] for kind in KINDS}
    )
    seconds: list[float] = field(default_factory=list)


def run(progress: Progress) -> list[Figure]:
    """Paints areas on all people, bending, in two lights, and looks for them."""
    counted, people = Counted(), shipped_people()
    rng = np.random.default_rng(0)
    for k, name in enumerate(people):
        progress(f"{name}, areas", k / len(people))
        film = filmed(name, BENDING)
        for frame in film.frames(TIMES):
            for exposure in EXPOSURES:
                _look(film, frame, exposure, rng, counted)
    figures = [
        Figure("areas_false_alarms", counted.false_alarms / counted.clear, "", 0.0),
        Figure("areas_time", 1e3 * float(np.median(counted.seconds)), "ms"),
    ]
    for kind, found in counted.found.items():
        share = float(np.mean(found))
        figures.append(Figure(f"areas_found_{kind}", share, "", 1.0, "at least"))
    return figures


def _look(
    film: Filmed,
    frame: Frame,
    exposure: float,
    rng: np.random.Generator,
    counted: Counted,
) -> None:
    """Counts a frame of plain skin, and the same with an area painted on it."""
    plain = _seen(film, frame, frame.colour, exposure)
    canonical_map = frame_map(plain)
    begin = time.perf_counter()
    alarms = find_restricted_areas(plain, canonical_map, MARGIN_M)
    counted.seconds.append(time.perf_counter() - begin)
    counted.clear += 1
    counted.false_alarms += len(alarms) > 0
    kind = list(KINDS)[counted.clear % len(KINDS)]
    place = np.array([*rng.uniform(-REACH, REACH, 2), *SEMI_AXES, rng.uniform(0, 3)])
    inside = level(place, canonical_map.canonical_from_world(plain.points_W)) <= 1.0
    columns, rows = plain.pixels[inside].T
    painted = frame.colour.astype(np.float64)
    painted[rows, columns, :3] *= KINDS[kind]
    colour = np.clip(painted, 0.0, 255.0).astype(np.uint8)
    worn = _seen(film, frame, colour, exposure)
    counted.found[kind].append(
        worn.found and _held(worn, canonical_map, plain.points_W[inside])
    )


def _held(
    worn: BodyObservation, canonical_map: CanonicalMap, points_W: FloatArray
) -> bool:
    """Whether one area found holds the points (n, 3) that were painted."""
    p_N = canonical_map.canonical_from_world(points_W)
    found = find_restricted_areas(worn, canonical_map, MARGIN_M)
    return any(bool((level(row, p_N) <= 1.0).mean() >= WHOLE) for row in found.theta)


def _seen(
    film: Filmed, frame: Frame, colour: ByteArray, exposure: float
) -> BodyObservation:
    noisy = noisy_colour(
        colour,
        ColourNoiseConfig(exposure=exposure),
        seed=0,
        frame=round(10.0 * frame.t),
        t=frame.t,
    )
    return observed(film, replace(frame, colour=noisy), None)
