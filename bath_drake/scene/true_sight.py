"""Who tells ideal perception of the true back: the one way of the truth into a loop."""

from collections.abc import Sequence

import numpy as np

from bath_drake.patient.true_back import TrueBack
from bath_drake.scene.assembly import Scene


def true_sight(
    scene: Scene, *, margin: float, given: Sequence[Sequence[Sequence[float]]]
) -> TrueBack:
    """Returns the true back of a scene's person.

    Args:
        scene: Its person, wound and camera's place.
        margin: Kept around wound and given areas, m.
        given: Polygons in N that the carer wants kept off.
    """
    camera = scene.config.camera
    return TrueBack(
        scene.person,
        bends=scene.config.motion.bends,
        wound=scene.wound,
        given=given,
        margin=margin,
        camera=camera.pinhole(),
        R_WC=camera.rotation(),
        p_WC=np.array(camera.eye),
    )
