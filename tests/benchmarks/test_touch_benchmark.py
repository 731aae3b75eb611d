"""The touched skin against finite elements."""

import numpy as np
import pytest

from bath_drake.benchmarks.registry import BENCHMARKS
from bath_drake.benchmarks.touch import kuhn_block, run


def test_the_block_is_filled_and_its_cells_agree_on_their_faces():
    nodes, tetrahedra = kuhn_block((0.1, 0.2, 0.3), (2, 3, 4))
    a, b, c, d = (nodes[tetrahedra[:, k]] for k in range(4))
    volumes = np.einsum("ni,ni->n", np.cross(b - a, c - a), d - a) / 6.0
    assert len(tetrahedra) == 6 * 24
    assert volumes.min() > 0.0
    assert volumes.sum() == pytest.approx(0.006)
    assert nodes[:, 2].max() == 0.0
    faces = [np.delete(tetrahedra, k, axis=1) for k in range(4)]
    _, shared = np.unique(
        np.sort(np.concatenate(faces), axis=1), axis=0, return_counts=True
    )
    # Two triangles a square of the outside; all other faces have two sides.
    assert np.count_nonzero(shared == 1) == 2 * 2 * (2 * 3 + 3 * 4 + 4 * 2)
    assert shared.max() == 2


@pytest.mark.slow
@pytest.mark.exhaustive
def test_the_touched_skin_is_about_as_stiff_as_the_tissue_it_stands_for():
    figures = {f.name: f.value for f in run(lambda *_: None)}
    ratios = [v for k, v in figures.items() if k.endswith("ratio")]
    # A foundation is no continuum: the order of size, and nearer the deeper.
    assert min(ratios) > 0.4
    assert max(ratios) < 1.6
    ours = [v for k, v in figures.items() if k.endswith("hydroelastic")]
    assert ours == sorted(ours)
    assert "touch" in BENCHMARKS
