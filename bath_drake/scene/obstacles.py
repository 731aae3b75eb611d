"""The fixed things of a scenario that the arm must keep off: stool and pedestal.

Where they stand is known, for somebody put them there.
"""

import numpy as np

from bath_drake.patient.people import load_person
from bath_drake.safety.obstacles import Boxes, upright_box
from bath_drake.scene.arm import base_pose
from bath_drake.scene.config import SceneConfig
from bath_drake.scene.room import PEDESTAL_SIDE, STOOL_RADIUS
from bath_drake.scene.studio import true_person_pose

# The links that stand on the pedestal and turn beside it keep off it by themselves.
_OFF_PEDESTAL = (3, 8)
_OFF_STOOL = (1, 8)


def fixed_obstacles(config: SceneConfig) -> Boxes:
    """Returns stool and pedestal in the arm's base frame B.

    Raises:
        ScenarioError: If the person the scenario names is not there or damaged.
    """
    X_WB = np.array(base_pose(config.arm).GetAsMatrix4())
    side, height = 0.5 * PEDESTAL_SIDE, config.arm.base_position[2]
    boxes = Boxes()
    if height > 0.0:
        boxes = upright_box([-side, -side, -height], [side, side, 0.0], _OFF_PEDESTAL)
    person = load_person(config.person)
    # The stool stands where the person sat down, whatever the person does then.
    seat = np.array(true_person_pose(config, person, 0.0).multiply(person.seat))
    around = np.array([STOOL_RADIUS, STOOL_RADIUS, 0.0])
    floor = seat * [1.0, 1.0, 0.0]
    stool = upright_box(floor - around, seat + around, _OFF_STOOL)
    return boxes + stool.seen_from(X_WB)
