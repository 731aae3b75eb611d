"""A bending skin in the page that Meshcat records: a mesh a frame, shown in turn.

Meshcat's recordings move bodies but keep no vertices that move.
"""

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh, Meshcat, Rgba
from pydrake.math import RigidTransform
from scipy.spatial.transform import Rotation

from bath_drake.notation import FloatArray
from bath_drake.patient.gltf import Part, gltf_text
from bath_drake.patient.motion import trunk_bend
from bath_drake.patient.people import LABEL_BACK, load_person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin_parts import SkinPart, skin_parts
from bath_drake.rendering.normals import vertex_normals
from bath_drake.scenario import Scenario
from bath_drake.scene.studio import true_person_pose, true_wound
from bath_drake.systems._poses import at, rotation_from
from bath_drake.systems.skin_view import ROOT

# A frame takes some 0.6 MB of the page.
_MOST_FRAMES = 30
_SHORTEST_S = 0.2


def record_skin(meshcat: Meshcat, scenario: Scenario, end: float) -> None:
    """Adds the person's skin to what Meshcat recorded, if it bends.

    To be called after StopRecording and before PublishRecording.

    Args:
        meshcat: Holds the recording.
        scenario: Whose person it is.
        end: Of the recording, s.
    """
    motion = scenario.scene.motion
    if not motion.bends:
        return
    person = load_person(scenario.scene.person)
    parts = skin_parts(person, true_wound(scenario.scene, person))
    meshcat.Delete(ROOT)
    count = int(np.clip(end / _SHORTEST_S, 1, _MOST_FRAMES))
    times = np.linspace(0.0, end, count, endpoint=False)
    animation = meshcat.get_mutable_recording()
    for k, t in enumerate(times):
        X_WM, bend = true_person_pose(scenario.scene, person, t), trunk_bend(t, motion)
        for part in parts:
            path = f"{ROOT}/frame_{k}/{part.name}"
            mesh = smooth_mesh(part, part.shell.points(bend), path)
            meshcat.SetObject(path, mesh, Rgba(*part.rgba))
            meshcat.SetTransform(path, X_WM)
        path = f"{ROOT}/frame_{k}"
        seen = [(0.0, k == 0), (float(t), True)]
        if k + 1 < count:
            seen.append((float(times[k + 1]), False))
        for when, visible in seen:
            animation.SetProperty(animation.frame(when), path, "visible", visible)
        meshcat.SetProperty(path, "visible", k + 1 == count)


def smooth_mesh(part: SkinPart, shell_M: FloatArray, name: str) -> Mesh:
    """Returns a part with normals, for without them Meshcat shows every facet.

    Args:
        part: Of the skin.
        shell_M: (2 n, 3) m, where its shell is.
        name: For error messages.
    """
    outside = shell_M[: len(shell_M) // 2]
    drawn = Part(outside, part.triangles, part.rgba)
    text = gltf_text(drawn, vertex_normals(outside, part.triangles, True))
    return Mesh(InMemoryMesh(mesh_file=MemoryFile(text, ".gltf", name)), 1.0)


class BackPose:
    """Where the back of a bending person is, as far as a rigid body can follow it."""

    def __init__(self, scenario: Scenario) -> None:
        """Loads the person and the rig; ScenarioError if damaged."""
        self._motion = scenario.scene.motion
        person = load_person(scenario.scene.person)
        self._back = person.labels == LABEL_BACK
        self._bending = bending_skin(person) if self._motion.bends else None
        self._rest: FloatArray = person.vertices[self._back]

    def __call__(self, t: float) -> RigidTransform:
        """Returns X_MMr: from the back at rest to the bent one at t (s), best fit."""
        if self._bending is None:
            return RigidTransform()
        bent = self._bending.points(trunk_bend(t, self._motion))[self._back]
        before, now = self._rest.mean(axis=0), bent.mean(axis=0)
        turn, _ = Rotation.align_vectors(bent - now, self._rest - before)
        R = turn.as_matrix()
        return at(now - R @ before, rotation_from(R))
