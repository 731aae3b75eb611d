"""The learned chain of fields as a Drake system: a parameterised source."""

from typing import Any

from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    LeafSystem,
    NumericParameterIndex,
)

from bath_drake.composition.chain import Chain
from bath_drake.composition.parameters import pack_chain, unpack_chain
from bath_drake.systems._ports import drake_vector


class VirtualObstacleSource(LeafSystem):
    """Gives the chain of navigation fields that its numeric parameter describes.

    .. pydrake_system::

        name: VirtualObstacleSource
        output_ports:
        - navigation_chain

    The whole chain is the Context's numeric parameter (the number of stages; for each
    its field with obstacle rows padded to `max_obstacles`, kappa, goal and workspace,
    and its gate; see `bath_drake.composition.parameters`), so one Diagram serves every
    skill, single or composed.
    """

    def __init__(
        self, *, chain: Chain, max_stages: int = 32, max_obstacles: int = 32
    ) -> None:
        """Declares the parameter with `chain` as its default.

        Raises:
            ValueError: If `chain` has more than `max_stages` fields or one of them
                more than `max_obstacles` obstacles.
        """
        super().__init__()
        self._room = (max_stages, max_obstacles)
        default = drake_vector(pack_chain(chain, *self._room))
        self._theta = int(self.DeclareNumericParameter(BasicVector(default)))
        self.DeclareAbstractOutputPort(
            "navigation_chain",
            lambda: Value(chain),
            self._calc_chain,
            {self.numeric_parameter_ticket(NumericParameterIndex(self._theta))},
        )

    def set_chain(self, context: Context, chain: Chain) -> None:
        """Puts another chain into this system's own `context`."""
        vector = drake_vector(pack_chain(chain, *self._room))
        context.get_mutable_numeric_parameter(self._theta).SetFromVector(vector)

    def _calc_chain(self, context: Any, output: Any) -> None:
        vector = context.get_numeric_parameter(self._theta).CopyToVector()
        output.set_value(unpack_chain(vector, self._room[0]))
