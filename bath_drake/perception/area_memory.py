"""What is remembered of restricted areas from frame to frame.

An area is kept off from the first frame that shows it. Seen again and again it is
confirmed, and stays for the run: lather over a wound does not make it skin. One that
a few frames showed and that then is plain skin in full view was the camera's noise, and
is forgotten.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from bath_drake.field.obstacles import ObstacleSet
from bath_drake.notation import FloatArray
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.ellipses import least_ellipse, level, meet, outline
from bath_drake.shared import Shared

# A place is in full view if so much of its ellipse is skin that is seen.
IN_VIEW = 0.5
# m^2: less skin than the smallest area has says nothing of one.
LEAST_SKIN = 2e-4


@dataclass(frozen=True, eq=False)
class Tentative:
    """An area that few frames have shown.

    Attributes:
        ellipse: (5,) in N, around all that was seen of it.
        frames: How many have shown it.
        doubted: Since when its place has been in full view and clear, s; infinite
            while it is not.
    """

    ellipse: FloatArray
    frames: int = 1
    doubted: float = math.inf


@dataclass(frozen=True, eq=False)
class AreaMemory(Shared):
    """The areas known, in N.

    Attributes:
        confirmed: Those that stay.
        tentative: Those that few frames have shown.
    """

    confirmed: ObstacleSet = field(default_factory=ObstacleSet)
    tentative: tuple[Tentative, ...] = ()

    @property
    def areas(self) -> ObstacleSet:
        """All areas to keep off; of those that meet, one ellipse around all."""
        rows = [one.ellipse for one in self.tentative]
        return merge_areas(self.confirmed, ObstacleSet(np.reshape(rows, (-1, 5))))


@dataclass(frozen=True, kw_only=True)
class AreaKeeper:
    """When an area is confirmed and when forgotten.

    Attributes:
        confirm_frames: Seen in so many frames it stays.
        forget_time: Not confirmed, and in full view clear for so long, s, it goes.

    Raises:
        ValueError: Unless both are positive and finite.
    """

    confirm_frames: int = 5
    forget_time: float = 1.0

    def __post_init__(self) -> None:
        """Checks both numbers."""
        for name, value in vars(self).items():
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} must be positive and finite, got {value}")

    def next(
        self,
        memory: AreaMemory,
        seen: ObstacleSet,
        stamp: float,
        in_view: Callable[[FloatArray], bool],
    ) -> AreaMemory:
        """Returns what is remembered after a frame.

        Args:
            memory: What was.
            seen: The areas that the frame shows, in N.
            stamp: When it was taken, s.
            in_view: Whether the skin in an ellipse (5,) of N is in full view.
        """
        confirmed, left = memory.confirmed, list(memory.tentative)
        tentative = []
        for row in merge_areas(ObstacleSet(), seen).theta:
            near = [one for one in left if meet(one.ellipse, row)]
            left = [one for one in left if not meet(one.ellipse, row)]
            grown = ObstacleSet(row[None])
            for one in near:
                grown = merge_areas(ObstacleSet(one.ellipse[None]), grown)
            frames = 1 + max((one.frames for one in near), default=0)
            known = any(meet(row, area) for area in confirmed.theta)
            if known or frames >= self.confirm_frames:
                confirmed = merge_areas(confirmed, grown)
            else:
                tentative.append(Tentative(grown.theta[0], frames))
        for one in left:
            doubted = min(one.doubted, stamp) if in_view(one.ellipse) else math.inf
            # Stamps in steps of a camera's period accumulate rounding.
            if stamp - doubted < self.forget_time - 1e-9:
                tentative.append(replace(one, doubted=doubted))
        return AreaMemory(confirmed, tuple(tentative))


def seen_in_full(
    ellipse: FloatArray, observation: BodyObservation, canonical_map: CanonicalMap
) -> bool:
    """Whether most of the skin in an ellipse (5,) of N is seen in a frame.

    How much skin there is, a template of the back tells: at its rim an ellipse reaches
    beyond. Where it knows of none nothing is in view.
    """
    size = np.pi * ellipse[2] * ellipse[3] * canonical_map.half_extents.prod()
    template, tracked = observation.template, observation.tracked_map
    if template is not None and tracked is not None:
        known = canonical_map.canonical_from_world(template.points_in_world(tracked))
        size = min(size, template.areas[level(ellipse, known) <= 1.0].sum())
    p_N = canonical_map.canonical_from_world(observation.points_W)
    seen = observation.point_areas[level(ellipse, p_N) <= 1.0].sum()
    return bool(size >= LEAST_SKIN and seen >= IN_VIEW * size)


def merge_areas(
    known: ObstacleSet, seen: ObstacleSet, tolerance: float = 0.05
) -> ObstacleSet:
    """Adds what is seen now to what was known: no area shrinks or goes away.

    Half hidden by the robot, a wound looks smaller than it is.

    Args:
        known: Areas in N from the frames before.
        seen: Areas in N of this frame.
        tolerance: What sticks out of a known area by less than this share of its
            size is the camera's noise and does not enlarge it.

    Returns:
        The areas from now on: a seen one inside a known one changes nothing; one
        that meets known ones makes one ellipse around all of them; another is added.
    """
    areas = [np.array(row) for row in known.theta]
    for row in seen.theta:
        around = outline(row)
        if any(level(area, around).max() <= (1.0 + tolerance) ** 2 for area in areas):
            continue
        together = [area for area in areas if meet(area, row)]
        areas = [area for area in areas if not meet(area, row)]
        corners = [outline(area) for area in together]
        if all(level(row, other).max() <= 1.0 for other in corners):
            areas.append(row)  # new, or around all it meets
        else:
            areas.append(least_ellipse(np.concatenate([around, *corners])))
    return ObstacleSet(np.array(areas).reshape(-1, 5))
