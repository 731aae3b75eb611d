"""Follows a rigid surface through depth images: point-to-plane ICP by projection.

Each point of the surface is compared with the depth of the pixel it projects to
[Rusinkiewicz and Levoy, Efficient variants of the ICP algorithm, 2001]. Tukey's
weights leave out what is not the surface: the carer's arm in front of it, the room
behind its edge.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.spatial.transform import Rotation

from bath_drake.notation import FloatArray
from bath_drake.perception.camera import PinholeCamera

# Residuals beyond this have no weight, m: from the first step to the last.
WIDE, NARROW = 0.03, 0.012
STEPS = 12
# A step smaller than this changes no pixel: m and rad.
ENOUGH = 2e-5
# Fewer points with weight hold no six numbers against noise.
MIN_POINTS = 200


@dataclass(frozen=True, eq=False)
class RigidSurface:
    """Points of a rigid surface and their outward normals, in a frame of its own.

    Attributes:
        points: (n, 3) m.
        normals: (n, 3) unit.
    """

    points: FloatArray
    normals: FloatArray


@dataclass(frozen=True, eq=False)
class TrackedPose:
    """Where a surface is in a camera's frame C.

    Attributes:
        R: (3, 3) rotation from the surface's frame to C.
        p: (3,) the surface's origin in C, m.
        share: Share of the points that found their surface.
        rms: Of their residuals, m.
    """

    R: FloatArray
    p: FloatArray
    share: float
    rms: float

    def to_camera(self, points: FloatArray) -> FloatArray:
        """Takes points (..., 3) of the surface's frame to C."""
        return np.asarray(points @ self.R.T + self.p)

    def from_camera(self, points: FloatArray) -> FloatArray:
        """Takes points (..., 3) of C to the surface's frame."""
        return np.asarray((points - self.p) @ self.R)


AT_REST = TrackedPose(np.eye(3), np.zeros(3), 1.0, 0.0)


def track(
    surface: RigidSurface,
    depth: FloatArray,
    camera: PinholeCamera,
    start: TrackedPose,
    wide: float = WIDE,
) -> TrackedPose:
    """Finds the surface in a depth image.

    Args:
        surface: What to find.
        depth: (H, W) m, 0 where unknown.
        camera: Whose image it is.
        start: Where it was the frame before.
        wide: The first step's bound on residuals, m.

    Returns:
        Its pose; `share` is 0 if too little of it was found.
    """
    R, p = start.R, start.p
    count, square = 0, 0.0
    pinhole = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
    for step in range(STEPS):
        reach = max(wide * (NARROW / wide) ** (step / (STEPS // 2)), NARROW)
        matrix, vector, count, square = _normal_equations(
            surface.points, surface.normals, depth, pinhole, R, p, reach
        )
        if count < MIN_POINTS:
            return TrackedPose(start.R, start.p, 0.0, 0.0)
        twist = np.linalg.solve(matrix + 1e-9 * np.trace(matrix) * np.eye(6), vector)
        turn = Rotation.from_rotvec(twist[:3]).as_matrix()
        centre = R @ surface.points.mean(axis=0) + p
        R, p = turn @ R, turn @ (p - centre) + centre + twist[3:]
        if np.abs(twist).max() < ENOUGH and reach == NARROW:
            break
    share = count / len(surface.points)
    return TrackedPose(R, p, share, float(np.sqrt(square / count)))


@njit(cache=True)
def _normal_equations(
    points: FloatArray,
    normals: FloatArray,
    depth: FloatArray,
    pinhole: FloatArray,
    R: FloatArray,
    p: FloatArray,
    reach: float,
) -> tuple[FloatArray, FloatArray, int, float]:
    """Sums up J'WJ, J'Wr, the points with weight and their squared residuals."""
    rows, columns = depth.shape
    fx, fy, cx, cy = pinhole
    matrix, vector = np.zeros((6, 6)), np.zeros(6)
    J = np.empty(6)
    q, n, m = np.empty(3), np.empty(3), np.empty(3)
    mean = np.zeros(3)
    for i in range(len(points)):
        for k in range(3):
            mean[k] += points[i, k] / len(points)
    centre = np.empty(3)
    for k in range(3):
        centre[k] = R[k, 0] * mean[0] + R[k, 1] * mean[1] + R[k, 2] * mean[2] + p[k]
    count, square = 0, 0.0
    for i in range(len(points)):
        for k in range(3):
            q[k] = p[k]
            n[k] = 0.0
            for c in range(3):
                q[k] += R[k, c] * points[i, c]
                n[k] += R[k, c] * normals[i, c]
        if q[2] <= 0.05:
            continue
        u, v = fx * q[0] / q[2] + cx, fy * q[1] / q[2] + cy
        if not (0.0 <= u < columns and 0.0 <= v < rows):
            continue
        column, row = int(u), int(v)
        z = depth[row, column]
        if not z > 0.0:
            continue
        m[0] = (column + 0.5 - cx) / fx * z
        m[1] = (row + 0.5 - cy) / fy * z
        m[2] = z
        r = 0.0
        for k in range(3):
            r += n[k] * (m[k] - q[k])
        if abs(r) >= reach or abs(z - q[2]) >= 3.0 * reach:
            continue
        weight = (1.0 - (r / reach) ** 2) ** 2
        a0, a1, a2 = q[0] - centre[0], q[1] - centre[1], q[2] - centre[2]
        J[0] = a1 * n[2] - a2 * n[1]
        J[1] = a2 * n[0] - a0 * n[2]
        J[2] = a0 * n[1] - a1 * n[0]
        J[3], J[4], J[5] = n[0], n[1], n[2]
        for a in range(6):
            vector[a] += weight * J[a] * r
            for b in range(6):
                matrix[a, b] += weight * J[a] * J[b]
        count += 1
        square += r * r
    return matrix, vector, count, square
