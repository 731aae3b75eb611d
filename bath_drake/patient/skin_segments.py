"""The true skin over the back as a chain of slabs, to be touched.

Each is the skin at rest over a band of the back. Neighbours overlap by the depth over
which a slab's pressure grows from its sides inwards, so that the sum of both is that of
one slab: no seam is felt.
"""

import numpy as np

from bath_drake.notation import BoolArray, FloatArray, IntArray
from bath_drake.patient.people import Person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.segment_motion import SegmentedSkin, SkinSegment
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.skin_parts import follow

# m, between nodes, and from the skin to where the pressure is greatest: the same, so
# that neighbours overlap by one step.
STEP = DEPTH = 0.016
# Of the back's box in N, from the middle.
_REACH = 0.9
_SEGMENTS = 5


def segmented_skin(person: Person, *, bends: bool) -> SegmentedSkin:
    """Returns the slabs of a person's back.

    Args:
        person: Whose back.
        bends: Whether the skin will bend.

    Raises:
        ScenarioError: If the person is to bend and has no sound rig.
    """
    skin = TrueSkin(person)
    canonical_map = skin.canonical_map
    half = np.floor(_REACH * canonical_map.half_extents / STEP).astype(int)
    columns, rows = (STEP * np.arange(-n, n + 1) for n in half)
    p_P = np.stack(np.meshgrid(columns, rows, indexing="ij"), axis=-1)
    p_N = p_P.reshape(-1, 2) / canonical_map.half_extents
    p_M, met = skin.under(p_N)
    met &= skin.on_back(p_M)
    shape = p_P.shape[:2]
    grid, there = p_M.reshape(*shape, 3), met.reshape(shape)
    edges = np.linspace(0, shape[1] - 1, _SEGMENTS + 1).round().astype(int)
    segments, places, owners = [], [], []
    for k in range(_SEGMENTS):
        band = slice(edges[k], edges[k + 1] + (1 if k + 1 < _SEGMENTS else 0) + 1)
        segments.append(
            skin_segment(grid[:, band], there[:, band], canonical_map.normal_W)
        )
        core = slice(edges[k], edges[k + 1] + 1)
        places.append(grid[:, core][there[:, core]])
        owners.append(np.full(len(places[-1]), k))
    moved = None
    if bends:
        moved = follow(bending_skin(person), skin, np.concatenate(places))
    return SegmentedSkin(tuple(segments), moved, np.concatenate(owners))


def skin_segment(
    grid: FloatArray, there: BoolArray, outward: FloatArray
) -> SkinSegment:
    """Returns the slab of cells all of whose corners are there.

    Args:
        grid: (a, b, 3) nodes on the skin, m, in M, the first index to the right and the
            second up as seen from outside.
        there: (a, b) whether there is skin at a node.
        outward: (3,) unit, what the slab's depth is measured against.
    """
    cells = there[:-1, :-1] & there[1:, :-1] & there[:-1, 1:] & there[1:, 1:]
    corner = np.arange(grid.shape[0] * grid.shape[1]).reshape(grid.shape[:2])
    a, b = corner[:-1, :-1][cells], corner[1:, :-1][cells]
    c, d = corner[1:, 1:][cells], corner[:-1, 1:][cells]
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    used, triangles = np.unique(triangles, return_inverse=True)
    triangles = triangles.reshape(-1, 3)
    top = grid.reshape(-1, 3)[used]
    centre = top.mean(axis=0)
    layers = [top - centre - k * DEPTH * outward for k in range(3)]
    tetrahedra = np.concatenate(
        [_prisms(triangles + k * len(top), len(top)) for k in range(2)]
    )
    return SkinSegment(centre, np.concatenate(layers), tetrahedra, triangles)


def _prisms(triangles: IntArray, below: int) -> IntArray:
    """Tetrahedra (3 n, 4) of the prisms between triangles (n, 3) and those below.

    Each prism is cut by the order of its nodes' numbers, so that neighbours agree on
    the diagonal between them (Dompierre et al., 1999).
    """
    # Turned so that the least number comes first: the sense of rotation stays.
    first = triangles.argmin(axis=1)
    a, b, c = (triangles[np.arange(len(triangles)), (first + k) % 3] for k in range(3))
    x, y, z = a + below, b + below, c + below
    ordered = (b < c)[:, None]
    one = np.stack([x, y, z, a], axis=1)
    two = np.where(ordered, np.stack([a, y, z, b], 1), np.stack([a, y, z, c], 1))
    three = np.where(ordered, np.stack([a, b, z, c], 1), np.stack([a, y, c, b], 1))
    return np.concatenate([one, two, three])
