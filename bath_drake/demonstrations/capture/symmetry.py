"""The back's plane of symmetry, and the box of a back that is seen from one side.

A camera that stands aside sees more of one flank than of the other, and the box of
what it sees is off the spine. Backs are alike on both sides: the surface is mirrored
and laid over itself, as rasterstereography finds the line of symmetry of a back
[Drerup and Hierholzer, J. Biomechanics 20(10), 1987], and what one side hides is
taken from the other.
"""

import numpy as np

from bath_drake.demonstrations.capture.rigid_tracking import (
    AT_REST,
    RigidSurface,
    track,
)
from bath_drake.demonstrations.capture.view import View
from bath_drake.notation import BoolArray, FloatArray
from bath_drake.perception import morphology
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.quantiles import trimmed_range
from bath_drake.perception.segmentation import pixel_pitch

# Each round lays the mirror image over the surface from where the last one ended.
ROUNDS = 2
# Fewer points than this share find their partner on the other side of no midline.
MIN_SHARE = 0.2
# The mirror image of a point is seen if the surface faces the camera there (cosine)
# and is measured at its depth to within this, m.
FACING, AGREES = 0.2, 0.02
# Around the mask its mirror image counts as in it, pixels.
EDGE = 1.5
# Share of the surface left out at each end of each axis, as in `fit_canonical_map`.
TRIM = 0.01
# The segmenter leaves the ring of pixels beside a jump of depth out, and the others'
# centres are half a pixel inside the flank.
OUTSIDE = 1.5


def sagittal_plane(
    surface: RigidSurface, depth: FloatArray, view: View, guess: CanonicalMap
) -> tuple[FloatArray, float] | None:
    """Finds the plane of symmetry n . p = d of a surface.

    Args:
        surface: In the camera's frame C.
        depth: (H, W) the depth image that shows it, m.
        view: Whose image it is.
        guess: With C for W: where the midline about is.

    Returns:
        n (3,), unit, to the person's right, and d, m; None if the surface does not
        fit its mirror image.
    """
    n, d = guess.R_WP[:, 0].copy(), float(guess.R_WP[:, 0] @ guess.p_WP)
    for _ in range(ROUNDS):
        mirrored = RigidSurface(
            _mirrored(surface.points, n, d), _mirrored(surface.normals, n, 0.0)
        )
        moved = track(mirrored, depth, view.camera, AT_REST)
        if moved.share < MIN_SHARE:
            return None
        # A reflection and a small motion: the reflection that is nearest to both.
        whole = moved.R @ (np.eye(3) - 2.0 * np.outer(n, n))
        _, axes = np.linalg.eigh((whole + whole.T) / 2.0)
        n = axes[:, 0] * np.sign(axes[:, 0] @ n)
        middle = surface.points + moved.to_camera(mirrored.points)
        d = float(np.mean(middle @ n) / 2.0)
    return n, d


def symmetric_map(
    depth: FloatArray,
    back: BoolArray,
    view: View,
    n: FloatArray,
    d: float,
) -> CanonicalMap:
    """Fits the canonical map to a back and its mirror image.

    x is the plane's normal; y and z are principal axes in the plane.

    Args:
        depth: (H, W) m.
        back: (H, W) the back that is seen.
        view: Whose image it is.
        n: (3,) normal of the plane of symmetry, in C.
        d: The plane's distance, m.

    Returns:
        The map, with C for W.
    """
    _, normals_C = view.smoothed(depth, back)
    points, normals = view.points_C(depth)[back], normals_C[back]
    mirrored, facing = _mirrored(points, n, d), _mirrored(normals, n, 0.0)
    partner, hidden = _seen(mirrored, facing, depth, back, view)
    # Seen on both sides it is there twice already. What lies off the back on the
    # other side is no back on this one: an arm before it, say.
    weight = np.where(partner, 1.0, np.where(hidden, 2.0, 0.0))
    weights = np.tile(weight * view.areas(depth, back)[back], 2)
    both = np.concatenate([points, mirrored])
    mean = weights @ both / weights.sum()
    offsets = both - mean
    in_plane = offsets - np.outer(offsets @ n, n)
    _, axes = np.linalg.eigh((in_plane * weights[:, None]).T @ in_plane)
    y = axes[:, 2] * (1.0 if axes[:, 2] @ view.up_C >= 0.0 else -1.0)
    R_CP = np.column_stack([n, y, np.cross(n, y)])
    p_P, counted = offsets @ R_CP, weights > 0.0
    low, high = np.array(
        [trimmed_range(p_P[counted, k], weights[counted], TRIM) for k in (0, 1)]
    ).T
    centre = np.append((low + high) / 2.0, 0.0)
    half = (high - low) / 2.0
    half[0] += OUTSIDE * pixel_pitch(view.points_C(depth), back)
    return CanonicalMap(R_CP, mean + R_CP @ centre, half)


def _mirrored(vectors: FloatArray, n: FloatArray, d: float) -> FloatArray:
    return np.asarray(vectors - 2.0 * np.outer(vectors @ n - d, n))


def _seen(
    points: FloatArray,
    normals: FloatArray,
    depth: FloatArray,
    back: BoolArray,
    view: View,
) -> tuple[BoolArray, BoolArray]:
    """Whether points (n, 3) lie in the back's image, and whether they are hidden."""
    camera = view.camera
    columns = (camera.fx * points[:, 0] / points[:, 2] + camera.cx).astype(np.int64)
    rows = (camera.fy * points[:, 1] / points[:, 2] + camera.cy).astype(np.int64)
    inside = (columns >= 0) & (columns < camera.width)
    inside &= (rows >= 0) & (rows < camera.height)
    columns, rows = np.where(inside, columns, 0), np.where(inside, rows, 0)
    cosine = -np.sum(normals * points, axis=1) / np.linalg.norm(points, axis=1)
    measured = np.abs(depth[rows, columns] - points[:, 2]) <= AGREES
    partner = inside & morphology.dilate(back, EDGE)[rows, columns]
    hidden = ~partner & ~(inside & (cosine >= FACING) & measured)
    return partner, hidden
