"""A body's heights over a plane: what is whole, and how near to the rim it is true."""

import numpy as np

from bath_drake.perception.height_field import BESIDE, CELL, CELLS, RIM, HeightField

# Falls off by 45 degrees to one side, as a flank does.
SLOPE, HALF = -1.0, 0.1


def cells():
    """x and y of every cell's middle, m."""
    steps = (np.arange(CELLS) - CELLS // 2 + 0.5) * CELL
    return np.meshgrid(steps, steps, indexing="ij")


def flank(rng):
    # 0.1 m each way, the rim in the midst of cells: a quarter of each is covered.
    x, y = rng.uniform(-HALF - 0.25 * CELL, HALF + 0.25 * CELL, (2, 40000))
    return HeightField().with_points(np.column_stack([x, y, SLOPE * x]))


def test_whole_cells_go_farther_to_the_rim_than_known_ones(rng):
    field = flank(rng)
    whole, _ = field.whole_cells
    x, y = cells()
    rim = HALF + CELL - np.maximum(np.abs(x), np.abs(y))
    np.testing.assert_array_equal(whole, rim > BESIDE * CELL)
    np.testing.assert_array_equal(field.known, rim > RIM * CELL)


def test_their_heights_are_those_of_their_middles_up_to_the_rim(rng):
    field = flank(rng)
    whole, heights = field.whole_cells
    off = np.abs(heights - SLOPE * cells()[0])[whole]
    # The mean of some 90 points that lie anywhere in a cell: 0.3 mm, rms.
    assert off.max() < 1.5e-3
    # Smoothed over those beside them, they would be off at the rim alone.
    smoothed = (field.surface[..., 0] - SLOPE * cells()[0])[whole]
    assert np.abs(smoothed).max() > 2e-3


def test_of_nothing_no_cell_is_whole():
    whole, heights = HeightField().whole_cells
    assert not whole.any()
    assert np.isfinite(heights).all()
