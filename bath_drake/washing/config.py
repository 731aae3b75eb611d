"""How water or a sponge reaches the skin, and which skin is to be washed."""

import math
from dataclasses import dataclass

from bath_drake.washing.footprint import JetCone, SpongeDisc

TOOLS = ("jet", "sponge")


@dataclass(kw_only=True)
class WashingConfig:
    """What the washing is measured by; it does not change how the robot moves."""

    tool: str = "jet"  # jet, or sponge
    # rad, between the jet's axis and its cone: 58 mm across at 60 mm off the skin.
    half_angle: float = 0.45
    reach: float = 0.15  # m from the nozzle's tip, further off the water does nothing
    sponge_radius: float = 0.03  # m
    # m, from the tool's tip along its axis to the sponge's face, and how near to the
    # skin that touches it.
    sponge_length: float = 0.0
    sponge_contact: float = 0.01
    # m, to both sides of the stroke: the skin that it is to wash.
    band: float = 0.02
    # Instead of a band: the box of canonical coordinates [x, y] that is to be washed.
    target_low: list[float] | None = None
    target_high: list[float] | None = None
    # m, around wounds and given areas, not to be washed; null: as far as the loop keeps
    # off them (perception.area_margin).
    spared: float | None = None
    pitch: float = 0.004  # m, how finely the skin is looked at


_RANGES: dict[str, tuple[float, float]] = {
    "half_angle": (0.01, 1.2),
    "reach": (0.01, 1.0),
    "sponge_radius": (0.005, 0.15),
    "sponge_length": (0.0, 0.3),
    "sponge_contact": (0.005, 0.05),
    "band": (0.002, 0.2),
    "pitch": (0.001, 0.005),
}


def check_washing(washing: WashingConfig) -> None:
    """Raises ValueError naming the key that is out of its range."""
    if washing.tool not in TOOLS:
        raise ValueError(
            f"tool: found {washing.tool[:60]!r}, allowed {', '.join(TOOLS)}"
        )
    for key, (low, high) in _RANGES.items():
        _check_range(key, getattr(washing, key), low, high)
    if washing.spared is not None:
        _check_range("spared", washing.spared, 0.0, 0.2)
    given = {
        "target_low": washing.target_low,
        "target_high": washing.target_high,
    }
    for key, corner in given.items():
        if corner is None:
            continue
        if len(corner) != 2 or not all(-1.0 <= value <= 1.0 for value in corner):
            raise ValueError(f"{key}: found {corner}, allowed two numbers of -1 to 1")
    low_corner, high_corner = washing.target_low, washing.target_high
    if low_corner is None and high_corner is None:
        return
    for key, corner in given.items():
        if corner is None:
            raise ValueError(f"{key}: found null, allowed a corner beside the other")
    assert low_corner is not None
    assert high_corner is not None
    if not all(a < b for a, b in zip(low_corner, high_corner, strict=True)):
        raise ValueError(
            f"target_high: found {high_corner}, allowed more than target_low "
            f"{low_corner}"
        )


def washing_tool(washing: WashingConfig) -> JetCone | SpongeDisc:
    """Returns the tool that a configuration describes."""
    if washing.tool == "jet":
        return JetCone(half_angle=washing.half_angle, reach=washing.reach)
    return SpongeDisc(
        radius=washing.sponge_radius,
        length=washing.sponge_length,
        contact=washing.sponge_contact,
    )


def _check_range(key: str, value: float, low: float, high: float) -> None:
    if not (math.isfinite(value) and low <= value <= high):
        raise ValueError(f"{key}: found {value}, allowed {low} to {high}")
