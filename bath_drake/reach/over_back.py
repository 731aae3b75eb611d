"""Where the arm gets all over the back."""

from dataclasses import dataclass

import numpy as np

from bath_drake.notation import BoolArray, FloatArray
from bath_drake.reach.along_path import Manner, descent
from bath_drake.reach.back import Back, PosedBack, nozzle_poses
from bath_drake.reach.follow import follow
from bath_drake.reach.judge import Cause, Places, judge, nowhere, worst
from bath_drake.reach.kinematics import ArmModel

# Of the map's grid, in N.
PITCH, REACH = 0.1, 1.0

_Cell = tuple[int, int]


def grid(reach: float = REACH, pitch: float = PITCH) -> FloatArray:
    """Returns the canonical points (k, k, 2) of a map, rows from the seat up."""
    half = round(reach / pitch)
    steps = pitch * np.arange(-half, half + 1)
    return np.stack(np.meshgrid(steps, steps), axis=-1)


def over(
    arm: ArmModel,
    back: Back,
    manner: Manner,
    points_N: FloatArray | None = None,
) -> Places:
    """Goes all over the back: from home to its middle, up and down, and to the sides.

    And back again, for the joint positions at a place depend on where the arm came
    from; the worse of both counts, and the worst of the person's poses.

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
    return worst([_Tour(arm, posed, points_N, manner).all() for posed in back.poses])


@dataclass(frozen=True, eq=False)
class _Leg:
    """A straight piece of the tour.

    Attributes:
        cells: As far as there is skin.
        q: (n, 7) the arm's positions there, rad.
    """

    cells: list[_Cell]
    q: FloatArray


class _Tour:
    """Over a back in one pose of the person."""

    def __init__(
        self, arm: ArmModel, posed: PosedBack, points_N: FloatArray, manner: Manner
    ) -> None:
        self._arm, self._manner, self._boxes = arm, manner, posed.boxes(arm)
        self._lag = manner.lag(posed.canonical_map.half_extents)
        self._shape = points_N.shape[:2]
        self._flat = points_N.reshape(-1, 2)
        points, normals, met = posed.skin(self._flat)
        self._points = points.reshape(*self._shape, 3)
        self._normals = normals.reshape(*self._shape, 3)
        self._skin: BoolArray = met.reshape(self._shape)
        self._out, self._back = nowhere(self._flat), nowhere(self._flat)

    def all(self) -> Places:
        """All places, the worse of both ways."""
        arm, (rows, columns) = self._arm, self._shape
        row, column = rows // 2, columns // 2
        middle = self._points[row, column], self._normals[row, column]
        q = follow(arm, descent(arm, *middle, self._manner), self._boxes).q[-1]
        upwards = self._leg(q, [(i, column) for i in range(row, rows)])
        downwards = self._leg(q, [(i, column) for i in range(row, -1, -1)])
        for trunk in (upwards, downwards):
            for (i, _), there in zip(trunk.cells, trunk.q, strict=True):
                self._leg(there, [(i, j) for j in range(column, columns)])
                self._leg(there, [(i, j) for j in range(column, -1, -1)])
        only_out = self._back.cause == Cause.NO_SKIN
        for name, value in vars(self._back).items():
            value[only_out] = getattr(self._out, name)[only_out]
        return worst([self._out, self._back])

    def _leg(self, q: FloatArray, cells: list[_Cell]) -> _Leg:
        """Out, and back from as far as it was reached without a gap."""
        gap = next((k for k, c in enumerate(cells) if not self._skin[c]), len(cells))
        cells = cells[:gap]
        if not cells:
            return _Leg([], np.zeros((0, len(q))))
        out, positions = self._go(q, cells, self._out)
        failed = np.flatnonzero(out.cause > Cause.NO_SKIN)
        far = int(failed[0]) if len(failed) else len(cells)
        if far > 1:
            self._go(positions[far - 1], cells[:far][::-1], self._back)
        return _Leg(cells, positions)

    def _go(
        self, q: FloatArray, cells: list[_Cell], found: Places
    ) -> tuple[Places, FloatArray]:
        """Along cells in turn; writes down what is found, returns it and q (n, 7)."""
        at = tuple(np.array(cells).T)
        wash = nozzle_poses(
            self._points[at],
            self._normals[at],
            self._manner.standoff,
            self._manner.washing_speed,
        )
        followed = follow(self._arm, wash, self._boxes, q)
        index = np.ravel_multi_index(at, self._shape)
        judged = judge(
            self._arm, self._flat[index], followed, self._manner.limits, self._lag
        )
        for name, array in vars(judged).items():
            getattr(found, name)[index] = array
        return judged, followed.q
