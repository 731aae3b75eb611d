"""The carer's limbs as meshes of few triangles: each one is drawn in every frame."""

import numpy as np

from bath_drake.carer.arm import FOREARM, GRIP, HAND, UPPER_ARM
from bath_drake.notation import FloatArray
from bath_drake.rendering.solids import Shape, capsule, ellipsoid


def limbs(marker_radius: float) -> dict[str, dict[str, Shape]]:
    """Returns the meshes of each of `bath_drake.carer.arm.PARTS`, by colour.

    The marker's ball is not among them. The colours are `skin`, `sleeve` and `stick`;
    each mesh is in its part's frame.
    """
    hand = ellipsoid([0.62 * HAND, 0.0, 0.008], [0.052, 0.041, 0.019])
    for knuckle, joint, tip in _fingers():
        hand += capsule(knuckle, joint, 0.0095) + capsule(joint, tip, 0.0085)
    forearm = capsule([0, 0, 0], [0, 0, 0.5 * FOREARM], 0.027)
    forearm += ellipsoid([0, 0, 0.58 * FOREARM], [0.041, 0.046, 0.55 * FOREARM])
    forearm += ellipsoid([0, 0, FOREARM], [0.041, 0.041, 0.041])
    cuff = [0, 0, 0.35 * UPPER_ARM]
    head = capsule([0.17, 0, 0], [0.17, 0, 0.12], 0.055)
    head += ellipsoid([0.17, 0, 0.22], [0.075, 0.095, 0.115])
    return {
        "marker": {
            "stick": capsule([0, 0, marker_radius], [0, 0, GRIP + 0.06], 0.0055)
        },
        "hand": {"skin": hand},
        "forearm": {"skin": forearm},
        "upper_arm": {
            "skin": capsule([0, 0, 0], cuff, 0.043),
            "sleeve": capsule(cuff, [0, 0, UPPER_ARM], 0.062),
        },
        "trunk": {
            "skin": head,
            "sleeve": ellipsoid([0.17, 0, -0.22], [0.21, 0.13, 0.32]),
        },
    }


def _fingers() -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Knuckle, middle joint and tip of each finger, curled about the stick."""
    fingers = []
    for y in (-0.028, -0.010, 0.009, 0.027):
        knuckle = np.array([0.040, y, 0.016])
        joint = np.array([0.006, 0.75 * y, 0.027 - 0.2 * abs(y)])
        fingers.append((knuckle, joint, np.array([-0.010, 0.45 * y, 0.002])))
    thumb = [0.070, 0.034, -0.006], [0.034, 0.032, -0.014], [0.000, 0.010, -0.012]
    return [*fingers, (np.array(thumb[0]), np.array(thumb[1]), np.array(thumb[2]))]
