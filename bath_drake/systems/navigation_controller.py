"""The navigation-function controller as a Drake system (paper, Eq. 2)."""

from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.field.speed import NEVER_SLOWS, canonical_velocity
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.systems._ports import eval_scalar, eval_value, eval_vector, set_vector


class NavigationController(LeafSystem):
    """Drives a canonical point down the gradient of the navigation function.

    .. pydrake_system::

        name: NavigationController
        input_ports:
        - canonical_position
        - navigation_field
        - canonical_map
        - sensed_obstacles (optional)
        - final_stage (optional)
        output_ports:
        - canonical_velocity

    Points are in canonical space N, shape (2,), dimensionless; the velocity is
    in 1/s. The canonical map gives the body's size, so that the washing speed
    holds in metres along the skin. Stateless, and without any constant of the
    field. An unconnected `sensed_obstacles` means none. The speed falls towards the
    goal, except while `final_stage` is below one half: the motion then goes on to
    another field before it is there.
    """

    def __init__(
        self, *, washing_speed: float = 0.07, slow_radius: float = 0.1
    ) -> None:
        """Declares the ports.

        Args:
            washing_speed: Speed along the skin, m/s.
            slow_radius: Distance to the goal, in N, where it starts to slow.

        Raises:
            ValueError: Unless both are positive and finite.
        """
        super().__init__()
        for name, value in (
            ("washing_speed", washing_speed),
            ("slow_radius", slow_radius),
        ):
            if not 0.0 < value < float("inf"):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        self._washing_speed = washing_speed
        self._slow_radius = slow_radius
        self._p_NQ = self.DeclareVectorInputPort("canonical_position", 2)
        self._field = self.DeclareAbstractInputPort("navigation_field", Value[object]())
        self._map = self.DeclareAbstractInputPort("canonical_map", Value[object]())
        self._sensed = self.DeclareAbstractInputPort(
            "sensed_obstacles", Value[object]()
        )
        self._final = self.DeclareVectorInputPort("final_stage", 1)
        inputs = (self._p_NQ, self._field, self._map, self._sensed, self._final)
        self.DeclareVectorOutputPort(
            "canonical_velocity",
            2,
            self._calc_velocity,
            {self.input_port_ticket(port.get_index()) for port in inputs},
        )

    def _calc_velocity(self, context: Context, output: BasicVector) -> None:
        field = eval_value(self._field, context, NavigationField)
        if self._sensed.HasValue(context):
            field = field.with_obstacles(eval_value(self._sensed, context, ObstacleSet))
        goes_on = self._final.HasValue(context) and (
            eval_scalar(self._final, context) < 0.5
        )
        velocity = canonical_velocity(
            eval_vector(self._p_NQ, context),
            field,
            speed=self._washing_speed,
            half_extents=eval_value(self._map, context, CanonicalMap).half_extents,
            slow_radius=NEVER_SLOWS if goes_on else self._slow_radius,
        )
        set_vector(output, velocity)
