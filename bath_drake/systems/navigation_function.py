"""The navigation function as a Drake system for every scalar."""

from typing import Any

import numpy as np
from pydrake.symbolic import Expression
from pydrake.systems.framework import (  # type: ignore[attr-defined] # new stubs
    BasicVector_,
    LeafSystem_,
    NumericParameterIndex,
)
from pydrake.systems.scalar_conversion import TemplateSystem

from bath_drake.field import generic
from bath_drake.field.navigation import NavigationField
from bath_drake.field.parameters import pack_field


def _value(scalar: Any) -> float:
    """A scalar as a float; an Expression must not hold variables."""
    if isinstance(scalar, Expression):
        return float(scalar.Evaluate())
    return float(scalar.value() if hasattr(scalar, "value") else scalar)


@TemplateSystem.define("NavigationFunction_")  # type: ignore[no-untyped-call]
def NavigationFunction_(T: Any) -> Any:
    """Makes the class of one scalar; see `NavigationFunction`."""
    # An Expression's comparisons are formulas, neither true nor false.
    plain = T is Expression

    def _write(output: Any, *values: Any) -> None:
        output.SetFromVector(values)

    class Impl(LeafSystem_[T]):  # type: ignore[misc]
        """The navigation function phi of a canonical point and its flow.

        .. pydrake_system::

            name: NavigationFunction
            input_ports:
            - canonical_position
            output_ports:
            - phi
            - ln_phi
            - flow_direction
            - flow
            - beta

        For analysis: `ToAutoDiffXd` and `ToSymbolic` work, alone and in a Diagram.
        Outputs are those of `bath_drake.field.generic`: `phi` and `ln_phi` (1);
        `flow_direction` (2), the unit vector along -grad phi; `flow` (2), a
        polynomial field along it; `beta` (1 + max_obstacles), the workspace's first,
        all positive in free space, 1 in rows that hold no obstacle.

        The whole field is the Context's numeric parameter, the same vector as
        `VirtualObstacleSource` holds for each stage: derivatives with respect to
        obstacles, goal and kappa come out of an AutoDiffXd parameter. Symbolic outputs
        are the paper's formulas: they hold in free space, without a case. Stateless.
        """

        def _construct(
            self,
            *,
            field: NavigationField,
            max_obstacles: int | None = None,
            converter: Any = None,
        ) -> None:
            """Declares ports and parameter.

            Args:
                field: The parameter's default.
                max_obstacles: How many obstacles the parameter has room for; those
                    of `field` by default.
                converter: Drake's own, for scalar conversion.

            Raises:
                ValueError: If `field` has more than `max_obstacles` obstacles.
            """
            LeafSystem_[T].__init__(self, converter=converter)
            room = len(field.obstacles) if max_obstacles is None else max_obstacles
            self._default = field
            self._room = room
            default = np.array([T(x) for x in pack_field(field, room).tolist()])
            self._theta = int(self.DeclareNumericParameter(BasicVector_[T](default)))
            self._p_NQ = self.DeclareVectorInputPort("canonical_position", 2)
            needs = {
                self._p_NQ.ticket(),
                self.numeric_parameter_ticket(NumericParameterIndex(self._theta)),
            }
            for name, size, calc in (
                ("phi", 1, self._calc_phi),
                ("ln_phi", 1, self._calc_ln_phi),
                ("flow_direction", 2, self._calc_flow_direction),
                ("flow", 2, self._calc_flow),
                ("beta", 1 + room, self._calc_beta),
            ):
                self.DeclareVectorOutputPort(name, size, calc, needs)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(
                self,
                field=other._default,
                max_obstacles=other._room,
                converter=converter,
            )

        def set_field(self, context: Any, field: NavigationField) -> None:
            """Puts another field into this system's own `context`."""
            vector = [T(x) for x in pack_field(field, self._room).tolist()]
            theta = context.get_mutable_numeric_parameter(self._theta)
            theta.SetFromVector(np.array(vector))

        def _read(self, context: Any) -> tuple[Any, generic.GenericField]:
            vector = context.get_numeric_parameter(self._theta).CopyToVector()
            field = generic.GenericField.from_vector(vector, _value)
            return self._p_NQ.Eval(context), field

        def _calc_phi(self, context: Any, output: Any) -> None:
            _write(output, generic.phi(*self._read(context), plain=plain))

        def _calc_ln_phi(self, context: Any, output: Any) -> None:
            _write(output, generic.ln_phi(*self._read(context), plain=plain))

        def _calc_flow_direction(self, context: Any, output: Any) -> None:
            _write(output, *generic.flow_direction(*self._read(context), plain=plain))

        def _calc_flow(self, context: Any, output: Any) -> None:
            _write(output, *generic.flow(*self._read(context)))

        def _calc_beta(self, context: Any, output: Any) -> None:
            q, field = self._read(context)
            values = generic.betas(q, field)
            none = generic.constant(1.0, q, field)
            _write(output, *values, *[none] * (1 + self._room - len(values)))

    return Impl


NavigationFunction = NavigationFunction_[None]
