"""Where the arm gets: along a path of the skill, and over the whole back."""

from dataclasses import dataclass

import numpy as np

from bath_drake.notation import FloatArray
from bath_drake.reach.back import Back, PosedBack, nozzle_poses
from bath_drake.reach.follow import Followed, Poses, follow, joined, way_to
from bath_drake.reach.judge import Cause, Places, judge, nowhere, worst
from bath_drake.reach.kinematics import ArmModel
from bath_drake.safety.limits import GuardLimits

# Of the map's grid, in N.
PITCH, REACH = 0.1, 1.0
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
        limits: The guard's.
    """

    standoff: float = 0.06
    far_standoff: float = 0.14
    approach_speed: float = 0.05
    washing_speed: float = 0.07
    limits: GuardLimits


def grid(reach: float = REACH, pitch: float = PITCH) -> FloatArray:
    """Returns the canonical points (k, k, 2) of a map, rows from the seat up."""
    half = round(reach / pitch)
    steps = pitch * np.arange(-half, half + 1)
    return np.stack(np.meshgrid(steps, steps), axis=-1)


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


def over(
    arm: ArmModel,
    back: Back,
    manner: Manner,
    points_N: FloatArray | None = None,
) -> Places:
    """Goes all over the back: from home to its middle, up and down, and to the sides.

    Args:
        arm: The arm.
        back: Of the person.
        manner: How to move.
        points_N: (rows, columns, 2) a grid in N; None for `grid()`.

    Returns:
        The grid's points, row after row. One beyond a place that is not reached may be
        reached all the same.
    """
    points_N = grid() if points_N is None else points_N
    return worst([_over(arm, posed, points_N, manner) for posed in back.poses])


def _along(
    arm: ArmModel, posed: PosedBack, path_N: FloatArray, manner: Manner
) -> Places:
    points, normals, _ = posed.skin(path_N)
    wash = nozzle_poses(points, normals, manner.standoff, manner.washing_speed)
    begin = descent(arm, points[0], normals[0], manner)
    found = follow(arm, joined([begin, wash]))
    judged = judge(
        arm,
        np.concatenate([np.repeat(path_N[:1], len(begin), 0), path_N]),
        found,
        manner.limits,
    )
    return _from(judged, len(begin))


def _from(places: Places, first: int) -> Places:
    """Leaves out the first ones; the worst of them is told of the next."""
    way = slice(0, first + 1)
    values = {name: array[first:].copy() for name, array in vars(places).items()}
    for name in ("condition", "place_error", "elbow"):
        values[name][0] = getattr(places, name)[way].max()
    for name in ("margin", "self_distance"):
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


def _over(
    arm: ArmModel, posed: PosedBack, points_N: FloatArray, manner: Manner
) -> Places:
    rows, columns = points_N.shape[:2]
    flat = points_N.reshape(-1, 2)
    points, normals, met = posed.skin(flat)
    poses = (points.reshape(rows, columns, 3), normals.reshape(rows, columns, 3))
    skin = met.reshape(rows, columns)
    row, column = rows // 2, columns // 2
    found = nowhere(flat)
    begin = descent(arm, poses[0][row, column], poses[1][row, column], manner)
    q = follow(arm, begin).q[-1]

    def go(q: FloatArray, cells: list[tuple[int, int]]) -> Followed:
        """Along cells in turn; where it has been is written down, where there is."""
        at = tuple(np.array(cells).T)
        wash = nozzle_poses(
            poses[0][at], poses[1][at], manner.standoff, manner.washing_speed
        )
        followed = follow(arm, wash, q)
        index = np.ravel_multi_index(at, (rows, columns))
        judged = judge(arm, flat[index], followed, manner.limits)
        for name, array in vars(judged).items():
            getattr(found, name)[index] = array
        return followed

    def run(q: FloatArray, cells: list[tuple[int, int]]) -> list[FloatArray]:
        """As far as there is skin; returns where the arm then was."""
        count = next((k for k, cell in enumerate(cells) if not skin[cell]), len(cells))
        return list(go(q, cells[:count]).q) if count else []

    upwards = run(q, [(i, column) for i in range(row, rows)])
    downwards = run(q, [(i, column) for i in range(row, -1, -1)])
    trunk = {row + k: there for k, there in enumerate(upwards)}
    trunk |= {row - k: there for k, there in enumerate(downwards)}
    for i, there in trunk.items():
        run(there, [(i, j) for j in range(column, columns)])
        run(there, [(i, j) for j in range(column, -1, -1)])
    return found


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
