"""Draws docs/cycle.png: a cycle as shown, learned, asked for and washed.

Run as ``python tools/draw_cycle.py RUN``, RUN a folder of ``bath-drake simulate
scrubbing --out RUN``.
"""

import sys
from pathlib import Path

from bath_drake.report import style
from bath_drake.report.cycle_figure import draw_cycle
from bath_drake.report.run_data import load_run

OUTPUT = Path(__file__).parent.parent / "docs" / "cycle.png"


def main(folder: str) -> None:
    """Writes docs/cycle.png from a run's folder."""
    run = load_run(Path(folder))
    seen = run.evaluation
    with style.figure_style():
        figure = draw_cycle(
            run.skill.periodic, run.demonstrations, seen.offsets, seen.around
        )
        figure.savefig(OUTPUT, dpi=100, metadata={"Software": None})
    print(OUTPUT)


if __name__ == "__main__":
    main(sys.argv[1])
