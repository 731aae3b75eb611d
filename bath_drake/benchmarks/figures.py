"""What a benchmark finds: figures with targets, as a table and as JSON."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

# (what is being done, the share of all that is done, 0..1)
Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Figure:
    """One number of a benchmark.

    Attributes:
        name: What it is, in snake case.
        value: What was found; NaN if it could not be found, which misses any target.
        unit: Of value and target; '' for counts.
        target: What it is to reach; None for information.
        bound: On which side of the target it is to lie.
    """

    name: str
    value: float
    unit: str = ""
    target: float | None = None
    bound: Literal["at most", "at least"] = "at most"

    @property
    def passed(self) -> bool:
        """Whether the target is met; a figure without one cannot miss it."""
        if self.target is None:
            return True
        if self.bound == "at most":
            return self.value <= self.target
        return self.value >= self.target


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What the command line asks of a benchmark; the defaults ask nothing.

    Attributes:
        data: A folder of data to run on.
        held_out: Judge on data that were not learned from.
        peers: Run other methods as well.
        hours: How long a benchmark of endurance runs.
        shapes: The shapes to run on, by name; none means all.
        quick: Less effort: seconds for each thing learned, a worse fit; washing
            without camera and motors.
    """

    data: Path | None = None
    held_out: bool = False
    peers: bool = False
    hours: float | None = None
    shapes: tuple[str, ...] = ()
    quick: bool = False


# One line of a benchmark's details.
Row = Mapping[str, str | float | bool]


@dataclass(frozen=True)
class Report:
    """What a benchmark found.

    Attributes:
        figures: In the order to print them.
        rows: What they sum up, all with the same keys; may be empty.
    """

    figures: Sequence[Figure]
    rows: Sequence[Row] = ()


def all_passed(figures: Sequence[Figure]) -> bool:
    """Whether every target is met."""
    return all(figure.passed for figure in figures)


def table(figures: Sequence[Figure]) -> str:
    """Aligned lines: name, value, unit, target, whether it is met; then the verdict."""
    rows = [("figure", "value", "unit", "target", "")]
    for figure in figures:
        target, met = "", ""
        if figure.target is not None:
            target = f"{figure.bound} {_number(figure.target)}"
            met = "met" if figure.passed else "MISSED"
        rows.append((figure.name, _number(figure.value), figure.unit, target, met))
    widths = [max(len(row[i]) for row in rows) for i in range(4)]
    lines = [
        f"{row[0]:<{widths[0]}}  {row[1]:>{widths[1]}} {row[2]:<{widths[2]}}  "
        f"{row[3]:<{widths[3]}}  {row[4]}".rstrip()
        for row in rows
    ]
    missed = [figure.name for figure in figures if not figure.passed]
    aimed = sum(figure.target is not None for figure in figures)
    verdict = f"{aimed - len(missed)} of {aimed} targets met"
    if missed:
        verdict += f"; missed: {', '.join(missed)}"
    return "\n".join([*lines, verdict])


def row_table(rows: Sequence[Row]) -> str:
    """Aligned lines: the keys, then every row; text to the left, numbers to the right.

    What is not a number (NaN), or what a row does not have, is left blank.
    """
    if not rows:
        return ""
    keys = list(dict.fromkeys(key for row in rows for key in row))
    cells = [keys, *([_cell(row.get(key, "")) for key in keys] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    left = [isinstance(rows[0].get(key), str) for key in keys]
    lines = []
    for line in cells:
        parts = zip(line, widths, left, strict=True)
        lines.append(
            "  ".join(
                c.ljust(w) if to_left else c.rjust(w) for c, w, to_left in parts
            ).rstrip()
        )
    return "\n".join(lines)


def rows_to_json(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """The rows for JSON; what is not finite becomes None."""
    return [
        {
            key: None if isinstance(v, float) and not math.isfinite(v) else v
            for key, v in row.items()
        }
        for row in rows
    ]


def to_mapping(figures: Sequence[Figure]) -> dict[str, dict[str, Any]]:
    """The figures by name, for JSON: value, target, unit, bound and pass.

    What is not finite becomes None: JSON has no NaN.

    Raises:
        ValueError: Two figures have the same name.
    """
    found: dict[str, dict[str, Any]] = {}
    for figure in figures:
        if figure.name in found:
            raise ValueError(f"two figures are called {figure.name}")
        found[figure.name] = {
            "value": figure.value if math.isfinite(figure.value) else None,
            "target": figure.target,
            "unit": figure.unit,
            "bound": None if figure.target is None else figure.bound,
            "pass": figure.passed,
        }
    return found


def _cell(value: str | float | bool) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "" if math.isnan(value) else _number(value)


def _number(value: float) -> str:
    if math.isfinite(value) and float(value).is_integer():
        return f"{int(value):,}"
    return f"{value:,.4g}" if abs(value) < 1e4 else f"{value:,.0f}"
