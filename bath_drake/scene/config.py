"""Every number of the scene, as a schema for scenario files."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bath_drake.carer.config import CarerConfig, check_carer
from bath_drake.notation import FloatArray
from bath_drake.patient.motion import DepartureConfig, MotionConfig, check_motion
from bath_drake.patient.wound import DARK
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.colour_noise import ColourNoiseConfig, check_colour_noise
from bath_drake.perception.depth_sensor import CAMERA_MODELS
from bath_drake.perception.faults import FaultsConfig, check_faults
from bath_drake.scene.arm_file import SHIPPED, completed, find_arm

CAMERA_NOISES = ("none", *CAMERA_MODELS)
FIDELITIES = ("dynamic", "kinematic", "contact")
RENDERERS = ("rasteriser", "vtk")
TOOLS = ("nozzle", "sponge")
BACKGROUNDS = ("plain", "tan_wall", "dark_wall", "clutter", "second_person")


@dataclass(kw_only=True)
class CameraConfig:
    """The depth camera; the intrinsics are those of a Kinect v2.

    A scenario that names a `model` has that one's size, intrinsics, range and noise,
    but for those that it gives itself. It looks from steeply above and behind in the
    person's plane of symmetry: the arm works from below, so that little of it comes
    between camera and back.
    """

    model: str = "kinect_v2"  # or azure_kinect, realsense_d435
    width: int = 512  # pixels
    height: int = 424  # pixels
    fx: float = 365.456  # pixels
    fy: float = 365.456  # pixels
    cx: float = 254.878  # pixels
    cy: float = 205.395  # pixels
    near: float = 0.5  # m, nearest depth it reports
    far: float = 4.5  # m, farthest depth it reports
    eye: list[float] = field(default_factory=lambda: [0.17, 0.0, 1.93])  # m, W
    target: list[float] = field(
        default_factory=lambda: [0.78, 0.0, 0.78]
    )  # m, W, what it looks at
    # Who draws its images: our rasteriser, or Drake's own engine, slower, which has
    # textures and more shapes.
    renderer: str = "rasteriser"
    noise: str = "none"  # of its depth: none, or that of a model
    colour_noise: ColourNoiseConfig | None = None
    faults: FaultsConfig = field(default_factory=FaultsConfig)

    @staticmethod
    def complete(given: dict[str, Any]) -> dict[str, Any]:
        """Returns the values of a camera of which some are given.

        Raises:
            ValueError: If there is no such model.
        """
        name = given.get("model")
        if name is None:
            return given
        _check_name("model", name, tuple(CAMERA_MODELS))
        camera, sensor = CAMERA_MODELS[name].camera, CAMERA_MODELS[name].sensor
        sizes = {k: getattr(camera, k) for k in ("width", "height")}
        lenses = {k: getattr(camera, k) for k in ("fx", "fy", "cx", "cy")}
        reach = {"near": sensor.near, "far": sensor.far, "noise": name}
        return sizes | lenses | reach | given

    def pinhole(self) -> PinholeCamera:
        """Returns the camera's projection."""
        return PinholeCamera(
            self.width, self.height, self.fx, self.fy, self.cx, self.cy
        )

    def rotation(self) -> FloatArray:
        """Returns R_WC (3, 3): z to the target, x right and level, y down."""
        eye, target = np.asarray(self.eye), np.asarray(self.target)
        z = (target - eye) / np.linalg.norm(target - eye)
        x = np.cross(z, [0.0, 0.0, 1.0])
        x /= np.linalg.norm(x)
        return np.column_stack([x, np.cross(z, x), z])


@dataclass(kw_only=True)
class ArmConfig:
    """Where the arm stands and how it follows its commands.

    Base, home and posture were searched for, so that on every shipped person's back the
    nozzle gets over the region |x| <= 0.75, |y| <= 0.8, twist and lean included but for
    some places at its lower left edge, the Jacobian's condition number nearly
    everywhere below 17, the arm clear of the person and little of it before the camera
    (docs/reach.md, `tests/test_reach.py`).
    """

    # A shipped arm, or the path of a .urdf file: see docs/arms.md.
    model: str = SHIPPED
    # dynamic: masses, motors, gravity. kinematic: it is exactly where it is told.
    # contact: dynamic, and the skin of the back can be touched.
    fidelity: str = "dynamic"
    tool: str = (
        "nozzle"  # or sponge: one on the nozzle, its face 60 mm ahead of the tip
    )
    base_position: list[float] = field(
        default_factory=lambda: [0.179, 0.28, 0.536]
    )  # m, W
    base_yaw: float = 0.451  # rad
    home: list[float] = field(
        default_factory=lambda: [-1.514, 0.449, -0.367, -1.644, -2.21, 3.02, 0.856]
    )  # rad, beside the person, out of the camera's view of the back
    # rad, to the middle of its joints' ranges while it washes: the null space is
    # drawn here, and so away from the limits.
    posture: list[float] = field(
        default_factory=lambda: [-0.51, 0.944, 0.117, -2.318, -1.486, 2.242, 0.764]
    )
    # N m/rad and N m s/rad, the implicit PD of each joint.
    stiffness: list[float] = field(
        default_factory=lambda: [2400, 2400, 2400, 2400, 1000, 600, 200]
    )
    damping: list[float] = field(default_factory=lambda: [80, 80, 80, 80, 50, 40, 20])

    @staticmethod
    def complete(given: dict[str, Any]) -> dict[str, Any]:
        """Returns the values of an arm of which some are given.

        Raises:
            ValueError: If there is no such arm, or nobody says where its home is.
        """
        return completed(given)


@dataclass(kw_only=True)
class WoundConfig:
    """An elliptic patch on the back, in the back's canonical coordinates."""

    centre: list[float] = field(default_factory=lambda: [0.0, 0.0])  # dimensionless
    semi_axes: list[float] = field(default_factory=lambda: [0.2, 0.15])  # dimensionless
    angle: float = 0.0  # rad, counter-clockwise as seen from behind
    colour: list[float] = field(
        default_factory=lambda: list(DARK)
    )  # red, green, blue, 0 to 1: dark as a scab


@dataclass(kw_only=True)
class VisitorConfig:
    """Somebody who comes in, seated as all our people are, on nothing."""

    person: str = "f_old"  # a shipped person's name, or a folder
    position: list[float] = field(
        default_factory=lambda: [1.0, 1.7, 0.0]
    )  # m, W, at first
    yaw: float = 0.0  # rad
    walk: DepartureConfig = field(
        default_factory=lambda: DepartureConfig(velocity=[0.0, -1.2, 0.0])
    )  # in the visitor's own frame


@dataclass(kw_only=True)
class SceneConfig:
    """Room, person, arm and camera."""

    person: str = "m_avg"  # a shipped person's name, or a folder
    person_position: list[float] = field(
        default_factory=lambda: [0.75, 0.0, 0.0]
    )  # m, W, origin of M
    person_yaw: float = float(np.pi / 2)  # rad; the back then faces -x of W
    background: str = "plain"  # or tan_wall, dark_wall, clutter, second_person
    time_step: float = 0.002  # s, of the plant
    motion: MotionConfig = field(default_factory=MotionConfig)
    arm: ArmConfig = field(default_factory=ArmConfig)
    camera: CameraConfig = field(default_factory=CameraConfig)
    wound: WoundConfig | None = None
    visitor: VisitorConfig | None = None
    # Who washes while the camera records; then there is no robot.
    carer: CarerConfig | None = None


def check_scene(config: SceneConfig) -> None:
    """Raises ValueError naming the field that makes no scene."""
    camera, arm = config.camera, config.arm
    _check_name("background", config.background, BACKGROUNDS)
    vectors = {
        "person_position": (config.person_position, 3),
        "camera.eye": (camera.eye, 3),
        "camera.target": (camera.target, 3),
        "arm.base_position": (arm.base_position, 3),
        "arm.home": (arm.home, 7),
        "arm.posture": (arm.posture, 7),
        "arm.stiffness": (arm.stiffness, 7),
        "arm.damping": (arm.damping, 7),
    }
    for name, (values, size) in vectors.items():
        if len(values) != size or not np.isfinite(values).all():
            raise ValueError(f"{name} must be {size} finite numbers, got {values}")
    positive = {
        "time_step": config.time_step,
        "camera.width": camera.width,
        "camera.height": camera.height,
        "camera.fx": camera.fx,
        "camera.fy": camera.fy,
        "camera.near": camera.near,
        "camera.far": camera.far - camera.near,
        "arm.stiffness": min(arm.stiffness),
        "arm.damping": min(arm.damping),
    }
    for name, value in positive.items():
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} must be positive, got {value}")
    for name, value in {
        "person_yaw": config.person_yaw,
        "arm.base_yaw": arm.base_yaw,
        "camera.cx": camera.cx,
        "camera.cy": camera.cy,
    }.items():
        if not np.isfinite(value):
            raise ValueError(f"{name} must be finite, got {value}")
    try:
        find_arm(arm.model)
    except ValueError as error:
        raise ValueError(f"arm.{error}") from error
    _check_name("arm.fidelity", arm.fidelity, FIDELITIES)
    _check_name("arm.tool", arm.tool, TOOLS)
    if arm.fidelity == "contact":
        # A hard nozzle has no business on skin.
        _check_name("arm.tool", arm.tool, ("sponge",))
    _check_name("camera.model", camera.model, tuple(CAMERA_MODELS))
    _check_name("camera.renderer", camera.renderer, RENDERERS)
    _check_name("camera.noise", camera.noise, CAMERA_NOISES)
    if camera.colour_noise is not None:
        try:
            check_colour_noise(camera.colour_noise)
        except ValueError as error:
            raise ValueError(f"camera.colour_noise.{error}") from error
    try:
        check_faults(camera.faults)
    except ValueError as error:
        raise ValueError(f"camera.faults.{error}") from error
    sight = np.subtract(camera.target, camera.eye)
    if np.hypot(sight[0], sight[1]) < 1e-3:
        raise ValueError("camera.target must not lie straight above or below the eye")
    check_motion(config.motion)
    if config.wound is not None:
        _check_wound(config.wound)
    if config.visitor is not None:
        _check_visitor(config.visitor)
    if config.carer is not None:
        if camera.faults.any:
            raise ValueError("camera.faults: a filmed carer's camera has none")
        try:
            check_carer(config.carer)
        except ValueError as error:
            raise ValueError(f"carer.{error}") from error


def _check_name(key: str, name: str, allowed: tuple[str, ...]) -> None:
    if name not in allowed:
        raise ValueError(f"{key}: found {name[:40]!r}, allowed: {', '.join(allowed)}")


def _check_visitor(visitor: VisitorConfig) -> None:
    if len(visitor.position) != 3 or not np.isfinite(visitor.position).all():
        raise ValueError(
            f"visitor.position must be 3 finite numbers, got {visitor.position}"
        )
    if not np.isfinite(visitor.yaw):
        raise ValueError(f"visitor.yaw must be finite, got {visitor.yaw}")
    try:
        check_motion(MotionConfig(departure=visitor.walk))
    except ValueError as error:
        raise ValueError(f"visitor: {error}") from error


def _check_wound(wound: WoundConfig) -> None:
    for name, values in (("centre", wound.centre), ("semi_axes", wound.semi_axes)):
        if len(values) != 2 or not np.isfinite(values).all():
            raise ValueError(f"wound.{name} must be 2 finite numbers, got {values}")
    if min(wound.semi_axes) <= 0.0:
        raise ValueError(f"wound.semi_axes must be positive, got {wound.semi_axes}")
    if len(wound.colour) != 3 or not all(0.0 <= c <= 1.0 for c in wound.colour):
        raise ValueError(f"wound.colour: found {wound.colour}, allowed three of 0 to 1")
    if not np.isfinite(wound.angle):
        raise ValueError(f"wound.angle must be finite, got {wound.angle}")
