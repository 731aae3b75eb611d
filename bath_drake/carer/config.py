"""The carer of a filmed demonstration, as a schema for scenario files."""

from dataclasses import dataclass, field

import numpy as np

SIDES = ("left", "right")
RUBBINGS = ("circles", "scrubbing")


@dataclass(kw_only=True)
class RubbingConfig:
    """What the hand does on top of the stroke, round and round or to and fro."""

    kind: str = "circles"  # or scrubbing
    amplitude: float = 0.12  # canonical: the circles' radius, half the scrubbing's way
    frequency: float = 0.8  # Hz
    angle: float = 0.0  # rad, canonical: where to it scrubs
    drift: float = 0.0  # share by which the frequency wanders to and fro


@dataclass(kw_only=True)
class CarerConfig:
    """The stroke, how the hand moves along it, and what carer and marker look like."""

    # A path, or a name in models/demonstrations: its stroke with its own timing.
    demonstration: str | None = None
    # Canonical points, if there is no demonstration; the stroke goes through them.
    waypoints: list[list[float]] = field(
        default_factory=lambda: [
            [-0.55, 0.6],
            [0.5, 0.55],
            [0.5, 0.2],
            [-0.5, 0.1],
            [-0.45, -0.3],
            [0.5, -0.4],
        ]
    )
    seconds: float = 7.0  # s, from the first way-point to the last
    pause: float = 0.5  # s at rest before and after the stroke
    rubbing: RubbingConfig | None = None
    side: str = "right"  # of the person, where the carer stands
    # rad: the hand turns to and fro about the marker by this; far enough, it comes
    # between marker and camera.
    swing: float = 0.3
    swing_period: float = 3.1  # s
    marker_radius: float = 0.015  # m
    marker_colour: list[float] = field(
        default_factory=lambda: [0.05, 0.75, 0.15]
    )  # RGB, 0 to 1
    skin_colour: list[float] = field(default_factory=lambda: [0.72, 0.52, 0.42])
    sleeve_colour: list[float] = field(default_factory=lambda: [0.30, 0.48, 0.66])


def check_carer(carer: CarerConfig) -> None:
    """Raises ValueError naming the field that makes no carer."""
    ranges = {
        "seconds": (0.5, 600.0),
        "pause": (0.0, 60.0),
        "swing": (0.0, 3.2),
        "swing_period": (0.5, 600.0),
        "marker_radius": (0.005, 0.04),
    }
    for name, bounds in ranges.items():
        _check_range(name, getattr(carer, name), *bounds)
    if carer.side not in SIDES:
        raise ValueError(f"side: found {carer.side[:40]!r}, allowed: {_or(SIDES)}")
    for name in ("marker_colour", "skin_colour", "sleeve_colour"):
        colour = getattr(carer, name)
        if len(colour) != 3 or not all(0.0 <= c <= 1.0 for c in colour):
            raise ValueError(f"{name}: found {colour}, allowed 3 numbers from 0 to 1")
    if carer.demonstration is None:
        _check_waypoints(carer.waypoints)
    if carer.rubbing is not None:
        _check_rubbing(carer.rubbing)


def _check_waypoints(waypoints: list[list[float]]) -> None:
    if len(waypoints) < 2:
        raise ValueError(f"waypoints: found {len(waypoints)}, allowed 2 and more")
    for k, point in enumerate(waypoints):
        if len(point) != 2 or not np.abs(point).max() <= 1.0:
            raise ValueError(
                f"waypoints[{k}]: found {point}, allowed 2 numbers from -1 to 1"
            )
        if k > 0 and np.allclose(point, waypoints[k - 1], atol=1e-6):
            raise ValueError(f"waypoints[{k}]: found {point} twice in a row")


def _check_rubbing(rubbing: RubbingConfig) -> None:
    if rubbing.kind not in RUBBINGS:
        raise ValueError(
            f"rubbing.kind: found {rubbing.kind[:40]!r}, allowed: {_or(RUBBINGS)}"
        )
    for name, bounds in {
        "amplitude": (0.0, 0.5),
        "frequency": (0.05, 5.0),
        "angle": (-2.0 * np.pi, 2.0 * np.pi),
        "drift": (0.0, 0.5),
    }.items():
        _check_range(f"rubbing.{name}", getattr(rubbing, name), *bounds)


def _check_range(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise ValueError(f"{name}: found {value}, allowed {low:g} to {high:g}")


def _or(names: tuple[str, ...]) -> str:
    return " or ".join(names)
