"""The arm's kinematics in plain arrays, as fast as a search for its place needs."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.control.avoidance import AvoidanceConfig
from bath_drake.diagrams.control import PLANNED_MARGIN, avoidance
from bath_drake.notation import FloatArray
from bath_drake.reach import _kernels
from bath_drake.safety.arm_chain import ArmChain
from bath_drake.safety.limits import JOINTS, GuardLimits
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.scene.config import ArmConfig

# Of each joint's greatest speed: the default of `DifferentialIk`.
_SPEED_FRACTION = 0.5


@dataclass(frozen=True, eq=False)
class ArmModel:
    """An arm at its place.

    Attributes:
        chain: Its links.
        X_WB: (4, 4) the base's pose in W.
        home: (7,) joint positions that a run begins with, rad.
        posture: (7,) what the null space is drawn to, rad.
        ends: (2, 7) of the joints' ranges, rad.
        low: (7,) least positions that are planned, rad.
        high: (7,) greatest ones, rad.
        speed: (7,) rad/s.
        avoidance: How its links are kept off things.
    """

    chain: ArmChain
    X_WB: FloatArray
    home: FloatArray
    posture: FloatArray
    ends: FloatArray
    low: FloatArray
    high: FloatArray
    speed: FloatArray
    avoidance: AvoidanceConfig

    @staticmethod
    def of(config: ArmConfig, limits: GuardLimits | None = None) -> "ArmModel":
        """Returns a scenario's arm under the guard's limits; None for the shipped."""
        limits = GuardLimits() if limits is None else limits
        chain = arm_chain(config)
        ends = np.stack([chain.low, chain.high])
        margin = limits.joints.margin + PLANNED_MARGIN
        return ArmModel(
            chain=chain,
            X_WB=_base(config.base_position, config.base_yaw),
            home=np.array(config.home, dtype=np.float64),
            posture=np.array(config.posture, dtype=np.float64),
            ends=ends,
            low=ends[0] + margin,
            high=ends[1] - margin,
            speed=_SPEED_FRACTION * chain.speed,
            avoidance=avoidance(limits),
        )

    def at(self, position: ArrayLike, yaw: float) -> "ArmModel":
        """Returns the same arm on another base: place (3,) in W, m, and yaw, rad."""
        return replace(self, X_WB=_base(position, yaw))

    def nozzle(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Returns the tip's place (3,), m, and R_WE (3, 3) at q (7,)."""
        p_BE, R_BE, _ = pose_and_jacobian(q, self.chain)
        R_WB = self.X_WB[:3, :3]
        return R_WB @ p_BE + self.X_WB[:3, 3], R_WB @ R_BE

    def into_base(
        self, p_W: FloatArray, d_W: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Returns points and directions (n, 3) of W in B."""
        R_WB, p_WB = self.X_WB[:3, :3], self.X_WB[:3, 3]
        return (p_W - p_WB) @ R_WB, d_W @ R_WB

    def margin(self, q: FloatArray) -> FloatArray:
        """Returns how far positions (..., 7) are within the joints' ranges, rad."""
        inside = np.minimum(q - self.ends[0], self.ends[1] - q)
        return np.asarray(inside.min(axis=-1))


def pose_and_jacobian(
    q: FloatArray, arm: ArmChain
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Returns the tip's place (3,) in B, R_BE (3, 3) and the Jacobian's five rows.

    Those (5, 7) are in E: turns about x and y (rad/rad), then shifts (m/rad). The turn
    about the jet, z, is free and left out, as the guard leaves it out.
    """
    p, R, J = np.empty(3), np.empty((3, 3)), np.empty((5, JOINTS))
    _kernels.pose_and_jacobian(_positions(q), arm.origins, arm.turns, arm.tip, p, R, J)
    return p, R, J


def condition_number(q: FloatArray, arm: ArmChain) -> float:
    """Returns what the guard judges at q (7,): of the five directions followed.

    It is `bath_drake.safety.joint_command.condition_number` of the plant's Jacobian.
    """
    return float(_kernels.condition(pose_and_jacobian(q, arm)[2]))


def _positions(q: FloatArray) -> FloatArray:
    q = np.ascontiguousarray(q, dtype=np.float64)
    if q.shape != (JOINTS,):
        raise ValueError(f"q must have shape ({JOINTS},), got {q.shape}")
    return q


def _base(position: ArrayLike, yaw: float) -> FloatArray:
    X_WB = np.eye(4)
    c, s = np.cos(yaw), np.sin(yaw)
    X_WB[:2, :2] = [[c, -s], [s, c]]
    X_WB[:3, 3] = position
    return X_WB
