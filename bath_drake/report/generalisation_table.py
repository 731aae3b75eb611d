"""Arrivals, proofs, smoothness and straying of a skill's random trials, in words."""

import numpy as np

from bath_drake.learning.generalisation import Generalisation

HEADER = (
    "ends drawn",
    "arrive",
    "proved",
    "turning",
    "smoothness",
    "to the corridor",
    "beyond the ends",
)
"""What the columns of `generalisation_rows` are."""


def generalisation_rows(found: Generalisation) -> list[tuple[str, ...]]:
    """A row of text for each ring, medians over the paths that arrived, and theirs."""
    rows: list[tuple[str, ...]] = []
    for ring in found.rings:
        count = len(ring.arrived)
        rows.append(
            (
                ring.name,
                f"{int(ring.arrived.sum())} of {count}",
                f"{int(ring.proved.sum())} of {count}",
                _number(ring.median(ring.turning), "x {:.2f}"),
                _number(ring.median(ring.smoothness), "{:.1f}"),
                _number(ring.median(ring.distances), "{:.3f}"),
                _number(ring.median(ring.strays), "{:.3f}"),
            )
        )
    smooth = f"{found.smoothness:.1f}"
    rows.append(("demonstrations", "", "", "x 1.00", smooth, "0.000", "0.000"))
    return rows


def _number(value: float, form: str) -> str:
    return form.format(value) if np.isfinite(value) else "-"
