"""What one frame of the camera says about the back."""

from dataclasses import dataclass, field

import numpy as np

from bath_drake.notation import BoolArray, ByteArray, FloatArray, IntArray
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.completion import BackTemplate
from bath_drake.shared import Shared

# Seated people change their posture in some such time, s.
BELIEF_TIME = 5.0


def _empty(*shape: int) -> FloatArray:
    return np.zeros(shape)


@dataclass(frozen=True, eq=False)
class BodyObservation(Shared):
    """What one frame says about the back; nothing but camera and joints went in.

    Attributes:
        stamp: When the images were taken, seconds; -inf before the first frame.
        mask: (H, W) visible back, restricted areas (holes) included.
        robot_mask: (H, W) where the robot is or may be.
        points_W: (n, 3) visible points of the back, metres.
        pixels: (n, 2) their columns and rows.
        colours: (n, 3) their colours, RGB.
        point_areas: (n,) surface each stands for, m^2.
        completed_points_W: (m, 3) the visible points and those guessed behind the
            robot; for axes and extents only, never for the surface. Where the body
            is not found they are those of the last frame in which it was.
        completed_areas: (m,) surface each of them stands for, m^2.
        completed_ages: (m,) how long ago each of them was seen, s: zero for the visible
            ones, infinite for what was never seen but guessed by a smooth fit.
        area: Visible skin of the back, m^2.
        template: The back as it was when nothing hid it; None until then.
        tracked_map: What the template is carried along with, a map of every fourth
            completed point; of the last frame in which the body was found.
        reference_area: Largest such area seen so far, this frame included, m^2.
        visible_fraction: `area` over `reference_area`.
        found: Whether enough of the back is visible to go on.
        unfound_since: When the first frame in a row was taken in which it was not, s;
            infinite where it is found.
        R_WC: (3, 3) orientation of the camera in W.
        p_WC: (3,) position of the camera in W, metres.
        camera: Whose image it is; None where there is none.
    """

    stamp: float = -np.inf
    mask: BoolArray = field(default_factory=lambda: np.zeros((0, 0), dtype=bool))
    robot_mask: BoolArray = field(default_factory=lambda: np.zeros((0, 0), dtype=bool))
    points_W: FloatArray = field(default_factory=lambda: _empty(0, 3))
    pixels: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    colours: ByteArray = field(default_factory=lambda: np.zeros((0, 3), dtype=np.uint8))
    point_areas: FloatArray = field(default_factory=lambda: _empty(0))
    completed_points_W: FloatArray = field(default_factory=lambda: _empty(0, 3))
    completed_areas: FloatArray = field(default_factory=lambda: _empty(0))
    completed_ages: FloatArray = field(default_factory=lambda: _empty(0))
    area: float = 0.0
    template: BackTemplate | None = None
    tracked_map: CanonicalMap | None = None
    reference_area: float = 0.0
    visible_fraction: float = 0.0
    found: bool = False
    unfound_since: float = np.inf
    R_WC: FloatArray = field(default_factory=lambda: np.eye(3))
    p_WC: FloatArray = field(default_factory=lambda: _empty(3))
    camera: PinholeCamera | None = None

    @property
    def hidden_share(self) -> float:
        """Share of the completed back that is not seen in this frame; 1 of nothing."""
        whole = float(self.completed_areas.sum())
        hidden = float(self.completed_areas[self.completed_ages > 0.0].sum())
        return hidden / whole if whole > 0.0 else 1.0

    @property
    def completion_quality(self) -> float:
        """How far the filled-in skin can be believed, from 0 to 1.

        The mean over its area of exp(-age / `BELIEF_TIME`); 1 where nothing is filled
        in, 0 where all of it is a guess.
        """
        filled = self.completed_ages > 0.0
        if not filled.any():
            return 1.0 if len(filled) > 0 else 0.0
        areas, ages = self.completed_areas[filled], self.completed_ages[filled]
        return float(np.average(np.exp(-ages / BELIEF_TIME), weights=areas))

    def lost(self, lost_time: float) -> bool:
        """Whether the back has not been found for `lost_time` seconds of frames."""
        # Time stamps in steps of a camera period accumulate rounding.
        return self.stamp - self.unfound_since >= lost_time - 1e-9

    def __post_init__(self) -> None:
        """Makes the arrays read-only: whoever holds an observation shares it."""
        for name, value in list(vars(self).items()):
            if isinstance(value, np.ndarray):
                shared = value.view()
                shared.setflags(write=False)
                object.__setattr__(self, name, shared)
