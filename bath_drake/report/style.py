"""One look for all figures: colours, text, and figures as data in the page.

The colours tell kinds of things apart for colour-blind readers too; the same
thing has the same colour in every figure, in the page and in Meshcat.
"""

import base64
import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

DEMONSTRATION = "#0b5fa5"
DEMONSTRATION_SHADES = ("#9ecae1", "#6baed6", "#4292c6", "#b9cfe4", "#88a9d0")
REPRODUCTION = "#d7301f"
TO_COME = "#ffffff"
OBSTACLE = "#4a4f57"
RESTRICTED = "#aa3377"
NORMAL = "#1763e0"
MASK = "#00a37a"
ROBOT = "#39404a"
BOX = "#f0e442"
RETREAT = "#f28e2b"
INK = "#1d2733"
MUTED = "#66727f"
GRID = "#dfe4ea"
PASS = "#1a7f4b"
FAIL = "#b3261e"
PHASES = ("#eef1f5", "#dbe4ee", "#ffffff")

WIDTH = 10.0  # inches of a figure as wide as the page

_RC: Any = {  # rcParams' stubs list their keys one by one
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 10.0,
    "axes.titlesize": 11.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 10.0,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "lines.solid_capstyle": "round",
    "text.color": INK,
    # The same run gives the same bytes.
    "svg.hashsalt": "bath_drake",
    "svg.fonttype": "path",
}


@contextmanager
def figure_style() -> Iterator[None]:
    """Draws and saves figures in this package's look inside the `with`."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_RC)
        yield


def new_figure(height: float, width: float = WIDTH) -> Figure:
    """Returns an empty figure (inches); no window system, no global state."""
    return Figure(figsize=(width, height), layout="constrained")


def as_data_uri(figure: Figure, *, raster: bool = False) -> str:
    """Returns a figure as a data URI: SVG, or PNG where pixels dominate."""
    content = io.BytesIO()
    if raster:
        figure.savefig(content, format="png", dpi=170, metadata={"Software": None})
        kind = "png"
    else:
        metadata = {"Date": None, "Creator": None}
        figure.savefig(content, format="svg", dpi=170, metadata=metadata)
        kind = "svg+xml"
    text = base64.b64encode(content.getvalue()).decode("ascii")
    return f"data:image/{kind};base64,{text}"


def demonstration_shade(index: int) -> str:
    """Returns the light blue of the demonstration of this index."""
    return DEMONSTRATION_SHADES[index % len(DEMONSTRATION_SHADES)]


def rgb(colour: str) -> tuple[float, float, float]:
    """Returns a colour #rrggbb as three numbers in [0, 1]."""
    values = [int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
    red, green, blue = np.asarray(values).tolist()
    return red, green, blue
