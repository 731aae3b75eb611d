"""Restricted areas on the skin, such as wounds, seen by their colour (Fig. 5)."""

import cv2
import numpy as np
from numba import njit

from bath_drake.field.obstacles import ObstacleSet
from bath_drake.notation import BoolArray, FloatArray
from bath_drake.perception import morphology
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import MIN_POINTS, CanonicalMap

# Darker than this share of the skin around it is no skin. Folds and shading reach
# 0.8, a wound on very dark skin 0.6.
DARK_SHARE = 0.7

# At the back's edge the skin turns away from the light: there only what is this
# dark counts, once more than this share of a patch's surroundings is off the back.
EDGE_DARK_SHARE = 0.5
EDGE_SHARE = 0.2

# The skin's brightness is a quadratic in the pixel, fitted again without the dark
# pixels this many times.
ROUNDS = 3

# A fit below a tenth of a byte's range is taken for that.
LEAST_BRIGHTNESS = 25.0

# Narrower than twice this, in pixels, is the rim of the mask, not an area.
RIM = 1.0

# Khachiyan's steps; an unfinished ellipse is larger, never too small.
MAX_STEPS = 1000

# Corners of the polygon that stands for the margin's disc.
CORNERS = 16


def find_restricted_areas(
    observation: BodyObservation,
    canonical_map: CanonicalMap,
    margin_m: float,
    min_area: float = 2e-4,
) -> ObstacleSet:
    """Finds patches much darker than the skin around them.

    Args:
        observation: The back; pixels of the robot are not in it.
        canonical_map: Where the back is.
        margin_m: Every point this near to a patch, along the back's plane, is
            restricted too, metres.
        min_area: Smaller patches are not counted, m^2.

    Returns:
        One ellipse in N around each patch: the least one that contains its points
        with the margin around them.

    Raises:
        ValueError: If the margin is negative.
    """
    if not margin_m >= 0.0:
        raise ValueError(f"margin_m must be >= 0, got {margin_m}")
    brightness = relative_brightness(observation)
    columns, rows = observation.pixels.T
    dark = np.zeros(observation.mask.shape, dtype=bool)
    dark[rows, columns] = brightness <= DARK_SHARE
    dark = morphology.opened(dark, RIM)
    if not dark.any():
        return ObstacleSet()
    count, labels = cv2.connectedComponents(dark.view(np.uint8), connectivity=8)
    label = labels[rows, columns]
    areas = np.bincount(label, observation.point_areas, minlength=count)
    p_P = canonical_map.plane_from_world(observation.points_W)[:, :2]
    ellipses = []
    for k in range(1, count):
        if areas[k] < min_area:
            continue
        inside = label == k
        at_edge = _edge_share(labels == k, observation) > EDGE_SHARE
        if at_edge and brightness[inside].mean() > EDGE_DARK_SHARE:
            continue
        # The skin a pixel stands for reaches half its size beyond its centre.
        reach = margin_m + np.sqrt(observation.point_areas[inside].max() / 2.0)
        ellipse = enclosing_ellipse(p_P[inside], reach)
        ellipses.append(canonical_map.ellipse_to_canonical(ellipse))
    return ObstacleSet(np.array(ellipses).reshape(-1, 5))


def relative_brightness(observation: BodyObservation) -> FloatArray:
    """Returns each point's brightness (n,) over that of the skin around it.

    The person's own skin is the measure, so it serves every tone and light.
    """
    value = observation.colours.max(axis=1, initial=0).astype(np.float64)
    columns, rows = observation.pixels.T
    if len(value) < MIN_POINTS:
        return np.ones(len(value))
    # Of order one, so that the normal equations are well conditioned.
    x = np.asarray((columns - columns.mean()) / 100.0, dtype=np.float64)
    y = np.asarray((rows - rows.mean()) / 100.0, dtype=np.float64)
    skin = value > DARK_SHARE * np.median(value)
    for _ in range(ROUNDS):
        moments, sums = _normal_equations(x, y, value, skin)
        fit = np.asarray(np.linalg.lstsq(moments, sums, rcond=None)[0])
        # Below that the ratio is of no use.
        around = np.maximum(_quadratic(x, y, fit), LEAST_BRIGHTNESS)
        skin = value > DARK_SHARE * around
        if skin.sum() < MIN_POINTS:
            return np.ones(len(value))
    return np.asarray(value / around)


@njit(cache=True)
def _normal_equations(
    x: FloatArray, y: FloatArray, value: FloatArray, used: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Returns the (6, 6) and (6,) of the least-squares fit of a quadratic."""
    moments = np.zeros((6, 6))
    sums = np.zeros(6)
    row = np.empty(6)
    for i in range(len(x)):
        if not used[i]:
            continue
        row[0], row[1], row[2] = 1.0, x[i], y[i]
        row[3], row[4], row[5] = x[i] * x[i], x[i] * y[i], y[i] * y[i]
        for j in range(6):
            sums[j] += row[j] * value[i]
            for k in range(j + 1):
                moments[j, k] += row[j] * row[k]
    for j in range(6):
        for k in range(j):
            moments[k, j] = moments[j, k]
    return moments, sums


@njit(cache=True)
def _quadratic(x: FloatArray, y: FloatArray, fit: FloatArray) -> FloatArray:
    linear = fit[0] + fit[1] * x + fit[2] * y
    return np.asarray(linear + fit[3] * x * x + fit[4] * x * y + fit[5] * y * y)


def _edge_share(area: BoolArray, observation: BodyObservation) -> float:
    """Returns the share of an area's surroundings that is neither back nor robot."""
    ring = morphology.dilate(area, 1.5) & ~area
    outside = ring & ~observation.mask & ~observation.robot_mask
    return float(outside.sum()) / max(int(ring.sum()), 1)


def enclosing_ellipse(points: FloatArray, margin: float) -> FloatArray:
    """Returns the least ellipse around points (n, 2) with a margin around each.

    Args:
        points: At least one point, metres.
        margin: Positive, metres.

    Returns:
        (5,) centre x, y, semi-axes a >= b, angle.
    """
    turns = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
    # Corners outside the circle, so that the polygon's edges touch it.
    disc = np.column_stack([np.cos(turns), np.sin(turns)]) / np.cos(np.pi / CORNERS)
    spread = (points[:, None, :] + margin * disc).reshape(-1, 2)
    hull = cv2.convexHull(spread.astype(np.float32)).reshape(-1, 2).astype(np.float64)
    return _least_ellipse(hull)


def _least_ellipse(points: FloatArray, tolerance: float = 1e-2) -> FloatArray:
    """Khachiyan's algorithm; the result is scaled to contain the points exactly."""
    u = _khachiyan_weights(np.ascontiguousarray(points), tolerance)
    centre = u @ points
    offsets = points - centre
    scatter = 2.0 * (offsets.T @ (offsets * u[:, None]))
    lengths, axes = np.linalg.eigh(scatter)
    inverse = np.linalg.inv(scatter)
    scale = np.einsum("ij,jk,ik->i", offsets, inverse, offsets).max()
    b, a = np.sqrt(lengths * scale)
    return np.array([*centre, a, b, np.arctan2(axes[1, 1], axes[0, 1])])


@njit(cache=True)
def _khachiyan_weights(points: FloatArray, tolerance: float) -> FloatArray:
    n = len(points)
    lifted = np.ones((n, 3))
    lifted[:, :2] = points
    u = np.full(n, 1.0 / n)
    for _ in range(MAX_STEPS):
        inverse = np.linalg.inv(lifted.T @ (lifted * u.reshape(-1, 1)))
        distance = ((lifted @ inverse) * lifted).sum(axis=1)
        worst = np.argmax(distance)
        if distance[worst] / 3.0 - 1.0 < tolerance:
            break
        step = (distance[worst] - 3.0) / (3.0 * (distance[worst] - 1.0))
        u *= 1.0 - step
        u[worst] += step
    return u


def merge_areas(
    known: ObstacleSet, seen: ObstacleSet, tolerance: float = 0.05
) -> ObstacleSet:
    """Adds what is seen now to what was known: an area once seen stays.

    Half hidden by the robot, a wound looks smaller than it is; so an area never
    shrinks and never goes away.

    Args:
        known: Areas in N from the frames before.
        seen: Areas in N of this frame.
        tolerance: What sticks out of a known area by less than this share of its
            size is the camera's noise and does not enlarge it.

    Returns:
        The areas from now on: a seen one inside a known one changes nothing; one
        that meets known ones makes one ellipse around all of them; another is added.
    """
    areas = [np.array(row) for row in known.theta]
    for row in seen.theta:
        outline = _outline(row)
        levels = [_level(area, outline) for area in areas]
        if any(level.max() <= (1.0 + tolerance) ** 2 for level in levels):
            continue
        meets = [
            level.min() <= 1.0 or _level(row, _outline(area)).min() <= 1.0
            for area, level in zip(areas, levels, strict=True)
        ]
        together = [_outline(a) for a, m in zip(areas, meets, strict=True) if m]
        areas = [a for a, m in zip(areas, meets, strict=True) if not m]
        if all(_level(row, other).max() <= 1.0 for other in together):
            areas.append(row)  # new, or around all it meets
        else:
            areas.append(_least_ellipse(np.concatenate([outline, *together])))
    return ObstacleSet(np.array(areas).reshape(-1, 5))


def _outline(ellipse: FloatArray, corners: int = 64) -> FloatArray:
    x, y, a, b, angle = ellipse
    turns = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    c, s = np.cos(angle), np.sin(angle)
    circle = np.column_stack([a * np.cos(turns), b * np.sin(turns)])
    return np.asarray(np.array([x, y]) + circle @ np.array([[c, s], [-s, c]]))


def _level(ellipse: FloatArray, points: FloatArray) -> FloatArray:
    """Returns (u/a)^2 + (v/b)^2 of points (n, 2): one on the ellipse."""
    x, y, a, b, angle = ellipse
    c, s = np.cos(angle), np.sin(angle)
    axes = np.array([[c, -s], [s, c]])
    local = (points - np.array([x, y])) @ axes / np.array([a, b])
    return np.asarray((local * local).sum(axis=1))
