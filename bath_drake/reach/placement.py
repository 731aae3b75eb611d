"""From where the base would do better: a search over a grid of places and yaws."""

import itertools
from dataclasses import dataclass, field

import numpy as np

from bath_drake.notation import FloatArray
from bath_drake.reach.along_path import Manner, descent, even
from bath_drake.reach.back import Back, nozzle_poses
from bath_drake.reach.clearance import clearance, pedestal_clearance
from bath_drake.reach.follow import follow, joined
from bath_drake.reach.judge import Cause, judge
from bath_drake.reach.kinematics import ArmModel
from bath_drake.reach.over_back import grid, over

# The path and the back are looked at in such steps, in N: coarser than the precheck.
_PATH_STEP, _PITCH, _REACH = 0.06, 0.25, 0.75
# So many of the best places are looked at in every pose of the person.
_FINALISTS = 12
# Kept by the arm and its pedestal to the person, m.
_LEAST_CLEARANCE, _LEAST_PEDESTAL = 0.03, 0.05
# What is mapped of the floor, about the base, m.
_FLOOR = 0.1 * np.arange(-3, 4)
# A condition number worse than this is as bad as any.
_HOPELESS = 100.0


@dataclass(frozen=True, eq=False, kw_only=True)
class PlacementGrid:
    """Where a base may stand, relative to where it stands: m and rad."""

    x: list[float] = field(default_factory=lambda: [-0.2, -0.1, 0.0, 0.1, 0.2, 0.3])
    y: list[float] = field(default_factory=lambda: [-0.2, -0.1, 0.0, 0.1, 0.2])
    z: list[float] = field(default_factory=lambda: [-0.15, 0.0, 0.15, 0.3, 0.45])
    yaw: list[float] = field(default_factory=lambda: [-0.4, 0.0, 0.4])


@dataclass(frozen=True, eq=False)
class Placement:
    """A place of the base and what it is worth.

    Attributes:
        position: (3,) of the base in W, m.
        yaw: Of the base, rad.
        path_share: Of the path's points, how many are reached.
        condition: Greatest condition number on the path.
        clearance: Of the arm's links from the person, on the path, m.
    """

    position: FloatArray
    yaw: float
    path_share: float
    condition: float
    clearance: float

    @property
    def better(self) -> tuple[bool, float, float]:
        """The greater, the better: clear of the person, share, condition."""
        free = self.clearance >= _LEAST_CLEARANCE
        return free, self.path_share, -min(self.condition, _HOPELESS)


@dataclass(frozen=True, eq=False)
class PlacementMap:
    """How much of the back is reached from places of one height and yaw.

    Attributes:
        x: (n,) m in W.
        y: (m,) m in W.
        z: Height of the base, m.
        yaw: Of the base, rad.
        share: (m, n) of the back within |x|, |y| <= 0.75 of N; NaN where the pedestal
            would be in the person's way.
        path_share: (m, n) of the path.
        here: Where the base stands.
        best: The best of the places searched.
    """

    x: FloatArray
    y: FloatArray
    z: float
    yaw: float
    share: FloatArray
    path_share: FloatArray
    here: Placement
    best: Placement


def search_placement(
    arm: ArmModel,
    back: Back,
    path_N: FloatArray,
    body_W: FloatArray,
    manner: Manner,
    places: PlacementGrid | None = None,
) -> tuple[Placement, Placement]:
    """Tries every place of a grid around the base; no chance in it.

    Home and posture stay: they are joint positions. All places are tried with the
    person at rest, the best of them with the person in every pose.

    Args:
        arm: Where it stands now.
        back: Of the person.
        path_N: (n, 2) what is to be washed.
        body_W: (m, 3) the person's body, as of `body_points`.
        manner: How to move.
        places: Where to look; None for the default.

    Returns:
        The place it stands at, and the best one; that may be the same.
    """
    places = PlacementGrid() if places is None else places
    path = _Path(back, path_N, body_W, manner)
    found = [
        (path.placed(arm, moved, yaw, poses=1), shift)
        for shift, moved, yaw in _candidates(arm, body_W, places)
    ]
    # The nearest of equals; then in the grid's order.
    found.sort(key=lambda pair: (*(-float(v) for v in pair[0].better), pair[1]))
    here = path.placed(arm, arm.X_WB[:3, 3], _yaw(arm), poses=len(back.poses))
    finalists = [
        path.placed(arm, place.position, place.yaw, poses=len(back.poses))
        for place, _ in found[:_FINALISTS]
    ]
    return here, max([here, *finalists], key=lambda place: place.better)


def placement_map(
    arm: ArmModel,
    back: Back,
    path_N: FloatArray,
    body_W: FloatArray,
    manner: Manner,
    best: Placement | None = None,
) -> PlacementMap:
    """Maps the shares of back and path over the floor, with the person at rest.

    Args:
        arm: Where it stands now.
        back: Of the person.
        path_N: (n, 2) what is to be washed.
        body_W: (m, 3) the person's body, as of `body_points`.
        manner: How to move.
        best: What a search found: the map is at its height and yaw; None for those of
            where it stands.
    """
    resting = Back(back.poses[:1], back.areas)
    path = _Path(resting, path_N, body_W, manner)
    here = path.placed(arm, arm.X_WB[:3, 3], _yaw(arm), poses=1)
    best = here if best is None else best
    x, y = (np.round(_FLOOR + arm.X_WB[k, 3], 4) for k in range(2))
    points = grid(_REACH, _PITCH)
    share, path_share = (np.full((len(y), len(x)), np.nan) for _ in range(2))
    for i, j in itertools.product(range(len(y)), range(len(x))):
        position = np.array([x[j], y[i], best.position[2]])
        there = arm.at(position, best.yaw)
        if pedestal_clearance(there, body_W) < _LEAST_PEDESTAL:
            continue
        share[i, j] = over(there, resting, manner, points).share
        path_share[i, j] = path.placed(arm, position, best.yaw, poses=1).path_share
    return PlacementMap(
        x, y, float(best.position[2]), best.yaw, share, path_share, here, best
    )


class _Path:
    """A path's skin in every pose of the person, found once."""

    def __init__(
        self, back: Back, path_N: FloatArray, body_W: FloatArray, manner: Manner
    ) -> None:
        self._path_N = even(path_N, _PATH_STEP)
        self._skins = [(posed, posed.skin(self._path_N)[:2]) for posed in back.poses]
        self._body_W, self._manner = body_W, manner

    def placed(
        self, arm: ArmModel, position: FloatArray, yaw: float, poses: int
    ) -> Placement:
        """What a place is worth, with the person in so many poses."""
        there, manner = arm.at(position, yaw), self._manner
        reached = np.ones(len(self._path_N), dtype=bool)
        condition, clear = 0.0, np.inf
        for posed, (points, normals) in self._skins[:poses]:
            begin = descent(there, points[0], normals[0], manner)
            wash = nozzle_poses(points, normals, manner.standoff, manner.washing_speed)
            followed = follow(there, joined([begin, wash]), posed.boxes(there))
            cells = np.concatenate(
                [np.repeat(self._path_N[:1], len(begin), 0), self._path_N]
            )
            lag = manner.lag(posed.canonical_map.half_extents)
            judged = judge(there, cells, followed, manner.limits, lag)
            well = judged.cause == Cause.NONE
            reached &= well[len(begin) :]
            reached[0] &= bool(well[: len(begin)].all())
            condition = max(condition, float(judged.condition.max()))
            washing = followed.q[len(begin) :: 3]
            clear = min(clear, clearance(there, self._body_W, washing))
        return Placement(
            np.array(position), float(yaw), float(reached.mean()), condition, clear
        )


def _candidates(
    arm: ArmModel, body_W: FloatArray, places: PlacementGrid
) -> list[tuple[float, FloatArray, float]]:
    """How far from here, where, and yaw; those that would stand free on the floor."""
    found = []
    for dx, dy, dz, turn in itertools.product(places.x, places.y, places.z, places.yaw):
        position, yaw = arm.X_WB[:3, 3] + [dx, dy, dz], _yaw(arm) + turn
        there = arm.at(position, yaw)
        if position[2] < 0.0 or pedestal_clearance(there, body_W) < _LEAST_PEDESTAL:
            continue
        shift = float(np.linalg.norm([dx, dy, dz])) + 0.3 * abs(turn)
        found.append((shift, position, yaw))
    return found


def _yaw(arm: ArmModel) -> float:
    return float(np.arctan2(arm.X_WB[1, 0], arm.X_WB[0, 0]))
