"""How near the arm's links come to each other, by their collision shapes."""

from typing import Any

from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from bath_drake.notation import FloatArray
from bath_drake.scene.arm import add_arm
from bath_drake.scene.config import ArmConfig
from bath_drake.systems._ports import drake_vector

# Nothing further apart than this is looked for, m.
FAR = 0.3


class ArmCollisions:
    """The arm's links as the convex shapes of its model, without those that touch."""

    def __init__(self, config: ArmConfig) -> None:
        """Loads the arm model once; the joint positions come with each call."""
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
        add_arm(plant, config)
        plant.Finalize()
        # Both refer to the diagram, which owns them.
        self._diagram = builder.Build()
        # A scratch pad, written before every use: it remembers nothing.
        root = self._diagram.CreateDefaultContext()
        self._plant, self._scene_graph = plant, scene_graph
        self._plant_context = plant.GetMyMutableContextFromRoot(root)
        self._scene_context = scene_graph.GetMyContextFromRoot(root)

    def least_distance(self, q: FloatArray) -> float:
        """Returns the least distance of two links at positions q (7,), m.

        Links that the model says may touch are left out; `FAR` where none is nearer.
        """
        self._plant.SetPositions(self._plant_context, drake_vector(q))
        query: Any = self._scene_graph.get_query_output_port().Eval(self._scene_context)
        pairs = query.ComputeSignedDistancePairwiseClosestPoints(FAR)
        return min((float(pair.distance) for pair in pairs), default=FAR)
