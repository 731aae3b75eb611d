"""The learned field as a Drake system: a parameterised source."""

from typing import Any

from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    LeafSystem,
    NumericParameterIndex,
)

from bath_drake.field.navigation import NavigationField
from bath_drake.field.parameters import pack_field, unpack_field
from bath_drake.systems._ports import drake_vector


class VirtualObstacleSource(LeafSystem):
    """Gives the navigation field that its numeric parameter describes.

    .. pydrake_system::

        name: VirtualObstacleSource
        output_ports:
        - navigation_field

    The whole field is the Context's numeric parameter (obstacle rows padded to
    `max_obstacles` with their count, kappa, goal, workspace; see
    `bath_drake.field.parameters`), so one Diagram serves every skill.
    """

    def __init__(self, *, field: NavigationField, max_obstacles: int = 32) -> None:
        """Declares the parameter with `field` as its default.

        Raises:
            ValueError: If `field` has more than `max_obstacles` obstacles.
        """
        super().__init__()
        self._max_obstacles = max_obstacles
        default = drake_vector(pack_field(field, max_obstacles))
        self._theta = int(self.DeclareNumericParameter(BasicVector(default)))
        self.DeclareAbstractOutputPort(
            "navigation_field",
            lambda: Value(field),
            self._calc_field,
            {self.numeric_parameter_ticket(NumericParameterIndex(self._theta))},
        )

    def set_field(self, context: Context, field: NavigationField) -> None:
        """Puts another field into this system's own `context`."""
        vector = drake_vector(pack_field(field, self._max_obstacles))
        context.get_mutable_numeric_parameter(self._theta).SetFromVector(vector)

    def _calc_field(self, context: Any, output: Any) -> None:
        vector = context.get_numeric_parameter(self._theta).CopyToVector()
        output.set_value(unpack_field(vector))
