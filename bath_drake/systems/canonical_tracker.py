"""Where the nozzle washes, in canonical space: the loop's feedback."""

from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from bath_drake.perception.canonical import CanonicalMap
from bath_drake.systems._ports import drake_vector, eval_value, eval_vector, set_vector


class CanonicalTracker(LeafSystem):
    """Maps the point that the jet meets into canonical space (paper, IV-B).

    .. pydrake_system::

        name: CanonicalTracker
        input_ports:
        - nozzle_pose
        - canonical_map
        - standoff
        output_ports:
        - canonical_position

    The jet leaves the nozzle along E's z axis; the point `standoff` metres down
    it is the washed one. Stateless.
    """

    def __init__(self) -> None:
        """Declares the ports."""
        super().__init__()
        self._X_WE = self.DeclareAbstractInputPort(
            "nozzle_pose", Value(RigidTransform())
        )
        self._map = self.DeclareAbstractInputPort("canonical_map", Value[object]())
        self._standoff = self.DeclareVectorInputPort("standoff", 1)
        inputs = (self._X_WE, self._map, self._standoff)
        self.DeclareVectorOutputPort(
            "canonical_position",
            2,
            self._calc_position,
            {self.input_port_ticket(port.get_index()) for port in inputs},
        )

    def _calc_position(self, context: Context, output: BasicVector) -> None:
        X_WE = eval_value(self._X_WE, context, RigidTransform)
        canonical_map = eval_value(self._map, context, CanonicalMap)
        p_EQ = drake_vector([0.0, 0.0, eval_vector(self._standoff, context)[0]])
        set_vector(output, canonical_map.canonical_from_world(X_WE.multiply(p_EQ)))
