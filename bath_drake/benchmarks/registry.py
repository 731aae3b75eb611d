"""Which benchmarks there are, and what each takes."""

from collections.abc import Callable
from dataclasses import dataclass, fields

from bath_drake.benchmarks.figures import Figure, Progress, Report, Settings
from bath_drake.errors import BathDrakeError

# The names the command line has: scripts lean on them.
NAMES = (
    "field",
    "lasa",
    "strokes",
    "frechet",
    "demonstrations",
    "capture",
    "perception",
    "guard",
    "faults",
    "touch",
    "loop",
    "washing",
    "soak",
)


@dataclass(frozen=True)
class Benchmark:
    """One benchmark.

    Attributes:
        run: Measures; returns the figures in the order to print them, or a report.
        uses: The names of the `Settings` it heeds.
    """

    run: Callable[[Settings, Progress], list[Figure] | Report]
    uses: frozenset[str] = frozenset()


def _field(settings: Settings, progress: Progress) -> list[Figure]:
    # Imported when asked for: compiled kernels take a second to load.
    from bath_drake.benchmarks.field import run

    return run(progress)


def _strokes(settings: Settings, progress: Progress) -> Report:
    from bath_drake.benchmarks.strokes import run_strokes

    return run_strokes(settings, progress)


def _lasa(settings: Settings, progress: Progress) -> Report:
    from bath_drake.benchmarks.strokes import run_lasa

    return run_lasa(settings, progress)


def _frechet(settings: Settings, progress: Progress) -> Report:
    from bath_drake.benchmarks.frechet import run

    return run(settings, progress)


def _demonstrations(settings: Settings, progress: Progress) -> Report:
    from bath_drake.benchmarks.demonstrations import run

    return run(progress)


def _capture(settings: Settings, progress: Progress) -> Report:
    from bath_drake.benchmarks.capture import run

    return run(progress)


def _perception(settings: Settings, progress: Progress) -> Report:
    from bath_drake.benchmarks.perception.all_parts import run

    return run(progress)


def _guard(settings: Settings, progress: Progress) -> list[Figure]:
    from bath_drake.benchmarks.guard import run

    return run(progress)


def _faults(settings: Settings, progress: Progress) -> Report:
    from bath_drake.benchmarks.faults import run

    return run(progress)


def _loop(settings: Settings, progress: Progress) -> Report:
    from bath_drake.benchmarks.loop import run

    return run(progress)


def _touch(settings: Settings, progress: Progress) -> list[Figure]:
    from bath_drake.benchmarks.touch import run

    return run(progress)


def _washing(settings: Settings, progress: Progress) -> Report:
    from bath_drake.benchmarks.washing import run

    return run(settings, progress)


def _soak(settings: Settings, progress: Progress) -> Report:
    from bath_drake.benchmarks.soak import run

    return run(settings, progress)


_LEARNING = frozenset({"held_out", "peers", "shapes", "quick"})
BENCHMARKS = {
    "field": Benchmark(_field),
    "strokes": Benchmark(_strokes, _LEARNING),
    "lasa": Benchmark(_lasa, _LEARNING | {"data"}),
    "frechet": Benchmark(_frechet, frozenset({"peers"})),
    "demonstrations": Benchmark(_demonstrations),
    "capture": Benchmark(_capture),
    "perception": Benchmark(_perception),
    "guard": Benchmark(_guard),
    "faults": Benchmark(_faults),
    "loop": Benchmark(_loop),
    "touch": Benchmark(_touch),
    "washing": Benchmark(_washing, frozenset({"quick"})),
    "soak": Benchmark(_soak, frozenset({"hours", "data"})),
}


def find(name: str, settings: Settings) -> Benchmark:
    """Returns a benchmark that can do what is asked.

    Raises:
        BathDrakeError: There is none of that name, or it does not use an option given.
    """
    if name not in BENCHMARKS:
        available = ", ".join(BENCHMARKS)
        raise BathDrakeError(f"{name}: no such benchmark; available: {available}")
    benchmark = BENCHMARKS[name]
    for field in fields(settings):
        if field.name in benchmark.uses:
            continue
        if getattr(settings, field.name) != field.default:
            used = ", ".join(option(key) for key in sorted(benchmark.uses))
            raise BathDrakeError(
                f"{name}: {option(field.name)} is none of its options, "
                f"allowed: {', '.join(filter(None, ['--json', used]))}"
            )
    return benchmark


def option(setting: str) -> str:
    """The name of a setting on the command line."""
    return "--" + setting.replace("_", "-")


def users(setting: str) -> str:
    """Which benchmarks use a setting, in words."""
    names = [name for name, found in BENCHMARKS.items() if setting in found.uses]
    return f"used by {', '.join(names)}" if names else "no benchmark uses it yet"
