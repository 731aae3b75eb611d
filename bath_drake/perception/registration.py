"""Lays a frame's points onto the skin that is known: where is the body, how bent?

A back turns, sways and bends. To first order it bends like a rod of even curvature:
about x it flexes, about z it bends to a side, about y it twists. Rigid pose and
curvature together, nine numbers, are found by Gauss and Newton's method on the
distances along the normals.
"""

from dataclasses import dataclass, field

import numpy as np
from numba import njit

from bath_drake.notation import BoolArray, FloatArray
from bath_drake.perception.height_field import HeightField, look_up
from bath_drake.perception.offsets import less
from bath_drake.perception.turns import turn_matrix, turn_vector

# Every how many points are laid on, and how often.
STRIDE = 8
ROUNDS = 10
LEAST_ROUNDS = 3  # by then the tolerance is what it shall be

# A point this far off counts a quarter: it is not of this skin, or that moved, m.
TOLERANCE = 0.006

# At first so many times as much, then half of that and so on: a body comes some
# centimetres from frame to frame.
WIDER = 8.0

# How much the place and the turn that the outline tells are believed, as a share of
# what every point of the surface tells of its distance: along a smooth back the
# surface alone lets it slide. Shift of a square metre, turn of a radian.
SHIFT_PRIOR = 1e-3
TURN_PRIOR = 1e-5
# An outline so far off counts a quarter, m and rad: where the robot hides skin at the
# rim, what is left has its middle elsewhere.
SHIFT_TOLERANCE = 0.03
TURN_TOLERANCE = 0.1

# With less of the surface over known skin nothing is known; of a first frame, whose
# skin is full of holes, some 0.4 is.
LEAST_OVER = 0.2

# Steps shorter than this, m and rad, are the end.
STILL = 2e-5


@dataclass(frozen=True, eq=False)
class BodyPose:
    """Where a body is, and how bent.

    Attributes:
        R_WB: (3, 3) the frame of its known skin.
        p_WB: (3,) m.
        curvature: (3,) of the rod along y: flexion, twist, side bend, rad/m about the
            axes of B.
    """

    R_WB: FloatArray
    p_WB: FloatArray
    curvature: FloatArray = field(default_factory=lambda: np.zeros(3))

    def unbent(self, p_W: FloatArray) -> FloatArray:
        """Returns points (n, 3) of W in B, m, as if the body were not bent."""
        p_B = less(p_W, self.p_WB) @ self.R_WB
        return p_B - _bent_by(p_B, self.curvature)

    def bent(self, p_B: FloatArray) -> FloatArray:
        """Returns points (n, 3) of the unbent body, m, in W; to first order again."""
        return (p_B + _bent_by(p_B, self.curvature)) @ self.R_WB.T + self.p_WB


def _bent_by(p_B: FloatArray, curvature: FloatArray) -> FloatArray:
    """Returns how far (n, 3), m, the curvature moves points, to first order."""
    return _bend(np.ascontiguousarray(p_B), np.ascontiguousarray(curvature))


@njit(cache=True)
def _bend(p_B: FloatArray, curvature: FloatArray) -> FloatArray:
    """Y k x (x, 0, z) + y^2 / 2 k x e_y of each point."""
    kx, ky, kz = curvature
    moved = np.empty(p_B.shape)
    for i in range(len(p_B)):
        x, y, z = p_B[i]
        half = 0.5 * y * y
        moved[i, 0] = y * ky * z - half * kz
        moved[i, 1] = y * kz * x - y * kx * z
        moved[i, 2] = half * kx - y * ky * x
    return moved


def register(
    points_W: FloatArray,
    areas: FloatArray,
    skin: HeightField,
    start: BodyPose,
    outline: BodyPose,
) -> tuple[BodyPose, float]:
    """Finds the pose in which a frame's points lie on the known skin.

    Args:
        points_W: (n, 3) visible points, m.
        areas: (n,) surface each stands for, m^2.
        skin: What is known.
        start: Where to begin; within some centimetres and 0.2 rad.
        outline: What the outline tells of the pose; it decides only what the surface
            leaves open, the sliding along it.

    Returns:
        The pose, and how much of the surface that lies over known skin is no further
        off than `TOLERANCE`, as a share; zero if next to none lies over it.
    """
    some = np.ascontiguousarray(points_W[::STRIDE], dtype=np.float64)
    weights = np.ascontiguousarray(areas[::STRIDE], dtype=np.float64)
    total = float(weights.sum())
    pose, agreed, over = start, 0.0, 0.0
    for k in range(ROUNDS):
        normal, slope, agreed, over = _normal_equations(
            some,
            weights,
            np.ascontiguousarray(pose.R_WB),
            pose.p_WB,
            pose.curvature,
            skin.surface,
            skin.known,
            TOLERANCE * max(1.0, WIDER / 2**k),
        )
        if over < LEAST_OVER * total:
            return start, 0.0
        _believe(normal, slope, pose, outline, total)
        # What no point tells stays as it is.
        normal[np.diag_indices(9)] += 1e-9 * np.trace(normal)
        step: FloatArray = np.asarray(-np.linalg.solve(normal, slope))
        R_WB = pose.R_WB @ turn_matrix(step[:3])
        p_WB = pose.p_WB + R_WB @ step[3:6]
        pose = BodyPose(R_WB, p_WB, pose.curvature + step[6:])
        if k >= LEAST_ROUNDS and np.abs(step[:6]).max() < STILL:
            break
    return pose, agreed / over


def _believe(
    normal: FloatArray,
    slope: FloatArray,
    pose: BodyPose,
    outline: BodyPose,
    total: float,
) -> None:
    """Adds what the outline tells: the turn about z, and the place in the plane."""
    turn = turn_vector(outline.R_WB.T @ pose.R_WB)
    shift = pose.R_WB.T @ (pose.p_WB - outline.p_WB)
    away = float(np.hypot(shift[0], shift[1])) / SHIFT_TOLERANCE
    placed = SHIFT_PRIOR / (1.0 + away**2) ** 2
    turned = TURN_PRIOR / (1.0 + (turn[2] / TURN_TOLERANCE) ** 2) ** 2
    for k, weight, error in (
        (2, turned, turn[2]),
        (3, placed, shift[0]),
        (4, placed, shift[1]),
    ):
        normal[k, k] += weight * total
        slope[k] += weight * total * error


@njit(cache=True)
def _normal_equations(
    points_W: FloatArray,
    weights: FloatArray,
    R_WB: FloatArray,
    p_WB: FloatArray,
    curvature: FloatArray,
    surface: FloatArray,
    known: BoolArray,
    tolerance: float,
) -> tuple[FloatArray, FloatArray, float, float]:
    """Returns the (9, 9) and (9,) of a step, what agrees and what is over skin."""
    normal, slope = np.zeros((9, 9)), np.zeros(9)
    row, at = np.empty(9), np.empty(3)
    agreed, over = 0.0, 0.0
    kx, ky, kz = curvature
    for i in range(len(points_W)):
        px = points_W[i, 0] - p_WB[0]
        py = points_W[i, 1] - p_WB[1]
        pz = points_W[i, 2] - p_WB[2]
        x = px * R_WB[0, 0] + py * R_WB[1, 0] + pz * R_WB[2, 0]
        y = px * R_WB[0, 1] + py * R_WB[1, 1] + pz * R_WB[2, 1]
        z = px * R_WB[0, 2] + py * R_WB[1, 2] + pz * R_WB[2, 2]
        # As `_bent_by`: y k x (x, 0, z) + y^2 / 2 k x e_y.
        half = 0.5 * y * y
        x0 = x - y * ky * z + half * kz
        y0 = y - y * (kz * x - kx * z)
        z0 = z + y * ky * x - half * kx
        if not look_up(surface, known, x0, y0, at):
            continue
        length = np.sqrt(1.0 + at[1] * at[1] + at[2] * at[2])
        nx, ny, nz = -at[1] / length, -at[2] / length, 1.0 / length
        off = (z0 - at[0]) / length
        share = off / tolerance
        weight = weights[i] / (1.0 + share * share) ** 2
        over += weights[i]
        if abs(off) < TOLERANCE:
            agreed += weights[i]
        # Of the distance by a turn and a shift of B, and by the curvature.
        row[0], row[1] = -(y * nz - z * ny), -(z * nx - x * nz)
        row[2] = -(x * ny - y * nx)
        row[3], row[4], row[5] = -nx, -ny, -nz
        row[6] = y * z * ny - half * nz
        row[7] = y * (x * nz - z * nx)
        row[8] = half * nx - y * x * ny
        for j in range(9):
            scaled = weight * row[j]
            slope[j] += scaled * off
            for k in range(j + 1):
                normal[j, k] += scaled * row[k]
    for j in range(9):
        for k in range(j):
            normal[k, j] = normal[j, k]
    return normal, slope, agreed, over
