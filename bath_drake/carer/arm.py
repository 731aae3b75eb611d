"""The carer's hand and arm, which follow the marker.

The hand holds the marker from the carer's side and a little from below; the forearm
ends at an elbow that hangs down and lags behind; the carer leans after the hand with
the shoulder. Lengths are those of a grown-up of middle size.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.carer.skin_path import SkinPath
from bath_drake.notation import FloatArray

# A rigid part's pose in W: rotation (3, 3) and origin (3,), m.
Pose = tuple[FloatArray, FloatArray]

PARTS = ("marker", "hand", "forearm", "upper_arm", "trunk")

# m, along the marker's stick: from the ball's centre to where the fingers hold it.
GRIP = 0.055
HAND, FOREARM, UPPER_ARM = 0.115, 0.25, 0.31
# The stick's lean from the skin's normal to the carer's side.
_LEAN = np.deg2rad(42.0)
# From the fingers to the wrist: how far off the skin, over how far along it.
_WRIST_RISE = 0.55
# To the carer's side, and down, in the skin's plane.
_SIDE, _DOWN = 1.0, 0.55
# s, by which elbow and shoulder are late; share of the way that the shoulder follows.
_ELBOW_LAG, _SHOULDER_LAG = 0.12, 0.35
_LEANING = 0.55
# The shoulder at rest, from the middle of the back: aside, out of it, up, m.
_SHOULDER = (0.46, 0.26, 0.26)
# Of the arm's whole length: an arm is never quite straight, nor folded.
_REACH = (0.45, 0.97)
_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class CarerArm:
    """Poses of the carer's parts over time.

    Attributes:
        path: Of the marker on the skin, in M.
        marker_radius: m.
        middle_W: (3,) middle of the back while the person rests, m.
        aside_W: (3,) unit, level, to the side on which the carer stands.
        outward_W: (3,) unit, out of the back.
        swing: The hand turns about the marker by this, to and fro, rad.
        swing_period: s.
    """

    path: SkinPath
    marker_radius: float
    middle_W: FloatArray
    aside_W: FloatArray
    outward_W: FloatArray
    swing: float
    swing_period: float

    def marker(self, t: float, X_WM: Pose) -> tuple[FloatArray, FloatArray]:
        """The marker's centre in W (3,), m, and the skin's normal there (3,)."""
        R_WM, p_WM = X_WM
        normal = R_WM @ self.path.normal(t)
        contact = R_WM @ self.path.contact(t) + p_WM
        return contact + self.marker_radius * normal, normal

    def poses(self, t: float, X_WM: Pose) -> dict[str, Pose]:
        """The pose in W of each of `PARTS` while the person is at X_WM.

        The marker's z axis runs along its stick; the hand's x axis to the wrist, its z
        axis off the skin; the arms' z axes to elbow and shoulder. The trunk's origin
        is the shoulder, its z axis points up, its x axis to the other shoulder.
        """
        centre, normal = self.marker(t, X_WM)
        stick, to_wrist = self._grip(t, normal)
        fingers = centre + GRIP * stick
        wrist = fingers + HAND * to_wrist
        to_elbow = _unit(self._elbow(t, X_WM) - wrist)
        elbow = wrist + FOREARM * to_elbow
        to_shoulder = _unit(self._shoulder(t, X_WM) - elbow)
        shoulder = elbow + UPPER_ARM * to_shoulder
        return {
            "marker": (_frame(stick, normal), centre),
            "hand": (_hand_frame(to_wrist, normal), fingers),
            "forearm": (_frame(to_elbow, normal), wrist),
            "upper_arm": (_frame(to_shoulder, normal), elbow),
            "trunk": (_hand_frame(self.aside_W, _UP), shoulder),
        }

    def _grip(self, t: float, normal: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Directions from marker to fingers, and from fingers to wrist."""
        along = _SIDE * self.aside_W - _DOWN * _UP
        along = _unit(along - (along @ normal) * normal)
        angle = self.swing * np.sin(2.0 * np.pi * t / self.swing_period)
        along = np.cos(angle) * along + np.sin(angle) * np.cross(normal, along)
        stick = np.cos(_LEAN) * normal + np.sin(_LEAN) * along
        return np.asarray(stick), _unit(along + _WRIST_RISE * normal)

    def _wrist(self, t: float, X_WM: Pose) -> FloatArray:
        centre, normal = self.marker(t, X_WM)
        stick, to_wrist = self._grip(t, normal)
        return np.asarray(centre + GRIP * stick + HAND * to_wrist)

    def _shoulder(self, t: float, X_WM: Pose) -> FloatArray:
        aside, out, up = _SHOULDER
        rest = self.middle_W + aside * self.aside_W + out * self.outward_W + up * _UP
        hand, _ = self.marker(t - _SHOULDER_LAG, X_WM)
        return np.asarray(rest + _LEANING * (hand - self.middle_W))

    def _elbow(self, t: float, X_WM: Pose) -> FloatArray:
        """Where the elbow hangs under the line from the late wrist to the shoulder."""
        wrist = self._wrist(t - _ELBOW_LAG, X_WM)
        line = self._shoulder(t, X_WM) - wrist
        whole = FOREARM + UPPER_ARM
        distance = float(
            np.clip(np.linalg.norm(line), _REACH[0] * whole, _REACH[1] * whole)
        )
        axis = _unit(line)
        share = (FOREARM**2 - UPPER_ARM**2 + distance**2) / (2.0 * distance)
        height = np.sqrt(max(FOREARM**2 - share**2, 0.0))
        hanging = self.outward_W + self.aside_W - 2.0 * _UP
        hanging = _unit(hanging - (hanging @ axis) * axis)
        return np.asarray(wrist + share * axis + height * hanging)


def _unit(v: FloatArray) -> FloatArray:
    return np.asarray(v / np.linalg.norm(v))


def _frame(z: FloatArray, hint: FloatArray) -> FloatArray:
    """A rotation (3, 3) whose z axis is along z, its y axis across z and the hint."""
    z = _unit(z)
    across = np.cross(z, hint)
    if np.linalg.norm(across) < 1e-6:
        across = np.cross(z, [z[1], z[2], -z[0]])
    y = _unit(across)
    return np.column_stack([np.cross(y, z), y, z])


def _hand_frame(x: FloatArray, normal: FloatArray) -> FloatArray:
    z = _unit(normal - (normal @ x) * x)
    return np.column_stack([x, np.cross(z, x), z])
