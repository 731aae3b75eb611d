"""The shower scene: person, arm, room, camera, and the numbers of it all."""

from bath_drake.patient.motion import MotionConfig
from bath_drake.patient.people import Person, load_person
from bath_drake.scene.arm import ArmGeometry, home_position, make_control_plant
from bath_drake.scene.assembly import Scene, add_scene
from bath_drake.scene.config import ArmConfig, CameraConfig, SceneConfig, WoundConfig

__all__ = [
    "ArmConfig",
    "ArmGeometry",
    "CameraConfig",
    "MotionConfig",
    "Person",
    "Scene",
    "SceneConfig",
    "WoundConfig",
    "add_scene",
    "home_position",
    "load_person",
    "make_control_plant",
]
