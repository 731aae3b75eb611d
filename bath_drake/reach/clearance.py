"""How near the arm comes to the person it washes, and its pedestal to both."""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray
from bath_drake.patient.people import Person
from bath_drake.reach.kinematics import ArmModel
from bath_drake.safety.arm_chain import NOZZLE
from bath_drake.safety.self_distance import capsule_ends
from bath_drake.scene.config import SceneConfig
from bath_drake.scene.studio import true_person_pose
from bath_drake.systems._ports import drake_vector

# Of the mesh's vertices one in so many is looked at: 1 to 2 cm apart.
_EVERY = 8
# Half the pedestal's diagonal, m.
_PEDESTAL_RADIUS = 0.17


def body_points(scene: SceneConfig, person: Person) -> FloatArray:
    """Returns places (n, 3) in W all over the person at rest, m."""
    X_WM = true_person_pose(scene, person, 0.0)
    points = np.array(X_WM.multiply(drake_vector(person.vertices[::_EVERY].T))).T
    return np.ascontiguousarray(points)


def clearance(arm: ArmModel, body_W: FloatArray, q: FloatArray) -> float:
    """Returns the least distance of the links from the body at positions (m, 7), m.

    Args:
        arm: The arm.
        body_W: (n, 3) of `body_points`.
        q: (m, 7) rad.
    """
    body_B, _ = arm.into_base(body_W, np.zeros((0, 3)))
    body_B = np.ascontiguousarray(body_B)
    # The nozzle is meant to be near the skin: its capsules, the last, are left out.
    capsules = arm.chain.capsules
    links = int(np.count_nonzero(capsules[:, 0] < NOZZLE))
    ends = np.array([capsule_ends(row, arm.chain)[:links] for row in q])
    return float(_least(body_B, ends, np.ascontiguousarray(capsules[:links, 7])))


def pedestal_clearance(arm: ArmModel, body_W: FloatArray) -> float:
    """Returns how far the pedestal stands from the body (n, 3), m; level."""
    p_WB = arm.X_WB[:3, 3]
    beside = body_W[body_W[:, 2] < p_WB[2] + 0.1]
    if not len(beside):
        return float("inf")
    away = np.linalg.norm(beside[:, :2] - p_WB[:2], axis=1)
    return float(away.min()) - _PEDESTAL_RADIUS


@njit(cache=True)
def _least(points: FloatArray, ends: FloatArray, radii: FloatArray) -> float:
    least = np.inf
    for n in range(len(ends)):
        for k in range(len(radii)):
            ax, ay, az = ends[n, k, 0]
            bx, by, bz = ends[n, k, 1]
            dx, dy, dz = bx - ax, by - ay, bz - az
            length2 = dx * dx + dy * dy + dz * dz
            for i in range(len(points)):
                wx, wy, wz = points[i, 0] - ax, points[i, 1] - ay, points[i, 2] - az
                s = (wx * dx + wy * dy + wz * dz) / length2
                s = min(max(s, 0.0), 1.0)
                gap2 = (wx - s * dx) ** 2 + (wy - s * dy) ** 2 + (wz - s * dz) ** 2
                least = min(least, np.sqrt(gap2) - radii[k])
    return least
