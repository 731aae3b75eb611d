"""How the seated person moves: breath, twist and lean as a whole, and the spine."""

import math
from dataclasses import dataclass, field

import numpy as np

from bath_drake.notation import FloatArray

_FASTEST_PERSON = 3.0  # m/s, along an axis
_START_TIME = 0.1  # s


@dataclass(kw_only=True)
class DepartureConfig:
    """The person goes somewhere else, as a whole, at one speed."""

    begin: float = 0.0  # s
    seconds: float = 1.0  # s, for how long
    velocity: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.5])  # m/s, M


@dataclass(kw_only=True)
class MotionConfig:
    """How a seated person moves, as a whole and in the spine.

    The periods have no common multiple worth waiting for, so that no run sees the
    same sequence of poses twice. Without the last block the person is rigid.
    """

    breath_amplitude: float = 0.008  # m, along the back's normal
    breath_frequency: float = 0.25  # Hz
    twist_amplitude: float = 0.0873  # rad (5 degrees), about the stool's axis
    twist_period: float = 23.0  # s
    lean_amplitude: float = 0.0873  # rad (5 degrees), about the line of the hips
    lean_period: float = 29.3  # s
    twist_phase: float = 0.0  # rad
    lean_phase: float = 0.0  # rad
    # The spine's bending, from the pelvis to the neck.
    flexion_amplitude: float = 0.0  # rad, forwards and back
    flexion_period: float = 19.0  # s
    flexion_phase: float = 0.0  # rad
    side_bend_amplitude: float = 0.0  # rad, to the left and the right
    side_bend_period: float = 37.1  # s
    side_bend_phase: float = 0.0  # rad
    spine_twist_amplitude: float = 0.0  # rad, about the spine
    spine_twist_period: float = 26.3  # s
    spine_twist_phase: float = 0.0  # rad
    chest_amplitude: float = 0.0  # m, the trunk's skin swells so far with the breath
    ramp: float = 3.0  # s, over which the motion grows from nothing
    departure: DepartureConfig | None = None  # stands up, or leaves

    @property
    def bends(self) -> bool:
        """Whether the skin changes its shape."""
        return bool(
            max(
                self.flexion_amplitude,
                self.side_bend_amplitude,
                self.spine_twist_amplitude,
                self.chest_amplitude,
            )
            > 0.0
        )


@dataclass(frozen=True, kw_only=True)
class Bend:
    """The shape of the trunk at one time.

    Attributes:
        flexion: Of the whole spine, forwards, rad.
        side_bend: To the person's left, rad.
        twist: To the person's left, rad.
        swell: How far the breath lifts the skin of the chest, m.
    """

    flexion: float = 0.0
    side_bend: float = 0.0
    twist: float = 0.0
    swell: float = 0.0


def check_motion(motion: MotionConfig) -> None:
    """Raises ValueError naming the field that no person could follow."""
    limits = {
        "breath_amplitude": (0.0, 0.05),
        "breath_frequency": (0.0, 2.0),
        "twist_amplitude": (0.0, 0.5),
        "lean_amplitude": (0.0, 0.5),
        "twist_period": (1.0, np.inf),
        "lean_period": (1.0, np.inf),
        "twist_phase": (-np.inf, np.inf),
        "lean_phase": (-np.inf, np.inf),
        # As far as a spine goes, seated.
        "flexion_amplitude": (0.0, 0.6),
        "side_bend_amplitude": (0.0, 0.4),
        "spine_twist_amplitude": (0.0, 0.6),
        "flexion_period": (1.0, np.inf),
        "side_bend_period": (1.0, np.inf),
        "spine_twist_period": (1.0, np.inf),
        "flexion_phase": (-np.inf, np.inf),
        "side_bend_phase": (-np.inf, np.inf),
        "spine_twist_phase": (-np.inf, np.inf),
        "chest_amplitude": (0.0, 0.03),
        "ramp": (0.0, np.inf),
    }
    for name, (low, high) in limits.items():
        value = getattr(motion, name)
        if not (np.isfinite(value) and low <= value <= high):
            raise ValueError(
                f"motion {name} must be finite and within [{low}, {high}], got {value}"
            )
    if motion.departure is not None:
        _check_departure(motion.departure)


def _check_departure(departure: DepartureConfig) -> None:
    for name, value in (("begin", departure.begin), ("seconds", departure.seconds)):
        if not 0.0 <= value < np.inf:
            raise ValueError(
                f"motion departure.{name} must be finite and not negative, got {value}"
            )
    velocity = departure.velocity
    if len(velocity) != 3 or not (np.abs(velocity) <= _FASTEST_PERSON).all():
        raise ValueError(
            f"motion departure.velocity must be 3 numbers of at most {_FASTEST_PERSON},"
            f" got {velocity}"
        )


def _departed(t: float, departure: DepartureConfig | None) -> FloatArray:
    """How far (3,) the person has gone by then, m in M."""
    if departure is None:
        return np.zeros(3)
    gone = min(max(t - departure.begin, 0.0), departure.seconds)
    # From rest to the speed in a tenth of a second, at a constant acceleration.
    start = min(gone, _START_TIME)
    return (gone - start + 0.5 * start**2 / _START_TIME) * np.array(departure.velocity)


def _ramp(t: float, duration: float) -> float:
    """Smooth from 0 at t = 0 to 1 at `duration`, with continuous acceleration."""
    s = 1.0 if t >= duration else max(t, 0.0) / duration
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def _rotation_x(angle: float) -> FloatArray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _rotation_z(angle: float) -> FloatArray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def trunk_bend(t: float, motion: MotionConfig) -> Bend:
    """Returns the trunk's shape at time t (s); at t <= 0 that of rest."""
    share = _ramp(t, motion.ramp)

    def wave(amplitude: float, period: float, phase: float) -> float:
        return float(share * amplitude * math.sin(2.0 * np.pi * t / period + phase))

    breath = 0.5 * (1.0 - math.cos(2.0 * np.pi * motion.breath_frequency * t))
    return Bend(
        flexion=wave(
            motion.flexion_amplitude, motion.flexion_period, motion.flexion_phase
        ),
        side_bend=wave(
            motion.side_bend_amplitude, motion.side_bend_period, motion.side_bend_phase
        ),
        twist=wave(
            motion.spine_twist_amplitude,
            motion.spine_twist_period,
            motion.spine_twist_phase,
        ),
        swell=float(share * motion.chest_amplitude * breath),
    )


def person_displacement(
    t: float, motion: MotionConfig, p_MHips: FloatArray, breath_M: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Returns how far the person has moved from the pose at rest.

    Args:
        t: Time, s; at t <= 0 the displacement is none at all.
        motion: Amplitudes and periods.
        p_MHips: (3,) middle of the hip line in M at rest, m. The lean turns about
            M's x axis through it, the twist about M's z axis through it.
        breath_M: (3,) unit vector in M along which the breath moves the body.

    Returns:
        Rotation (3, 3) and translation (3,) of X_MoM: from M as it is now to M as
        it was at rest.
    """
    share = _ramp(t, motion.ramp)
    twist = (
        share
        * motion.twist_amplitude
        * math.sin(2.0 * np.pi * t / motion.twist_period + motion.twist_phase)
    )
    lean = (
        share
        * motion.lean_amplitude
        * math.sin(2.0 * np.pi * t / motion.lean_period + motion.lean_phase)
    )
    breath = (
        share
        * motion.breath_amplitude
        * math.sin(2.0 * np.pi * motion.breath_frequency * t)
    )
    R = _rotation_z(twist) @ _rotation_x(lean)
    p = p_MHips + R @ (breath * breath_M - p_MHips) + _departed(t, motion.departure)
    return R, p


def person_pose(
    t: float,
    motion: MotionConfig,
    p_WM0: FloatArray,
    yaw_WM0: float,
    p_MHips: FloatArray,
    breath_M: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Returns rotation (3, 3) and origin (3,) of X_WM at time t.

    Args:
        t: Time, s.
        motion: Amplitudes and periods.
        p_WM0: (3,) origin of M at rest in W, m.
        yaw_WM0: Rotation of M at rest about W's z axis, rad.
        p_MHips: (3,) middle of the hip line in M, m.
        breath_M: (3,) unit vector in M along which the breath moves the body.
    """
    R, p = person_displacement(t, motion, p_MHips, breath_M)
    R_WM0 = _rotation_z(yaw_WM0)
    return R_WM0 @ R, p_WM0 + R_WM0 @ p
