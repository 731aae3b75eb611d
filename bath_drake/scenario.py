"""Scenario files: every choice of one closed-loop run, and what it is judged by."""

import contextlib
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path

from bath_drake.composition.stroke_config import (
    LanesConfig,
    StrokeConfig,
    check_strokes,
)
from bath_drake.control.approach import ApproachLimits
from bath_drake.control.force_regulation import ForceLimits
from bath_drake.errors import ScenarioError
from bath_drake.faults.expectation import Expectation, check_expectation
from bath_drake.faults.script import FaultScript, check_script
from bath_drake.perception.config import PerceptionConfig, check_perception
from bath_drake.resources import diagrams_folder, models_folder
from bath_drake.safety.outcome import LoopBounds
from bath_drake.scene.config import SceneConfig, check_scene
from bath_drake.schema import fill
from bath_drake.washing.config import WashingConfig, check_washing
from bath_drake.yaml_block import Block
from bath_drake.yaml_io import dump_yaml, read_yaml


@dataclass(kw_only=True)
class ControlConfig:
    """How the motion is driven."""

    washing_speed: float = 0.07  # m/s along the skin, at most 0.10
    slow_radius: float = 0.1  # canonical
    leash: float = 0.08  # canonical, the reference ahead of the nozzle
    standoff: float = 0.06  # m, nozzle tip off the skin
    far_standoff: float = 0.14  # m, where it lines up first
    approach_speed: float = 0.05  # m/s along the normal, at most 0.05
    approach_acceleration: float = 0.25  # m/s^2 along the normal, at most 1
    approach_jerk: float = 2.5  # m/s^3 along the normal, at most 20
    max_frame_age: float = 0.1  # s: two periods pass by themselves, a third is too many
    min_clearance: float = 0.02  # m, nozzle tip off the seen skin
    force: float = 4.0  # N, along the normal, at most 5; where skin can be touched
    goal_tolerance: float = 0.02  # canonical


@dataclass(kw_only=True)
class Limits:
    """What the verification judges the run by; null asks for the figure alone."""

    frechet_learned: float | None = 0.10  # of the scale
    frechet_executed: float | None = 0.08  # of the scale
    surface_error_mean_mm: float | None = 5.0
    surface_error_max_mm: float | None = 15.0
    normal_error_mean_deg: float | None = 5.0
    restricted_entries: int = 0
    coverage: float | None = None  # least share of the target skin, 0 to 1
    wound_wetted_cm2: float | None = None
    # Where skin can be touched; the shares are least ones.
    force_mean_error: float | None = 0.5  # N
    force_within_2_n: float | None = 0.99  # of the stroke
    force_peak: float | None = 10.0  # N
    force_contact_share: float | None = 0.98  # of the stroke
    approach_speed_m_per_s: float | None = 0.05
    skin_speed_m_per_s: float | None = 0.10
    touched_skin_mean_mm: float | None = 2.0


@dataclass(kw_only=True)
class Scenario:
    """One run. Frames and units as in `bath_drake.notation`."""

    description: str = ""
    random_seed: int = 0
    duration: float = 40.0  # s, the longest run
    skill: str = "back_sinusoid.yaml"  # a path, or a name in models/skills
    # Start and goal pairs, each a stroke through a skill, in turn; or lanes across a
    # box. Neither: the skill's own stroke.
    strokes: list[StrokeConfig] = field(default_factory=list)
    lanes: LanesConfig | None = None
    # Paths, or names in models/demonstrations.
    demonstrations: list[str] = field(
        default_factory=lambda: [f"back_sinusoid_{k}.csv" for k in (1, 2, 3)]
    )
    scene: SceneConfig = field(default_factory=SceneConfig)
    perception: PerceptionConfig = field(default_factory=PerceptionConfig)
    control: ControlConfig = field(default_factory=ControlConfig)
    washing: WashingConfig = field(default_factory=WashingConfig)
    limits: Limits = field(default_factory=Limits)
    faults: FaultScript = field(default_factory=FaultScript)
    # Judges the run by the guard's reaction alone; null: by the limits.
    expect: Expectation | None = None


# Careful bounds near people: nobody asks for more by mistake.
_RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "control": {
        "washing_speed": (1e-3, 0.10),
        "slow_radius": (1e-3, 1.0),
        "leash": (1e-3, 0.5),
        "standoff": (0.03, 0.2),
        "far_standoff": (0.03, 0.3),
        "approach_speed": (1e-3, 0.05),
        "approach_acceleration": (1e-2, 1.0),
        "approach_jerk": (1e-2, 20.0),
        "max_frame_age": (0.01, 0.5),
        "min_clearance": (0.005, 0.1),
        "goal_tolerance": (1e-4, 0.1),
        "force": (1.0, 5.0),
    },
}
_LONGEST_RUN_S = 3600.0


def _check_range(key: str, value: float, low: float, high: float) -> None:
    if not (math.isfinite(value) and low <= value <= high):
        raise ValueError(f"{key}: found {value}, allowed {low} to {high}")


def check_scenario(scenario: Scenario) -> None:
    """Raises ValueError naming the key that is out of its range."""
    _check_range("duration", scenario.duration, 0.1, _LONGEST_RUN_S)
    if scenario.random_seed < 0:
        raise ValueError(f"random_seed: found {scenario.random_seed}, allowed 0 and up")
    for block, ranges in _RANGES.items():
        for key, (low, high) in ranges.items():
            value = getattr(getattr(scenario, block), key)
            _check_range(f"{block}.{key}", value, low, high)
    if scenario.control.min_clearance >= scenario.control.standoff:
        raise ValueError(
            f"control.min_clearance: found {scenario.control.min_clearance}, "
            f"allowed less than control.standoff ({scenario.control.standoff})"
        )
    approach_limits(scenario)
    _check_sight(scenario)
    for key, value in vars(scenario.limits).items():
        if value is not None and not value >= 0:
            raise ValueError(f"limits.{key}: found {value}, allowed 0 and up, or null")
    check_strokes(scenario.strokes, scenario.lanes)
    if scenario.limits.coverage is not None:
        _check_range("limits.coverage", scenario.limits.coverage, 0.0, 1.0)
    with _named("perception."):
        check_perception(scenario.perception)
    with _named("washing."):
        check_washing(scenario.washing)
    with _named("faults."):
        check_script(scenario.faults)
    if scenario.expect is not None:
        with _named("expect."):
            check_expectation(scenario.expect)
    with _named("scene: "):
        check_scene(scenario.scene)


@contextlib.contextmanager
def _named(block: str) -> Iterator[None]:
    """Puts the block's name before what its own check raises."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{block}{error}") from error


def _check_sight(scenario: Scenario) -> None:
    """Where nothing is filmed, nothing that needs a camera can be asked for."""
    if scenario.perception.source != "ideal":
        return
    for key, there in (
        ("scene.carer", scenario.scene.carer is not None),
        ("scene.camera.faults", scenario.scene.camera.faults.any),
    ):
        if there:
            raise ValueError(
                f"perception.source: found 'ideal', allowed camera where there is {key}"
            )


def approach_limits(scenario: Scenario) -> ApproachLimits:
    """Returns the approach's limits; ValueError if they contradict each other."""
    control = scenario.control
    return ApproachLimits(
        far_standoff=control.far_standoff,
        standoff=control.standoff,
        speed=control.approach_speed,
        acceleration=control.approach_acceleration,
        jerk=control.approach_jerk,
    )


def force_limits(scenario: Scenario) -> ForceLimits:
    """Returns how the force is regulated where skin can be touched."""
    return ForceLimits(force=scenario.control.force)


def loop_bounds(scenario: Scenario) -> LoopBounds:
    """Returns the bounds that end a run."""
    return LoopBounds(
        duration=scenario.duration,
        goal_tolerance=scenario.control.goal_tolerance,
        min_clearance=scenario.control.min_clearance,
    )


def find_scenario(name: str | Path) -> Path:
    """Returns a scenario's path: a file, or the name of a shipped one."""
    path = Path(name)
    if path.exists():
        return path
    shipped = diagrams_folder()
    for candidate in (shipped / path, shipped / f"{path}.yaml"):
        within = not path.is_absolute() and ".." not in path.parts
        if within and candidate.is_file():
            return candidate
    names = ", ".join(sorted(p.name for p in shipped.glob("*.yaml")))
    raise ScenarioError(f"{name}: no such scenario; shipped ones: {names}")


def load_scenario(path: str | Path) -> Scenario:
    """Reads a scenario file, or a shipped one by name.

    Raises:
        ScenarioError: Naming file and key, what was found and what is allowed.
    """
    path = find_scenario(path)
    content = read_yaml(path, error=ScenarioError)
    scenario = fill(Scenario, Block(content, str(path), error=ScenarioError))
    try:
        check_scenario(scenario)
    except ValueError as error:
        raise ScenarioError(f"{path}: {error}") from error
    return scenario


def dump_scenario(scenario: Scenario) -> str:
    """Writes a scenario, every value of it, as YAML."""
    return dump_yaml(asdict(scenario))


def find_skill(name: str | Path) -> Path:
    """Returns a skill's path: a file, or the name of a shipped one."""
    return _find(name, "skills")


def find_demonstration(name: str | Path) -> Path:
    """Returns a demonstration's path: a file, or the name of a shipped one."""
    return _find(name, "demonstrations")


def _find(name: str | Path, kind: str) -> Path:
    path = Path(name)
    shipped = models_folder() / kind / path
    within = not path.is_absolute() and ".." not in path.parts
    if not path.exists() and within and shipped.is_file():
        return shipped
    # A missing file is reported by its reader, which says what it expects.
    return path
