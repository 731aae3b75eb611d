"""The fixed things of a scenario that the arm must keep off: stool and pedestal.

Where they stand is known, for somebody put them there.
"""

import numpy as np

from bath_drake.patient.people import Person, load_person
from bath_drake.safety.obstacles import Boxes, upright_box
from bath_drake.scene.arm import base_pose
from bath_drake.scene.config import SceneConfig
from bath_drake.scene.room import PEDESTAL_SIDE, STOOL_RADIUS
from bath_drake.scene.studio import true_person_pose
from bath_drake.systems._ports import drake_vector

# The links that stand on the pedestal and turn beside it keep off it by themselves.
_OFF_PEDESTAL = (3, 8)
_OFF_STOOL = (1, 8)


def fixed_obstacles(config: SceneConfig) -> Boxes:
    """Returns stool and pedestal in the arm's base frame B.

    Raises:
        ScenarioError: If the person the scenario names is not there or damaged.
    """
    X_WB = np.array(base_pose(config.arm).GetAsMatrix4())
    stool_W = stool_obstacle(config, load_person(config.person))
    return pedestal_obstacle(X_WB[2, 3]) + stool_W.seen_from(X_WB)


def pedestal_obstacle(height: float) -> Boxes:
    """Returns what the base stands on so high, m, in B; nothing on the floor."""
    if not height > 0.0:
        return Boxes()
    side = 0.5 * PEDESTAL_SIDE
    return upright_box([-side, -side, -height], [side, side, 0.0], _OFF_PEDESTAL)


def stool_obstacle(config: SceneConfig, person: Person) -> Boxes:
    """Returns the stool in W, where the person sat down, whatever it does then."""
    X_WM = true_person_pose(config, person, 0.0)
    seat = np.array(X_WM.multiply(drake_vector(person.seat)))
    around = np.array([STOOL_RADIUS, STOOL_RADIUS, 0.0])
    floor = seat * [1.0, 1.0, 0.0]
    return upright_box(floor - around, seat + around, _OFF_STOOL)
