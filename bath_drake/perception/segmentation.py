"""The classic segmenter: Cartesian and colour filters (paper, IV-B)."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from bath_drake.notation import BoolArray, ByteArray, FloatArray
from bath_drake.perception import morphology
from bath_drake.perception.canonical import (
    MIN_POINTS,
    edges_by_level,
    principal_frame,
)
from bath_drake.perception.completion import Expectation
from bath_drake.perception.components import components
from bath_drake.perception.crop import Crop, crop_to_body
from bath_drake.perception.pixels import (
    behind_jump,
    column_steps,
    facing_along,
    inside_box,
    normals_at,
    with_rim,
)
from bath_drake.perception.principal import LEVEL
from bath_drake.perception.quantiles import median

UP_W = np.array([0.0, 0.0, 1.0])
UP_W.setflags(write=False)

# Pixels this near to the robot are beside it.
ROBOT_RIM = 2.0

# Normals are taken over so many pixels to either side: a Kinect's noise is then some
# five degrees.
NORMAL_REACH = 4

# Holes of so few pixels are the sensor's.
SPECK = 12

# Every fourth point of a back tells its axes to what noise leaves of them.
STRIDE = 4

# A disc of this share of the torso's covers no forearm, but the pieces of a back
# on both sides of the robot.
LIMB_SHARE = 0.6


@dataclass(frozen=True, kw_only=True, eq=False)
class SegmentationConfig:
    """What the classic segmenter takes for a back; lengths in metres.

    Attributes:
        box_low_W: (3,) lower corner of the workspace box in W.
        box_high_W: (3,) its upper corner.
        hue_limit: Largest distance of skin's hue from red, degrees.
        min_saturation: Least saturation of skin, 0 to 1; walls have less.
        min_value: Least brightness of skin, 0 to 1.
        jump: Neighbouring pixels further apart do not touch.
        gap_radius: Gaps in the skin that a disc of this radius cannot enter are
            closed.
        hole_area: Holes up to this area, such as wounds, belong to the back, m^2.
        max_rise: Skin whose normal has more than this cosine with the back's own
            upward axis is the top of a shoulder.
        min_breadth: The back ends, above and below, where it is less broad than
            this share of its greatest breadth.
        torso_radius: The torso is what a disc of at least this radius covers.
        torso_share: The disc's radius as a share of that of the largest disc
            inside the skin: the shoulders of stout people are stouter too.
        regain_rim: Whether the pixel at the edge comes back that the search for jumps
            takes; without a sensor's noise a back may then be a little too broad.
        min_pixels: Fewer visible pixels are no back.
        min_fraction: A smaller share of the largest area seen is no back.

    Raises:
        ValueError: If the box is empty or a number is not in its range.
    """

    box_low_W: FloatArray
    box_high_W: FloatArray
    hue_limit: float = 50.0
    min_saturation: float = 0.06
    min_value: float = 0.08
    jump: float = 0.03
    gap_radius: float = 0.02
    hole_area: float = 0.02
    max_rise: float = 0.82
    min_breadth: float = 0.5
    torso_radius: float = 0.075
    torso_share: float = 0.52
    regain_rim: bool = True
    min_pixels: int = 400
    min_fraction: float = 0.3

    def __post_init__(self) -> None:
        """Copies the box read-only and checks all numbers."""
        for name in ("box_low_W", "box_high_W"):
            corner = np.array(getattr(self, name), dtype=np.float64)
            if corner.shape != (3,) or not np.isfinite(corner).all():
                raise ValueError(f"{name} must be three finite numbers, got {corner}")
            corner.setflags(write=False)
            object.__setattr__(self, name, corner)
        if not (self.box_low_W < self.box_high_W).all():
            raise ValueError("the workspace box is empty: box_low_W >= box_high_W")
        for name in ("jump", "torso_radius"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        # The back's motion is tracked by every fourth point.
        if not self.min_pixels >= STRIDE * MIN_POINTS:
            raise ValueError(
                f"min_pixels must be at least {STRIDE * MIN_POINTS}, "
                f"got {self.min_pixels}"
            )
        for name in ("gap_radius", "hole_area"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must be >= 0, got {getattr(self, name)}")
        for name in ("min_saturation", "min_value", "min_fraction"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name} must be in 0..1, got {getattr(self, name)}")


def skin_mask(colour: ByteArray, config: SegmentationConfig) -> BoolArray:
    """Returns which pixels (H, W) of an RGB image have the colour of skin.

    Skin of every tone is orange to red in hue and grows more saturated as it
    grows darker; hue and saturation do not change with the brightness of the
    light, which is why no bound on brightness is needed but the one that keeps
    black, whose hue is noise, out.
    """
    if colour.shape[2] == 4:
        colour = np.asarray(cv2.cvtColor(colour, cv2.COLOR_RGBA2RGB))
    hsv = cv2.cvtColor(np.ascontiguousarray(colour), cv2.COLOR_RGB2HSV)
    # OpenCV halves the hue's degrees to fit a byte.
    limit = round(config.hue_limit / 2.0)
    low_s, low_v = round(config.min_saturation * 255), round(config.min_value * 255)
    orange = cv2.inRange(hsv, np.array([0, low_s, low_v]), np.array([limit, 255, 255]))
    crimson = cv2.inRange(
        hsv, np.array([180 - limit // 2, low_s, low_v]), np.array([180, 255, 255])
    )
    return np.asarray(cv2.bitwise_or(orange, crimson) > 0)


def pixel_pitch(points: FloatArray, mask: BoolArray) -> float:
    """Returns the metres between neighbouring columns of a mask, the median."""
    steps = column_steps(points, mask)
    return median(steps) if len(steps) > 0 else float("nan")


def segment_back(
    skin: BoolArray,
    points_W: FloatArray,
    robot_mask: BoolArray,
    config: SegmentationConfig,
    expected: Expectation | None = None,
) -> tuple[BoolArray, BoolArray]:
    """Finds the back: workspace box, skin, largest component, torso.

    Args:
        skin: (H, W) pixels that may show skin, as of a `Segmenter`.
        points_W: (H, W, 3), metres; NaN where nothing was measured.
        robot_mask: (H, W) pixels that may show the robot.
        config: What to take for a back.
        expected: Where the back was last; without it the convex hull and the
            axes of what is visible stand in.

    Returns:
        The visible back and the completed one, (H, W) each. The first holds no
        pixel of the robot; the second adds those of them that are `expected` to
        hide the back. Both are empty if there is no torso.
    """
    boxed = inside_box(points_W, config.box_low_W, config.box_high_W)
    crop = crop_to_body(boxed, robot_mask, expected.mask if expected else None)
    visible, completed = segment_crop(
        crop, skin, points_W[crop.window], boxed, robot_mask, config, expected
    )
    shape = boxed.shape
    return crop.placed(visible, shape), crop.placed(completed, shape)


def segment_crop(
    crop: Crop,
    skin: BoolArray,
    points_W: FloatArray,
    boxed: BoolArray,
    robot_mask: BoolArray,
    config: SegmentationConfig,
    expected: Expectation | None = None,
) -> tuple[BoolArray, BoolArray]:
    """Does as `segment_back`, where a body may be.

    Args:
        crop: The window (h, w), of `crop_to_body` with the masks given here.
        skin: (H, W) of the whole image, as all masks.
        points_W: (h, w, 3) of the window alone.
        boxed: (H, W) pixels that show something in the workspace box.
        robot_mask: (H, W) pixels that may show the robot.
        config: What to take for a back.
        expected: Where the back was last.

    Returns:
        The visible back and the completed one, (h, w) each.
    """
    window = crop.window
    if points_W.size == 0:
        nothing = np.zeros(points_W.shape[:2], dtype=bool)
        return nothing, nothing
    return _segment(
        crop,
        np.ascontiguousarray(skin[window]),
        np.ascontiguousarray(points_W),
        np.ascontiguousarray(boxed[window]),
        np.ascontiguousarray(robot_mask[window]),
        config,
        expected and replace(expected, mask=expected.mask[window]),
    )


def _segment(
    crop: Crop,
    coloured: BoolArray,
    points_W: FloatArray,
    boxed: BoolArray,
    robot_mask: BoolArray,
    config: SegmentationConfig,
    expected: Expectation | None,
) -> tuple[BoolArray, BoolArray]:
    nothing = np.zeros(boxed.shape, dtype=bool)
    boxed = boxed & ~robot_mask
    # Beside the robot a jump is the robot's, not the body's edge.
    jumps = behind_jump(points_W, boxed, config.jump)
    solid = boxed & ~(jumps & ~morphology.dilate(robot_mask, ROBOT_RIM))
    coloured = boxed & coloured
    skin = morphology.opened(solid & coloured, 1.0)
    pitch = pixel_pitch(points_W, skin)
    if not pitch > 0.0:
        return nothing, nothing
    # The robot in front of the skin must not cut it in two.
    if expected is None:
        stout = morphology.opened(skin, LIMB_SHARE * config.torso_radius / pitch)
        hidden = _hidden(robot_mask, stout)
    else:
        hidden = robot_mask & expected.mask
    skin = skin | hidden
    skin = skin | (crop.closed(skin, config.gap_radius / pitch) & solid)
    skin = _with_small_holes(skin, solid, config.hole_area / pitch**2)
    # A pixel that the sensor lost must not keep a disc of fifty out.
    skin = morphology.without_specks(skin, SPECK)
    torso = morphology.stoutest_part(
        skin, config.torso_radius / pitch, config.torso_share
    )
    # A pixel beside a jump is not solid, and the opening costs another one.
    torso = torso & ~robot_mask
    if config.regain_rim:
        torso = with_rim(points_W, torso, coloured, config.jump)
    visible = _trimmed(points_W, torso, robot_mask, config, expected)
    if expected is None:
        hidden = _hidden(robot_mask, visible)
    return visible, visible | hidden


def _hidden(robot_mask: BoolArray, visible: BoolArray) -> BoolArray:
    """Returns the robot's pixels that seem to hide the back."""
    if not robot_mask.any() or not visible.any():
        return np.zeros_like(robot_mask)
    return robot_mask & morphology.convex_hull(visible)


def _trimmed(
    points_W: FloatArray,
    torso: BoolArray,
    robot_mask: BoolArray,
    config: SegmentationConfig,
    expected: Expectation | None,
) -> BoolArray:
    """Cuts off shoulder tops, the neck's stump and what hangs below the waist."""
    # A hole that belongs to the back may hold pixels without depth.
    torso = torso & np.isfinite(points_W[..., 0])
    if int(torso.sum()) < STRIDE * MIN_POINTS:
        return np.zeros_like(torso)
    # A back that the robot hides in part has the axes of the frame before; a whole one
    # has its own, however far it has moved since.
    hidden = morphology.near(torso, robot_mask, ROBOT_RIM)
    if expected is not None and hidden:
        R_WP, span = expected.R_WP, expected.span
    else:
        # Normals are on the camera's side: so is the point their mean leads to.
        some = np.flatnonzero(torso)[::STRIDE]
        points = np.take(points_W.reshape(-1, 3), some, axis=0)
        normals = normals_at(points_W, torso, NORMAL_REACH, some)
        eye = points.mean(axis=0) + normals.mean(axis=0)
        _, R_WP = principal_frame(points, UP_W, eye)
        span = -np.inf, np.inf
    up_W = np.ascontiguousarray(R_WP[:, 1])
    torso &= ~facing_along(points_W, torso, NORMAL_REACH, up_W, config.max_rise)
    chosen = np.flatnonzero(torso)
    if len(chosen) < MIN_POINTS:
        return np.zeros_like(torso)
    points = np.take(points_W.reshape(-1, 3), chosen, axis=0)
    across, along = (points @ R_WP[:, :2]).T
    level, left, right = edges_by_level(along, across)
    breadth = np.maximum(right - left, 0.0)
    least = config.min_breadth * breadth.max()
    if robot_mask.any():
        # Where the robot touches the back its breadth is unknown, its end expected.
        touched = morphology.dilate(robot_mask, ROBOT_RIM).ravel()[chosen]
        known = (along >= span[0]) & (along <= span[1])
        breadth[level[touched & known]] = breadth.max()
    low, high = _broad_span(breadth, least)
    height = along - along.min()
    torso.ravel()[chosen[(height < low) | (height > high)]] = False
    return torso


def _broad_span(breadth: FloatArray, least: float) -> tuple[float, float]:
    """Returns the heights, m, between which a back is as broad as said.

    Between the last level that is and the next the breadth is taken to fall evenly: a
    back that ends at whole levels would jump by one of them from frame to frame.

    Args:
        breadth: (m,) of the levels from the lowest, m.
        least: m; some level is as broad.
    """
    broad = np.flatnonzero(breadth >= least)
    ends = []
    for end, step in ((broad[0], -1), (broad[-1], 1)):
        beyond = end + step
        if not 0 <= beyond < len(breadth):
            ends.append(step * np.inf)
            continue
        share = (breadth[end] - least) / (breadth[end] - breadth[beyond])
        ends.append((end + 0.5 + step * share) * LEVEL)
    return ends[0], ends[1]


def _with_small_holes(
    mask: BoolArray, solid: BoolArray, max_pixels: float
) -> BoolArray:
    """Adds the holes that lie on the surface and are no larger than allowed."""
    holes = components(~mask)
    sizes, on_surface = holes.sizes, holes.counted(solid)
    # A gap between arm and flank shows the room behind: no solid surface there.
    keep = ~holes.at_edge & (sizes <= max_pixels) & (on_surface >= 0.9 * sizes)
    return holes.painted(keep) | mask
