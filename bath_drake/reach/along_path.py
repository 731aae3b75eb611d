"""Where the arm gets along a path of the skill, from home on."""

from dataclasses import dataclass

import numpy as np

from bath_drake.notation import FloatArray
from bath_drake.reach.back import Back, PosedBack, nozzle_poses
from bath_drake.reach.follow import Poses, follow, joined, way_to
from bath_drake.reach.judge import Cause, Places, judge
from bath_drake.reach.kinematics import ArmModel
from bath_drake.safety.limits import GuardLimits

# Between the points of a path that are looked at, in N.
_PATH_STEP = 0.02


@dataclass(frozen=True, kw_only=True)
class Manner:
    """How the nozzle is to move, as of `bath_drake.scenario.ControlConfig`.

    Attributes:
        standoff: Of the nozzle while it washes, m.
        far_standoff: Where it lines up first, m.
        approach_speed: Along the normal, m/s.
        washing_speed: Along the skin, m/s.
        leash: How far the reference runs ahead of the nozzle, in N.
        limits: The guard's.
    """

    standoff: float = 0.06
    far_standoff: float = 0.14
    approach_speed: float = 0.05
    washing_speed: float = 0.07
    leash: float = 0.08
    limits: GuardLimits

    def lag(self, half_extents: FloatArray) -> float:
        """Returns how far behind, m, the reference waits for the nozzle in any case.

        Args:
            half_extents: (2,) of the back's box, m.
        """
        return self.leash * float(max(half_extents))


def along(
    arm: ArmModel, back: Back, path_N: FloatArray, manner: Manner
) -> list[Places]:
    """Follows a path (n, 2) in N from home on, in each pose of the person by itself.

    Returns:
        A pose's places are the path's points, at equal steps. The first stands for the
        way there as well: from home to the first stand-off, and down.
    """
    path_N = even(path_N, _PATH_STEP)
    return [_along(arm, posed, path_N, manner) for posed in back.poses]


def _along(
    arm: ArmModel, posed: PosedBack, path_N: FloatArray, manner: Manner
) -> Places:
    points, normals, _ = posed.skin(path_N)
    wash = nozzle_poses(points, normals, manner.standoff, manner.washing_speed)
    begin = descent(arm, points[0], normals[0], manner)
    found = follow(arm, joined([begin, wash]), posed.boxes(arm))
    judged = judge(
        arm,
        np.concatenate([np.repeat(path_N[:1], len(begin), 0), path_N]),
        found,
        manner.limits,
        manner.lag(posed.canonical_map.half_extents),
    )
    return _from(judged, len(begin))


def _from(places: Places, first: int) -> Places:
    """Leaves out the first ones; the worst of them is told of the next."""
    way = slice(0, first + 1)
    values = {name: array[first:].copy() for name, array in vars(places).items()}
    for name in ("condition", "place_error", "elbow"):
        values[name][0] = getattr(places, name)[way].max()
    for name in ("margin", "self_distance", "obstacle_distance"):
        values[name][0] = getattr(places, name)[way].min()
    failed = places.cause[way][places.cause[way] != Cause.NONE]
    if len(failed):
        values["cause"][0] = failed[0]
    return Places(**values)


def descent(
    arm: ArmModel, point: FloatArray, normal: FloatArray, manner: Manner
) -> Poses:
    """Returns the way from home to the far stand-off over skin, and down.

    Args:
        arm: The arm.
        point: (3,) of the skin in W, m.
        normal: (3,) outward there, unit.
        manner: How to move.
    """
    far = point + manner.far_standoff * normal
    near = point + manner.standoff * normal
    way = way_to(arm, arm.home, far, -normal)
    down = (manner.far_standoff - manner.standoff) / manner.approach_speed
    return joined([way, Poses(near[None], -normal[None], np.array([down]))])


def even(path_N: FloatArray, step: float) -> FloatArray:
    """Returns a path's points (n, 2) at equal steps of arc length, its ends included.

    Args:
        path_N: (m, 2) in N.
        step: Between two points at most, in N.
    """
    steps = np.linalg.norm(np.diff(path_N, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    count = max(2, int(np.ceil(length[-1] / step)) + 1)
    places = np.linspace(0.0, length[-1], count)
    return np.stack([np.interp(places, length, column) for column in path_N.T], axis=1)
