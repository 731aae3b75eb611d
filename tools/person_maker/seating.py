"""The seated pose, and the skin that follows the joints: linear blend skinning."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from person_maker.makehuman import Body, MakeHuman

Floats = NDArray[np.float64]

# Slouching, spread over the spine's five joints, degrees.
_SLOUCH = 20.0
_SPINE = ("spine05", "spine04", "spine03", "spine02", "spine01")


def seated_turns() -> dict[str, Floats]:
    """Rotations (3, 3) of the joints of one who sits, forearms before the belly.

    Each is about axes that the joint's parent carries along from the standing body's:
    x to the left, y back, z up.
    """

    def about(axis: str, degrees: float) -> Floats:
        return Rotation.from_euler(axis, degrees, degrees=True).as_matrix()

    turns = {joint: about("x", _SLOUCH / len(_SPINE)) for joint in _SPINE}
    turns |= {"neck01": about("x", 6.0), "neck02": about("x", 4.0)}
    for side, sign in (("L", 1.0), ("R", -1.0)):
        turns |= {
            f"upperleg01.{side}": about("z", 10.0 * sign) @ about("x", -86.0),
            f"lowerleg01.{side}": about("x", 86.0),
            f"clavicle.{side}": about("z", -6.0 * sign),
            f"upperarm01.{side}": about("x", -38.0) @ about("y", 34.0 * sign),
            f"lowerarm01.{side}": about("x", -35.0) @ about("z", -14.0 * sign),
        }
    return turns


def joint_pose(human: MakeHuman, body: Body, turns: dict[str, Floats]) -> Floats:
    """Rotations (j, 3, 3) of every joint within its own rest frame."""
    unknown = set(turns) - set(human.names)
    if unknown:
        raise ValueError(f"turns: no such joint: {', '.join(sorted(unknown))}")
    pose = np.tile(np.eye(3), (len(human.names), 1, 1))
    # What a joint and all above it have turned since the body stood.
    turned = pose.copy()
    for j, name in enumerate(human.names):
        above = human.parents[j]
        carried = turned[above] if above >= 0 else np.eye(3)
        own = carried.T @ turns.get(name, np.eye(3)) @ carried
        turned[j] = carried @ own
        rest = body.joints[j, :3, :3]
        pose[j] = rest.T @ own @ rest
    return pose


def skinned(
    human: MakeHuman, body: Body, pose: Floats, weights: Floats | None = None
) -> Floats:
    """Vertices (n, 3) of a body in a pose; with other weights (n, j) if given."""
    placed = np.empty_like(body.joints)
    for j, above in enumerate(human.parents):
        local = body.joints[j].copy()
        if above >= 0:
            local = np.linalg.solve(body.joints[above], local)
        local[:3, :3] = local[:3, :3] @ pose[j]
        placed[j] = local if above < 0 else placed[above] @ local
    moved = placed @ np.linalg.inv(body.joints)
    blend = (human.weights if weights is None else weights) @ moved.reshape(-1, 16)
    blend = blend.reshape(-1, 4, 4)
    turned = np.einsum("nij,nj->ni", blend[:, :3, :3], body.vertices)
    return turned + blend[:, :3, 3]
