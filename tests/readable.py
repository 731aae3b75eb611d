"""What every picture must be."""

from itertools import pairwise

from matplotlib.figure import Figure


def check_readable(figure):
    """Every axes that is seen is named, and all text is within the figure."""
    assert isinstance(figure, Figure)
    figure.draw_without_rendering()
    width, height = figure.get_size_inches() * figure.dpi
    seen = [axes for axes in figure.axes if axes.get_visible()]
    assert seen
    for axes in seen:
        # The columns and rows share their outer labels, a colour bar has one.
        assert axes.get_xlabel() or axes.get_ylabel() or axes.get_title()
        box = axes.get_tightbbox()
        # A pixel of rounding.
        assert box.x0 >= -1.0
        assert box.y0 >= -1.0
        assert box.x1 <= width + 1.0
        assert box.y1 <= height + 1.0
        names = [t.get_window_extent() for t in axes.get_xticklabels() if t.get_text()]
        assert not any(a.overlaps(b) for a, b in pairwise(names))
