"""What can go wrong with a camera, as a schema for scenario files: all off at first."""

from dataclasses import dataclass, field


@dataclass(kw_only=True)
class Spell:
    """A while in which something is wrong; at its end it is not."""

    begin: float = 0.0  # s
    end: float = 3600.0  # s


def check_spell(key: str, spell: Spell) -> None:
    """Raises ValueError naming `key` unless it begins and, later, ends."""
    if not 0.0 <= spell.begin < spell.end < float("inf"):
        raise ValueError(
            f"{key}: found begin {spell.begin} and end {spell.end}, allowed 0 and up, "
            "the end later"
        )


@dataclass(kw_only=True)
class FrameFault(Spell):
    """Some of the frames of a while."""

    probability: float = 1.0  # of each frame of that while


@dataclass(kw_only=True)
class LateFault(FrameFault):
    """Frames that come late, with the time at which they were taken."""

    delay: float = 0.1  # s


@dataclass(kw_only=True)
class SaturationFault(Spell):
    """A glare: a disc of the image that is white and has no depth."""

    centre: list[float] = field(
        default_factory=lambda: [0.5, 0.5]
    )  # shares of the image's width and height
    radius: float = 0.08  # share of the image's width


@dataclass(kw_only=True)
class DropletsFault(Spell):
    """Water on the lens: discs of blurred colour and wild or no depth."""

    count: int = 6
    radius: float = 0.04  # of the largest, share of the image's width
    lost: float = 0.4  # share of a droplet's pixels without depth
    outliers: float = 0.3  # share of them whose depth is wrong by up to a half


@dataclass(kw_only=True)
class BackwardsFault(FrameFault):
    """Frames whose time stamps are of the past, though they are new."""

    by: float = 1.0  # s


@dataclass(kw_only=True)
class BlankFault(Spell):
    """Depth that says nothing in some rows of the image, from the top."""

    share: float = 0.5  # of the image's height


@dataclass(kw_only=True)
class CoveredFault(Spell):
    """Something grey close to the lens: a disc of the image."""

    centre: list[float] = field(
        default_factory=lambda: [0.5, 0.5]
    )  # shares of the image's width and height
    radius: float = 1.0  # share of the image's width
    depth: float = 0.6  # m


@dataclass(kw_only=True)
class ShiftedFault(Spell):
    """A camera that was knocked: all it sees is elsewhere in its image."""

    pixels: list[int] = field(default_factory=lambda: [60, 0])  # columns and rows


@dataclass(kw_only=True)
class FaultsConfig:
    """The camera's faults; null is none."""

    loss: FrameFault | None = None  # frames that never come
    late: LateFault | None = None
    frozen: FrameFault | None = None  # the last image again, with a new time
    saturation: SaturationFault | None = None
    droplets: DropletsFault | None = None
    backwards: BackwardsFault | None = None
    blank: BlankFault | None = None
    covered: CoveredFault | None = None
    shifted: ShiftedFault | None = None

    @property
    def any(self) -> bool:
        """Whether there is any fault at all."""
        return any(fault is not None for fault in vars(self).values())


_RANGES = {
    "probability": (0.0, 1.0),
    "delay": (0.0, 2.0),
    "radius": (1e-3, 1.0),
    "by": (1e-3, 3600.0),
    "share": (0.0, 1.0),
    "depth": (1e-3, 10.0),
    "count": (1, 200),
    "lost": (0.0, 1.0),
    "outliers": (0.0, 1.0),
}


def check_faults(config: FaultsConfig) -> None:
    """Raises ValueError naming the field that makes no fault."""
    for name, fault in vars(config).items():
        if fault is None:
            continue
        check_spell(name, fault)
        for key, (low, high) in _RANGES.items():
            value = getattr(fault, key, low)
            if not low <= value <= high:
                raise ValueError(
                    f"{name}.{key}: found {value}, allowed {low} to {high}"
                )
    for name in ("saturation", "covered"):
        disc = getattr(config, name)
        if disc is None:
            continue
        if len(disc.centre) != 2 or not all(0.0 <= x <= 1.0 for x in disc.centre):
            raise ValueError(
                f"{name}.centre: found {disc.centre}, allowed two shares, 0 to 1"
            )
    if config.shifted is not None and len(config.shifted.pixels) != 2:
        raise ValueError(
            f"shifted.pixels: found {config.shifted.pixels}, allowed two integers"
        )
    if config.droplets is not None:
        share = config.droplets.lost + config.droplets.outliers
        if share > 1.0:
            raise ValueError(
                f"droplets.lost and outliers: found {share} together, allowed up to 1"
            )


def within(fault: Spell, t: float) -> bool:
    """Whether a fault is on at a time, s; its end is not."""
    # Time stamps in steps of a camera period accumulate rounding.
    rounding = 1e-9
    return fault.begin - rounding <= t < fault.end - rounding
