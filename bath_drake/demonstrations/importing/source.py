"""What any importer makes of a file, and what all of them ask for."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from bath_drake.demonstrations import recording
from bath_drake.demonstrations.metadata import BodyBox
from bath_drake.demonstrations.recording import LENGTH_UNITS
from bath_drake.notation import FloatArray

TIME_UNITS = recording.TIME_UNITS | {"ns": 1e-9}
# Of names in a message.
_MOST_NAMES = 20


@dataclass(frozen=True, kw_only=True)
class ImportOptions:
    """What the command line says about a file; empty or None where nothing.

    Attributes:
        units: Of lengths, one of `LENGTH_UNITS`; None: what the file says, else m.
        time_units: Of times, one of `TIME_UNITS`; None: what the file says, else s.
        columns: Names of columns or arrays by what they are: t, x, y, z, points.
        marker: Name of the hand's marker (C3D).
        body_markers: Names of right shoulder, left shoulder, right hip, left hip (C3D).
        topic: Of the hand's poses (ROS).
        motion: Name of the person's motion (MMM).
        segment: Name of the hand's segment (MMM).
        model: Path of the model file (MMM).
        start: What comes before is left out, s.
        end: What comes after is left out, s.
    """

    units: str | None = None
    time_units: str | None = None
    columns: dict[str, str]
    marker: str = ""
    body_markers: tuple[str, ...] = ()
    topic: str = ""
    motion: str = ""
    segment: str = ""
    model: str = ""
    start: float | None = None
    end: float | None = None

    def told(self) -> list[str]:
        """Names of all that is said, but for the span of time."""
        names = ("units", "time_units", "marker", "body_markers", "topic", "motion")
        said = [name for name in (*names, "segment", "model") if getattr(self, name)]
        return said + list(self.columns)

    def metres(self, of_file: str = "m") -> float:
        """The factor to metres, with what the file itself says."""
        return LENGTH_UNITS[self.units or of_file]


@dataclass(frozen=True, eq=False)
class Track:
    """A hand's path as a file has it.

    Attributes:
        t: (n,) s, as they stand in the file.
        points: (n, 2) or (n, 3) m; NaN where nothing was seen.
        what: What was read of the file, in words: a marker, a topic, columns.
        places: (n) where each sample stands, for messages: 'line 7', 'frame 3'.
        box: Of the body, in the points' frame, if the file tells.
        frame: Name of the points' frame, if the file tells.
    """

    t: FloatArray
    points: FloatArray
    what: str
    places: tuple[str, ...] = ()
    box: BodyBox | None = None
    frame: str = ""

    def place(self, k: int) -> str:
        """Where sample k stands."""
        return self.places[k] if self.places else f"sample {k + 1}"

    def between(self, start: float | None, end: float | None) -> "Track":
        """The samples of a span of time, s."""
        low = -np.inf if start is None else start
        high = np.inf if end is None else end
        # What is no time stays, for the checks to name it.
        kept = np.flatnonzero(~((self.t < low) | (self.t > high)))
        places = tuple(self.places[k] for k in kept) if self.places else ()
        return Track(
            self.t[kept], self.points[kept], self.what, places, self.box, self.frame
        )


def listed(names: Iterable[str]) -> str:
    """Names for a message, the first of them if there are many."""
    names = list(names)
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    return ", ".join(map(str, names[:_MOST_NAMES])) + more or "none"
