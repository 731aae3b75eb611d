"""`bath-drake bench capture`: captured strokes against the truth of filmed ones.

The simulated camera films a simulated carer on every person, with the noise of a Kinect
v2; the strokes are those of the table below. Seeds are fixed.
"""

import tempfile
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.benchmarks.figures import Figure, Progress, Report, Row
from bath_drake.carer.config import RubbingConfig
from bath_drake.carer_recording import CarerTruth, record_carer
from bath_drake.demonstrations.capture.demonstration import demonstration
from bath_drake.demonstrations.capture.options import CaptureOptions
from bath_drake.demonstrations.capture.pipeline import capture
from bath_drake.demonstrations.processing import canonical_demonstrations
from bath_drake.demonstrations.rgbd.folder import RgbdFolder, open_rgbd
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.scenario import load_scenario
from bath_drake.scene.sensing import begin_recording

# From the issue that asks for it, in units of N; the time is the project's own aim.
FRECHET, MILLISECONDS = 0.03, 40.0
PEOPLE = ("f_avg", "f_thin", "m_avg", "m_heavy")
CIRCLES = RubbingConfig(kind="circles", amplitude=0.1, frequency=0.8)
# The hand of these stays low, and hides the small of the back.
LOW = ([-0.45, 0.5], [-0.1, 0.4], [0.1, -0.1], [0.45, -0.4])
LOWER = ([-0.3, 0.1], [0.3, 0.1], [-0.3, -0.1])
HIDDEN = "marker hidden"
COLOURS = {"red": (210, 20, 20), "blue": (25, 60, 220), "yellow": (230, 200, 20)}


@dataclass(frozen=True)
class Film:
    """What is filmed.

    Attributes:
        stroke: Its name.
        person: Whose back.
        carer: Fields of the carer's configuration.
        rate: Frames a second.
        seed: Of noise and way-points.
        said: What is said of the marker.
    """

    stroke: str
    person: str
    carer: dict[str, Any] = field(default_factory=dict)
    rate: float = 15.0
    seed: int = 0
    said: CaptureOptions = field(default_factory=CaptureOptions)


@dataclass(frozen=True)
class Found:
    """How a captured stroke compares with the true one.

    Attributes:
        frechet: Discrete Fréchet distance of the points in N.
        over_side: The same over the longest side of the true stroke's box.
        milliseconds: A frame, reading included.
        open_gaps: Longer than what is filled.
    """

    frechet: float
    over_side: float
    milliseconds: float
    open_gaps: int


def films() -> list[Film]:
    """All that are made, those of one stroke together."""
    made = []
    shown = {"demonstration": "back_sinusoid_1.csv", "rubbing": CIRCLES}
    still: dict[str, Any] = {"demonstration": None, "seconds": 8.0}
    for person in PEOPLE:
        made.append(Film("way-points", person, still | {"rubbing": None}))
        made.append(Film("circles", person, shown))
    for k, person in enumerate(PEOPLE):
        for rubbing, seed in ((None, 2 * k), (CIRCLES, 2 * k + 1)):
            ways = np.random.default_rng([31, seed]).uniform(-0.7, 0.7, (4, 2))
            carer = still | {"waypoints": ways.tolist(), "rubbing": rubbing}
            name = "random" if rubbing is None else "random, circles"
            made.append(Film(name, person, carer | {"seconds": 6.0}, 7.5, seed))
    for points, rubbing in ((LOW, None), (LOW, CIRCLES), (LOWER, CIRCLES)):
        low = still | {"waypoints": list(points), "rubbing": rubbing}
        made.append(Film("hand low", "m_avg", low, 10.0))
    hiding = still | {"rubbing": None, "swing": 2.0, "swing_period": 4.0}
    made.append(Film(HIDDEN, "m_avg", hiding))
    for name, rgb in COLOURS.items():
        carer = still | {"rubbing": None, "seconds": 4.0}
        carer |= {"marker_colour": [c / 255.0 for c in rgb]}
        said = CaptureOptions(marker_colour=rgb)
        made.append(Film(f"{name} marker", "f_avg", carer, 7.5, said=said))
    return made


def run(progress: Progress) -> Report:
    """Films and captures all; some are captured without the camera's pose as well."""
    rows: list[Row] = []
    planned = films()
    for k, film in enumerate(planned):
        progress(f"{film.stroke}, {film.person}", k / len(planned))
        with tempfile.TemporaryDirectory() as folder:
            truth = record(Path(folder) / "film", film)
            recording = open_rgbd(Path(folder) / "film")
            rows.append(_row(film, "", judge(recording, film.said, truth)))
            if film.stroke == "way-points":
                bare = replace(recording, X_WC=None)
                rows.append(_row(film, "unknown", judge(bare, film.said, truth)))
    progress("done", 1.0)
    whole = [row for row in rows if not row["pose"] and row["stroke"] != HIDDEN]
    figures = [
        Figure(
            f"capture_frechet_{person}_max",
            max(float(row["frechet"]) for row in whole if row["person"] == person),
            "",
            FRECHET,
        )
        for person in PEOPLE
    ]
    frechet = [float(row["frechet"]) for row in whole]
    figures.append(Figure("capture_frechet_median", float(np.median(frechet))))
    met = float(np.mean([value <= FRECHET for value in frechet]))
    figures.append(Figure("capture_share_within_target", met))
    took = [float(row["ms"]) for row in rows if row["rate"] == Film.rate]
    median = float(np.median(took))
    figures.append(Figure("capture_time_a_frame", median, "ms", MILLISECONDS))
    return Report(figures, rows)


def record(folder: Path, film: Film) -> CarerTruth:
    """Makes a film in a folder that is not there yet; returns what is true of it."""
    scenario = load_scenario("demonstration")
    scenario.random_seed = film.seed
    scenario.scene.person = film.person
    scenario.perception.camera_rate = film.rate
    carer = scenario.scene.carer
    assert carer is not None  # the scenario is one of a carer
    for name, value in film.carer.items():
        setattr(carer, name, value)
    return record_carer(begin_recording(folder, scenario.scene.camera), scenario)


def judge(recording: RgbdFolder, said: CaptureOptions, truth: CarerTruth) -> Found:
    """Captures a recording and compares what is learned from with the truth."""
    begin = time.process_time()
    found = capture(recording, said)
    took = time.process_time() - begin
    stroke = demonstration(found, recording.path / "demo.csv", recording.path)
    (learned,), _ = canonical_demonstrations([stroke])
    t, p_N = np.array(truth.t), np.array(truth.p_N)
    # Before and after the stroke the hand is not on the skin.
    during = (t >= found.stroke.t[0] - 1e-6) & (t <= found.stroke.t[-1] + 1e-6)
    frechet = discrete_frechet(learned.raw, p_N[during])
    return Found(
        frechet=frechet,
        over_side=frechet / float(np.ptp(p_N[during], axis=0).max()),
        milliseconds=1e3 * took / len(recording),
        open_gaps=sum(not gap.filled for gap in found.stroke.gaps),
    )


def _row(film: Film, pose: str, found: Found) -> Row:
    return {
        "stroke": film.stroke,
        "person": film.person,
        "pose": pose,
        "rate": film.rate,
        "frechet": round(found.frechet, 4),
        "over_side": round(found.over_side, 4),
        "ms": round(found.milliseconds, 1),
        "open_gaps": found.open_gaps,
    }
