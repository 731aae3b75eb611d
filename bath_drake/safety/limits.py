"""The limits file: everything the guard keeps to, in one documented YAML."""

import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from bath_drake.errors import LimitsError
from bath_drake.resources import models_folder
from bath_drake.safety.smooth_way import SmoothWay
from bath_drake.schema import fill
from bath_drake.yaml_block import Block
from bath_drake.yaml_io import dump_yaml, read_yaml


@dataclass(kw_only=True)
class CanonicalLimits:
    """Of the point in canonical space N."""

    speed: float = 1.0  # 1/s, in N
    acceleration: float = 10.0  # 1/s^2, in N
    skin_speed: float = 0.10  # m/s along the skin
    margin: float = 0.005  # N, from obstacles, areas and the rim


@dataclass(kw_only=True)
class NozzleLimits:
    """Of the nozzle's tip."""

    speed: float = 0.15  # m/s in any direction
    approach_speed: float = 0.05  # m/s along the normal, also when it retreats
    retreat_distance: float = 0.08  # m
    retreat_acceleration: float = 2.5  # m/s^2
    retreat_jerk: float = 250.0  # m/s^3
    clearance: float = 0.04  # m off the skin; nearer, it retreats


@dataclass(kw_only=True)
class FrameLimits:
    """Of what the camera must have seen."""

    hold_age: float = 0.1  # s
    retreat_age: float = 0.5  # s
    invalid_share: float = 0.3  # of the pixels
    seen_through: float = 0.015  # of the arm's pixels
    body_speed: float = 0.12  # m/s


@dataclass(kw_only=True)
class JointLimits:
    """Of the joint command; the ends of the positions are the arm model's."""

    margin: float = 0.1  # rad, from both ends
    # rad/s: half of what a Franka Research 3 can.
    velocity: list[float] = field(
        default_factory=lambda: [1.31, 1.31, 1.31, 1.31, 2.63, 2.09, 2.63]
    )
    acceleration: list[float] = field(default_factory=lambda: [10.0] * 7)  # rad/s^2
    jump: float = 0.05  # rad, between a command and what was last emitted
    following: float = 0.02  # rad, of a joint off what was emitted
    self_distance: float = 0.03  # m
    obstacle_distance: float = 0.02  # m
    condition_slow: float = 17.0  # of the Jacobian
    condition_stop: float = 30.0


@dataclass(kw_only=True)
class ForceLimits:
    """Of the contact force and its sensor."""

    retreat: float = 15.0  # N
    stop: float = 25.0  # N
    age: float = 0.05  # s
    frozen_time: float = 0.2  # s


@dataclass(kw_only=True)
class LoopLimits:
    """Of the control loop itself."""

    period: float = 0.005  # s
    overrun: float = 2.0  # periods
    link_age: float = 0.02  # s
    resume_time: float = 0.2  # s


@dataclass(kw_only=True)
class GuardLimits:
    """All of them."""

    canonical: CanonicalLimits = field(default_factory=CanonicalLimits)
    nozzle: NozzleLimits = field(default_factory=NozzleLimits)
    frames: FrameLimits = field(default_factory=FrameLimits)
    joints: JointLimits = field(default_factory=JointLimits)
    force: ForceLimits = field(default_factory=ForceLimits)
    loop: LoopLimits = field(default_factory=LoopLimits)


JOINTS = 7
# What the joints can: velocities of the arm's model, rad/s.
_FASTEST = (2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26)

# Careful near people: nobody asks for more by mistake. The upper ends of force and
# speed along the skin and on approach are the defaults themselves.
_RANGES: dict[str, dict[str, tuple[float, float | tuple[float, ...]]]] = {
    "canonical": {
        "speed": (1e-3, 2.0),
        "acceleration": (1e-2, 50.0),
        "skin_speed": (1e-3, 0.10),
        "margin": (0.0, 0.1),
    },
    "nozzle": {
        "speed": (1e-3, 0.25),
        "approach_speed": (1e-3, 0.05),
        "retreat_distance": (0.01, 0.3),
        # Gentler ones would keep the nozzle near the skin.
        "retreat_acceleration": (1.0, 10.0),
        "retreat_jerk": (50.0, 1e4),
        "clearance": (0.0, 0.2),
    },
    "frames": {
        "hold_age": (0.01, 0.5),
        "retreat_age": (0.02, 2.0),
        "invalid_share": (0.0, 0.9),
        "seen_through": (0.0, 0.2),
        "body_speed": (1e-3, 0.5),
    },
    "joints": {
        "margin": (0.0, 0.5),
        "velocity": (1e-3, _FASTEST),
        "acceleration": (1e-2, 10.0),
        "jump": (1e-3, 0.2),
        "following": (1e-3, 0.05),
        "self_distance": (0.0, 0.5),
        "obstacle_distance": (0.0, 0.2),
        "condition_slow": (1.0, 1e4),
        "condition_stop": (1.0, 1e4),
    },
    "force": {
        "retreat": (0.5, 15.0),
        "stop": (1.0, 25.0),
        "age": (1e-3, 0.1),
        "frozen_time": (1e-2, 1.0),
    },
    "loop": {
        "period": (1e-4, 0.1),
        "overrun": (1.0, 10.0),
        "link_age": (1e-3, 0.1),
        "resume_time": (0.0, 60.0),
    },
}
# Within a block, the first must be below the second.
_ASCENDING = (
    ("nozzle", "approach_speed", "speed"),
    ("frames", "hold_age", "retreat_age"),
    ("joints", "condition_slow", "condition_stop"),
    ("force", "retreat", "stop"),
)


def retreat_way(limits: GuardLimits) -> SmoothWay:
    """Returns the nozzle's way along the normal when it retreats."""
    nozzle = limits.nozzle
    return SmoothWay(
        distance=nozzle.retreat_distance,
        speed=nozzle.approach_speed,
        acceleration=nozzle.retreat_acceleration,
        jerk=nozzle.retreat_jerk,
    )


def _check(key: str, value: Any, low: float, high: Any) -> None:
    if not (math.isfinite(value) and low <= value <= high):
        raise ValueError(f"{key}: found {value}, allowed {low:g} to {high:g}")


def _check_joints(key: str, values: list[float], low: float, high: Any) -> None:
    if len(values) != JOINTS:
        raise ValueError(
            f"{key}: found {len(values)} numbers, allowed {JOINTS}, one a joint"
        )
    highs = high if isinstance(high, tuple) else (high,) * JOINTS
    for k, (value, most) in enumerate(zip(values, highs, strict=True)):
        _check(f"{key}[{k}]", value, low, most)


def check_limits(limits: GuardLimits) -> None:
    """Raises ValueError naming the key, what was found and what is allowed."""
    for block, ranges in _RANGES.items():
        for name, (low, high) in ranges.items():
            found = getattr(getattr(limits, block), name)
            if isinstance(found, list):
                _check_joints(f"{block}.{name}", found, low, high)
            else:
                _check(f"{block}.{name}", found, low, high)
    for block, lower, upper in _ASCENDING:
        values = [getattr(getattr(limits, block), name) for name in (lower, upper)]
        if not values[0] < values[1]:
            raise ValueError(
                f"{block}.{lower}: found {values[0]}, "
                f"allowed less than {block}.{upper} ({values[1]})"
            )


def shipped_limits() -> Path:
    """Returns the path of the limits that ship."""
    return models_folder() / "safety" / "limits.yaml"


def load_limits(path: str | Path | None = None) -> GuardLimits:
    """Reads a limits file; None reads the one that ships.

    Raises:
        LimitsError: Naming file and key, what was found and what is allowed.
    """
    path = shipped_limits() if path is None else Path(path)
    content = read_yaml(path, error=LimitsError)
    limits = fill(GuardLimits, Block(content, str(path), error=LimitsError))
    try:
        check_limits(limits)
    except ValueError as error:
        raise LimitsError(f"{path}: {error}") from error
    return limits


def dump_limits(limits: GuardLimits) -> str:
    """Writes limits, every value of them, as YAML."""
    return dump_yaml(asdict(limits))
