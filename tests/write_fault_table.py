"""Renews the table of docs/faults.md: python tests/write_fault_table.py [FILE.json].

FILE.json is what `bath-drake bench faults --json FILE.json` wrote; without it the rows
are run.
"""

import json
import math
import sys
from pathlib import Path

from bath_drake.benchmarks import faults

DOCS = Path(__file__).parents[1] / "docs" / "faults.md"
BEGIN, END = "<!-- faults: by tests/write_fault_table.py -->\n", "<!-- end -->\n"
COLUMNS = (
    *("row", "fault", "expected", "goes on by itself"),
    *("first reason", "after, s", "as expected"),
)


def told(row) -> str:
    """What is expected of a row, in a table's cell."""
    reasons = " or ".join(f"`{r}`" for r in row["reasons"].split(" or ") if r)
    return " ".join(filter(None, [row["expected"].replace("_", " "), reasons]))


def expected_cells(row) -> list[str]:
    """The cells that are known before a run."""
    resumes = "" if row["expected"] in ("go_on",) else ("no", "yes")[row["resumes"]]
    return [f"{row['row']:.0f}", row["fault"], told(row), resumes]


def line(row) -> str:
    seconds = row["seconds"]
    after = "" if seconds is None or math.isnan(seconds) else f"{seconds:.2f}"
    reason = f"`{row['first reason']}`" if row["first reason"] else ""
    verdict = "yes" if row["as expected"] else "**no**"
    return "| " + " | ".join([*expected_cells(row), reason, after, verdict]) + " |"


def main() -> None:
    if len(sys.argv) > 1:
        rows = json.loads(Path(sys.argv[1]).read_text("utf-8"))["rows"]
    else:
        rows = faults.run(lambda what, share: print(what)).rows
    table = (
        "\n".join(
            ["| " + " | ".join(COLUMNS) + " |", "|---" * 7 + "|", *map(line, rows)]
        )
        + "\n"
    )
    before, rest = DOCS.read_text("utf-8").split(BEGIN)
    _, after = rest.split(END)
    DOCS.write_text(before + BEGIN + table + END + after, "utf-8")


if __name__ == "__main__":
    main()
