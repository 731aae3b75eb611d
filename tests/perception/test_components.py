"""A mask's components are those that OpenCV finds, in the same order."""

import cv2
import numpy as np
import pytest

from bath_drake.perception import morphology
from bath_drake.perception.components import components


@pytest.fixture
def rng():
    return np.random.default_rng(12)


def _masks(rng, density):
    """Masks of single pixels, and smoother ones."""
    for shape in ((1, 1), (1, 9), (9, 1), (23, 31), (60, 41)):
        mask = rng.random(shape) < density
        yield mask
        yield morphology.opened(mask, 1.0)
        yield morphology.dilate(mask & (rng.random(shape) < 0.2), 2.0)


@pytest.mark.parametrize("density", [0.0, 0.2, 0.5, 0.7, 0.95, 1.0])
def test_components_are_opencvs(rng, density):
    for mask in _masks(rng, density):
        count, labels, stats, _ = cv2.connectedComponentsWithStats(
            mask.view(np.uint8), connectivity=4
        )
        found = components(mask)
        np.testing.assert_array_equal(found.sizes, stats[1:, cv2.CC_STAT_AREA])
        other = rng.random(mask.shape) < 0.5
        inside = np.bincount(labels[other], minlength=count)[1:]
        np.testing.assert_array_equal(found.counted(other), inside)
        for k in range(count - 1):
            own = found.painted(np.arange(count - 1) == k)
            np.testing.assert_array_equal(own, labels == k + 1)
            rim = np.ones_like(mask)
            rim[1:-1, 1:-1] = False
            assert found.at_edge[k] == (own & rim).any()


@pytest.mark.parametrize("density", [0.0, 0.2, 0.5, 0.7, 0.95, 1.0])
def test_what_a_mask_encloses_is_what_is_inside_its_outlines(rng, density):
    for mask in _masks(rng, density):
        outlines, _ = cv2.findContours(
            mask.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
        )
        canvas = np.zeros(mask.shape, dtype=np.uint8)
        cv2.drawContours(canvas, outlines, -1, 1, thickness=cv2.FILLED)
        np.testing.assert_array_equal(morphology.without_holes(mask), canvas > 0)
