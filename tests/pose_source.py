"""A source of nozzle poses, one every step, as the loop's ports have them."""

from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import LeafSystem


class PoseSource(LeafSystem):
    """`desired_nozzle_pose`, the last one staying, and a `hold` that never is."""

    def __init__(self, poses, step):
        super().__init__()
        self._poses, self._step = poses, step
        self.DeclareAbstractOutputPort(
            "desired_nozzle_pose",
            lambda: Value(RigidTransform()),
            lambda context, out: out.set_value(self._at(context.get_time())),
            {self.time_ticket()},
        )
        self.DeclareVectorOutputPort("hold", 1, lambda context, out: None)

    def _at(self, t):
        return self._poses[min(round(t / self._step), len(self._poses) - 1)]
