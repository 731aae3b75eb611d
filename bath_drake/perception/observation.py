"""One frame of colour and depth into a `BodyObservation`."""

from dataclasses import dataclass

import numpy as np

from bath_drake.notation import BoolArray, ByteArray, FloatArray, IntArray
from bath_drake.perception import morphology
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.canonical import fit_canonical_map
from bath_drake.perception.completion import (
    BackTemplate,
    Expectation,
    complete_depth,
    covered_pixels,
    pixel_indices,
)
from bath_drake.perception.crop import (
    boxed_pixels,
    crop_to_body,
    points_in_window,
    seen_points,
)
from bath_drake.perception.pixels import pixel_areas, points_in_world
from bath_drake.perception.segmentation import (
    STRIDE,
    UP_W,
    SegmentationConfig,
    segment_crop,
)
from bath_drake.perception.segmenter import ClassicSegmenter, Picture, Segmenter

# A back is seen whole if the robot keeps this many pixels away from it.
TOUCH = 3.0


def observe_body(
    colour: ByteArray,
    depth: FloatArray,
    robot_mask: BoolArray,
    *,
    camera: PinholeCamera,
    R_WC: FloatArray,
    p_WC: FloatArray,
    config: SegmentationConfig,
    stamp: float,
    previous: BodyObservation | None = None,
    segmenter: Segmenter | None = None,
) -> BodyObservation:
    """Finds the back in one frame.

    Args:
        colour: (H, W, 3 or 4), RGB.
        depth: (H, W), metres; zero, NaN or infinite where nothing was measured.
        robot_mask: (H, W) pixels that may show the robot.
        camera: The camera, the same for colour and depth.
        R_WC: (3, 3) orientation of the camera in W.
        p_WC: (3,) position of the camera in W.
        config: What to take for a back.
        stamp: When the frame was taken, seconds.
        previous: The observation before this one: it hands down the largest area
            and the whole back seen so far, and its completed points where this
            frame shows no back.
        segmenter: What tells skin from the rest; None for its colour.

    Returns:
        The observation. A frame without a back is no error: `found` is False.

    Raises:
        ValueError: If an image is not of the camera's size.
    """
    for name, image in (("colour", colour), ("depth", depth), ("robot", robot_mask)):
        if image.shape[:2] != camera.shape:
            raise ValueError(
                f"{name} image must have shape {camera.shape}, got {image.shape[:2]}"
            )
    previous = previous or BodyObservation()
    R_WC = np.ascontiguousarray(R_WC, dtype=np.float64)
    p_WC = np.ascontiguousarray(p_WC, dtype=np.float64)
    view = _View(camera, R_WC, p_WC)
    low, high = config.box_low_W, config.box_high_W
    boxed = boxed_pixels(depth, camera, R_WC, p_WC, low, high)
    template_W, indices, expected = _expect(previous, view)
    segmenter = ClassicSegmenter(config) if segmenter is None else segmenter
    skin = segmenter.segment(Picture(colour, depth, camera, boxed))
    crop = crop_to_body(boxed, robot_mask, expected.mask if expected else None)
    near, near_W = points_in_window(depth, camera, R_WC, p_WC, crop.window)
    seen, completed = segment_crop(
        crop, skin, near_W, boxed, robot_mask, config, expected
    )
    visible = crop.placed(seen, camera.shape)
    points_W, point_areas, pixels = seen_points(
        near_W, near, seen, p_WC, view.focal2, crop.corner
    )
    area = float(point_areas.sum())
    reference = max(previous.reference_area, area)
    fraction = area / reference if reference > 0.0 else 0.0
    found = bool(len(pixels) >= config.min_pixels and fraction >= config.min_fraction)
    completed_W, completed_areas = previous.completed_points_W, previous.completed_areas
    template, tracked = previous.template, previous.tracked_map
    # Where this frame shows no back, what was seen has grown older.
    ages = previous.completed_ages + (stamp - previous.stamp)
    if found:
        if template is not None:
            rows, columns = indices.T
            behind = (rows >= 0) & robot_mask[rows, columns]
            hidden_W, hidden_areas = template_W[behind], template.areas[behind]
            age = stamp - template.seen_at
        else:
            whole = crop.placed(completed, camera.shape)
            hidden_W, hidden_areas = _extrapolate(depth, visible, whole, view)
            age = np.inf
        completed_W = np.concatenate([points_W, hidden_W])
        completed_areas = np.concatenate([point_areas, hidden_areas])
        ages = np.repeat([0.0, age], [len(points_W), len(hidden_W)])
        tracked = fit_canonical_map(
            completed_W[::STRIDE], UP_W, p_WC, completed_areas[::STRIDE]
        )
        if not morphology.near(visible, robot_mask, TOUCH):
            template = BackTemplate(
                tracked.plane_from_world(points_W), point_areas, stamp
            )
    places = pixels[:, 1] * camera.width + pixels[:, 0]
    return BodyObservation(
        stamp=stamp,
        mask=visible,
        robot_mask=robot_mask,
        points_W=points_W,
        pixels=pixels,
        colours=np.take(colour.reshape(-1, colour.shape[2]), places, axis=0)[:, :3],
        point_areas=point_areas,
        completed_points_W=completed_W,
        completed_areas=completed_areas,
        completed_ages=ages,
        area=area,
        template=template,
        tracked_map=tracked,
        reference_area=reference,
        visible_fraction=fraction,
        found=found,
        unfound_since=np.inf if found else min(previous.unfound_since, stamp),
        R_WC=R_WC,
        p_WC=p_WC,
        camera=camera,
    )


@dataclass(frozen=True, eq=False)
class _View:
    camera: PinholeCamera
    R_WC: FloatArray
    p_WC: FloatArray

    @property
    def focal2(self) -> float:
        return self.camera.fx * self.camera.fy


def _expect(
    previous: BodyObservation, view: _View
) -> tuple[FloatArray, IntArray, Expectation | None]:
    """Returns the template's points in W, their pixels, and what to expect."""
    last = previous.tracked_map
    if previous.template is None or last is None:
        return np.zeros((0, 3)), np.zeros((0, 2), dtype=np.int64), None
    points_W = previous.template.points_in_world(last)
    indices = pixel_indices(points_W, view.camera, view.R_WC, view.p_WC)
    mask = covered_pixels(indices, view.camera.shape)
    along = points_W @ last.R_WP[:, 1]
    span = float(along.min()), float(along.max())
    return points_W, indices, Expectation(mask, last.R_WP, span)


def _extrapolate(
    depth: FloatArray, visible: BoolArray, completed: BoolArray, view: _View
) -> tuple[FloatArray, FloatArray]:
    """Returns points (m, 3) in W, and their areas, of the hidden pixels."""
    hidden = completed & ~visible
    if not hidden.any():
        return np.zeros((0, 3)), np.zeros(0)
    depth = complete_depth(np.asarray(depth, dtype=np.float64), visible, completed)
    whole_W = points_in_world(depth, view.camera.rays, view.R_WC, view.p_WC)
    areas = pixel_areas(whole_W, depth, completed, view.p_WC, view.focal2)
    return whole_W[hidden], areas[hidden]
