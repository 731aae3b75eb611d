"""Films a carer into a recording, and writes down what is true about each frame."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from bath_drake.demonstrations.rgbd.writer import RgbdWriter
from bath_drake.diagrams.recording import CarerFilm, build_recording
from bath_drake.notation import FloatArray
from bath_drake.scenario import Scenario
from bath_drake.scene.carer import MARKER_LABEL
from bath_drake.simulation import Progress

# Fewer of the marker's pixels than this, as a share, count as hidden.
SEEN = 0.3


@dataclass(eq=False)
class CarerTruth:
    """What the simulator knows of a recording's frames; a list entry a frame.

    Attributes:
        t: s.
        p_N: (2,) canonical position of the point of the skin under the marker.
        discrete_N: (2,) the stroke alone, without what the hand does on top.
        phase: Of what the hand does on top, rad.
        p_W: (3,) the marker's centre in W, m.
        X_WM: (4, 4) the person's pose.
        marker_visible: Pixels of the marker that are seen, as a share of those of its
            unhidden disc; 0 to 1.
    """

    t: list[float] = field(default_factory=list)
    p_N: list[FloatArray] = field(default_factory=list)
    discrete_N: list[FloatArray] = field(default_factory=list)
    phase: list[float] = field(default_factory=list)
    p_W: list[FloatArray] = field(default_factory=list)
    X_WM: list[FloatArray] = field(default_factory=list)
    marker_visible: list[float] = field(default_factory=list)

    @property
    def seen(self) -> int:
        """In how many frames the marker is to be seen."""
        return int(np.sum(np.array(self.marker_visible) >= SEEN))


def record_carer(
    writer: RgbdWriter, scenario: Scenario, progress: Progress | None = None
) -> CarerTruth:
    """Films the scenario's carer from the first moment to the stroke's end.

    `scenario.duration` may end it sooner. The truth is written too when the recording
    is interrupted.

    Args:
        writer: Of the recording; nothing is in it yet.
        scenario: Its scene has a carer.
        progress: Called with recorded and all seconds as it goes on.

    Raises:
        BathDrakeError: As `build_recording` does, or if a file cannot be written.
    """
    film = build_recording(scenario, write_frame=writer.write)
    simulator = Simulator(film.diagram)
    period = 1.0 / scenario.perception.camera_rate
    last = min(scenario.duration, film.stroke.duration)
    truth = CarerTruth()
    try:
        for frame in range(int(np.floor(last / period + 1e-9)) + 1):
            simulator.AdvanceTo(frame * period)
            _observe(film, simulator.get_context(), truth)
            if progress is not None:
                progress(frame * period, last)
    finally:
        writer.write_truth(_arrays(film, truth))
    return truth


def _observe(film: CarerFilm, context: Context, truth: CarerTruth) -> None:
    t = context.get_time()
    X_WM = film.person_pose(t)
    R_WM = np.array(X_WM.rotation().matrix())
    p_W, _ = film.arm.marker(t, (R_WM, np.array(X_WM.translation())))
    canonical = film.skin.canonical_map.canonical_from_world(film.arm.path.contact(t))
    moment = np.array([t])
    truth.t.append(t)
    truth.p_N.append(canonical)
    truth.discrete_N.append(film.stroke.discrete(moment)[0])
    truth.phase.append(float(film.stroke.phase(moment)[0]))
    truth.p_W.append(p_W)
    truth.X_WM.append(np.array(X_WM.GetAsMatrix4()))
    truth.marker_visible.append(_visible_share(film, context, p_W))


def _visible_share(film: CarerFilm, context: Context, p_W: FloatArray) -> float:
    camera = film.diagram.GetSubsystemByName("camera")
    port = camera.GetOutputPort("label_image")
    label: Any = port.Eval(camera.GetMyContextFromRoot(context))
    seen = np.count_nonzero(label.data == MARKER_LABEL)
    config = film.scenario.scene.camera
    p_C = config.rotation().T @ (p_W - np.array(config.eye))
    # The image of a small ball: a circle across the ray, which the image plane cuts
    # aslant.
    distance2, depth, radius = p_C @ p_C, p_C[2], film.arm.marker_radius
    disc = np.pi * radius**2 * config.fx * config.fy * np.sqrt(distance2) / depth**3
    return float(min(seen / disc, 1.0))


def _arrays(film: CarerFilm, truth: CarerTruth) -> dict[str, Any]:
    frames = len(truth.t)
    shapes = {"p_N": (2,), "discrete_N": (2,), "p_W": (3,), "X_WM": (4, 4)}
    arrays = {
        name: np.array(values, dtype=np.float64).reshape(
            (frames, *shapes.get(name, ()))
        )
        for name, values in vars(truth).items()
    }
    camera, carer = film.scenario.scene.camera, film.scenario.scene.carer
    assert carer is not None
    X_WC = np.eye(4)
    X_WC[:3, :3], X_WC[:3, 3] = camera.rotation(), camera.eye
    pinhole = camera.pinhole()
    return arrays | {
        "X_WC": X_WC,
        # As `PinholeCamera` counts: a pixel's centre is at its index plus a half.
        "intrinsics": np.array([pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy]),
        "marker_radius": np.array(carer.marker_radius),
        "marker_colour": np.array(carer.marker_colour),
        "person": np.array(film.skin.person.name),
    }
