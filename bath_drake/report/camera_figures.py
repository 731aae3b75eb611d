"""Figures of what the camera saw: images with path and mask, and the point cloud."""

from collections.abc import Sequence

import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from bath_drake.notation import FloatArray, IntArray
from bath_drake.perception.surface import fit_surface
from bath_drake.report import style
from bath_drake.report.keyframe import Keyframe
from bath_drake.report.point_cloud import Viewpoint, draw_points, shade

_HALO = [patheffects.withStroke(linewidth=3.6, foreground="#000000", alpha=0.45)]
_NORMALS = 26
_NORMAL_LENGTH = 0.06
_FIT_RADIUS = 0.03
# A pixel's width on the back; a little more, so that the cloud is dense.
_POINT_SIZE = 0.004


def draw_camera_view(frame: Keyframe, done: FloatArray, to_come: FloatArray) -> Figure:
    """Draws one frame: image, mask, robot, canonical box, path, restricted areas.

    Args:
        frame: The key frame.
        done: Washed so far (n, 2), in N.
        to_come: The plan from here on (n, 2), in N.
    """
    figure = style.new_figure(6.4)
    axes = figure.subplots()
    _draw_view(axes, frame, done, to_come)
    _crop(axes, [frame])
    axes.set_title(f"The camera's view at {frame.time:.1f} s")
    axes.legend(handles=_legend(frame), loc="center left", bbox_to_anchor=(1.01, 0.5))
    return figure


def draw_sequence(
    frames: Sequence[Keyframe],
    done: Sequence[FloatArray],
    to_come: Sequence[FloatArray],
) -> Figure:
    """Draws frames side by side, each with its path done and to come in N."""
    figure = style.new_figure(1.0 + style.WIDTH / max(2, len(frames)) * 0.83)
    row = figure.subplots(1, len(frames), squeeze=False)[0]
    for axes, frame, past, future in zip(row, frames, done, to_come, strict=True):
        _draw_view(axes, frame, past, future)
        _crop(axes, frames)
        axes.set_title(f"{frame.time:.1f} s")
    return figure


def draw_point_cloud(frame: Keyframe, done: FloatArray, to_come: FloatArray) -> Figure:
    """Draws the depth image as a point cloud with the path and the skin's normals.

    The paper's Reproduction view (Fig. 5): path red, estimated normals blue.

    Args:
        frame: The key frame.
        done: Washed so far (n, 2), in N.
        to_come: The plan from here on (n, 2), in N.
    """
    view = _viewpoint(frame)
    near = np.isfinite(frame.depth)
    with np.errstate(invalid="ignore"):
        reach = np.linalg.norm(frame.points_W - frame.canonical_map.p_WP, axis=2)
        near &= reach < 0.62
    colours = frame.colour[near].astype(np.float64) / 255.0
    on_back = frame.mask[near]
    # Everything but the back recedes.
    colours[~on_back] = 0.35 * colours[~on_back] + 0.65 * 0.82
    light = frame.canonical_map.R_WP @ np.array([-0.35, 0.45, 1.0])
    colours = shade(colours, frame.normals_W[near], light)
    picture = draw_points(view, frame.points_W[near], colours, size=_POINT_SIZE)
    figure = style.new_figure(7.2)
    axes = figure.subplots()
    axes.imshow(picture, interpolation="antialiased")
    axes.set_axis_off()
    path = np.concatenate([done, to_come])
    bases, tips = _normals(frame, path)
    segments = np.stack([view.project(bases)[0], view.project(tips)[0]], axis=1)
    axes.add_collection(LineCollection(list(segments), colors=style.NORMAL, lw=1.8))
    lift = 0.003 * frame.canonical_map.normal_W
    for part, width in ((done, 3.2), (to_come, 1.6)):
        if len(part):
            places = view.project(frame.on_skin(part)[1] + lift)[0]
            ls = "-" if width > 2 else (0, (3, 2))
            axes.plot(*places.T, color=style.REPRODUCTION, lw=width, ls=ls)
    for outline in frame.areas.boundary(96):
        places = view.project(frame.on_skin(outline)[1] + lift)[0]
        axes.plot(*np.vstack([places, places[:1]]).T, color=style.RESTRICTED, lw=2.2)
    axes.set_xlim(0, view.width)
    axes.set_ylim(view.height, 0)
    axes.set_title(f"Point cloud of the depth image at {frame.time:.1f} s")
    handles = [
        Line2D([], [], color=style.REPRODUCTION, lw=3.2, label="washed so far"),
        Line2D([], [], color=style.REPRODUCTION, lw=1.6, ls="--", label="to come"),
        Line2D([], [], color=style.NORMAL, lw=1.8, label="estimated normals, 60 mm"),
    ]
    if len(frame.areas):
        restricted = Line2D([], [], color=style.RESTRICTED, lw=2.2)
        restricted.set_label("restricted area, sensed")
        handles.append(restricted)
    axes.legend(handles=handles, loc="lower left")
    return figure


def _draw_view(
    axes: Axes, frame: Keyframe, done: FloatArray, to_come: FloatArray
) -> None:
    image = frame.colour.astype(np.float64) / 255.0
    image[~frame.mask] = 0.72 * image[~frame.mask] + 0.28
    image[frame.robot] = 0.55 * image[frame.robot] + 0.45 * np.array(
        style.rgb(style.ROBOT)
    )
    height, width = frame.mask.shape
    axes.imshow(image, extent=(0, width, height, 0), interpolation="bicubic")
    centres = np.arange(width) + 0.5, np.arange(height) + 0.5
    axes.contour(
        *centres, frame.mask.astype(float), [0.5], colors=style.MASK, linewidths=1.6
    )
    if frame.robot.any():
        axes.contour(
            *centres,
            frame.robot.astype(float),
            [0.5],
            colors=style.ROBOT,
            linewidths=1.0,
            linestyles="--",
        )
    _draw_box(axes, frame)
    for outline in frame.areas.boundary(96):
        places = frame.on_skin(outline)[0]
        closed = np.vstack([places, places[:1]])
        axes.plot(*closed.T, color=style.RESTRICTED, lw=2.2, path_effects=_HALO)
    if len(to_come):
        places = frame.on_skin(to_come)[0]
        axes.plot(*places.T, color=style.TO_COME, lw=1.8, ls=(0, (3, 2)))
    if len(done):
        places = frame.on_skin(done)[0]
        axes.plot(*places.T, color=style.REPRODUCTION, lw=2.8)
        axes.plot(*places[-1], "o", color=style.REPRODUCTION, mec="white", ms=7)
    axes.set_axis_off()


def _crop(axes: Axes, frames: Sequence[Keyframe]) -> None:
    """Shows the part of the image where any of the frames has the back."""
    height, width = frames[0].mask.shape
    anywhere = np.sum([frame.mask for frame in frames], axis=0)
    axes.set_xlim(*_span(anywhere.sum(axis=0), width))
    low, high = _span(anywhere.sum(axis=1), height)
    axes.set_ylim(high, low)


def _span(occupied: IntArray, size: int) -> tuple[float, float]:
    """The part of an image's side that shows the back with a margin."""
    found = np.flatnonzero(occupied)
    if not found.size:
        return 0.0, float(size)
    low, high = float(found[0]), float(found[-1])
    margin = 0.28 * (high - low)
    return max(0.0, low - margin), min(float(size), high + margin)


def _draw_box(axes: Axes, frame: Keyframe) -> None:
    X_WC = frame.log.X_WC

    def image(p_N: FloatArray) -> FloatArray:
        p_W = frame.canonical_map.world_from_canonical(p_N)
        return frame.camera.project((p_W - X_WC[:3, 3]) @ X_WC[:3, :3])

    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]], dtype=float)
    axes.plot(*image(corners).T, color=style.BOX, lw=1.6, path_effects=_HALO)
    origin, along_x, along_y = image(np.array([[0, 0], [0.35, 0], [0, 0.35]]))
    for tip, name in ((along_x, "x"), (along_y, "y")):
        axes.annotate(
            "",
            xy=(tip[0], tip[1]),
            xytext=(origin[0], origin[1]),
            arrowprops={"arrowstyle": "->", "color": style.BOX, "lw": 1.8},
        )
        axes.text(
            tip[0],
            tip[1],
            f" {name}",
            color=style.BOX,
            weight="bold",
            path_effects=_HALO,
        )


def _legend(frame: Keyframe) -> list[Line2D | Patch]:
    def line(colour: str, label: str, dash: str = "-") -> Line2D:
        return Line2D([], [], color=colour, lw=2.2, ls=dash, label=label)

    handles: list[Line2D | Patch] = [
        line(style.MASK, "segmented back"),
        line(style.BOX, "canonical box and axes"),
        line(style.REPRODUCTION, "washed so far"),
        Patch(facecolor="white", edgecolor=style.MUTED, ls="--", label="path to come"),
    ]
    if frame.robot.any():
        handles.append(Patch(color=style.ROBOT, alpha=0.6, label="robot's own pixels"))
    if len(frame.areas):
        handles.append(line(style.RESTRICTED, "restricted area, sensed"))
    return handles


def _viewpoint(frame: Keyframe) -> Viewpoint:
    """From the camera's side but round to the right and above, so depth shows."""
    R_WP, target = frame.canonical_map.R_WP, frame.canonical_map.p_WP
    seen_from = R_WP.T @ (frame.log.X_WC[:3, 3] - target)
    side = np.sign(seen_from[0]) or 1.0
    direction = np.array([0.42 * side, 0.2, 1.0])
    eye = target + R_WP @ (1.7 * direction / np.linalg.norm(direction))
    return Viewpoint(eye, target, np.array([0.0, 0.0, 1.0]), 1400, 1000, 0.44)


def _normals(frame: Keyframe, path: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ends (n, 3) of short segments along the skin's normals at points of a path."""
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    length = np.append(0.0, np.cumsum(steps))
    even = np.linspace(0.0, length[-1], _NORMALS)
    chosen = np.column_stack([np.interp(even, length, path[:, k]) for k in (0, 1)])
    back = frame.points_W[frame.mask & np.isfinite(frame.depth)]
    bases, tips = [], []
    for p_N in chosen:
        patch = fit_surface(back, frame.canonical_map, p_N, _FIT_RADIUS)
        if patch.valid:
            bases.append(patch.p_WS)
            tips.append(patch.p_WS + _NORMAL_LENGTH * patch.normal_W)
    return np.reshape(bases, (-1, 3)), np.reshape(tips, (-1, 3))
