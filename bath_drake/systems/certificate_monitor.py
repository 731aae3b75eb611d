"""The proof of the world that is driven in, kept up to date, as a Drake system."""

from typing import Any

from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
    State,
)

from bath_drake.control.certified_world import (
    CertifiedWorld,
    certified_of,
    keep_certified,
    nothing_certified,
)
from bath_drake.control.world import World
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.systems._ports import eval_scalar, eval_value, eval_vector, set_vector
from bath_drake.systems.canonical_projector import FRAME_DELAY_S


class CertificateMonitor(LeafSystem):
    """Certifies the field anew whenever it or the sensed obstacles change.

    .. pydrake_system::

        name: CertificateMonitor
        input_ports:
        - navigation_field
        - sensed_obstacles
        - canonical_reference
        - reconciler_status (optional)
        - reconciled_worlds (optional)
        output_ports:
        - certified_world
        - certificate_verdict
        - certificate_seconds
        - certified_start
        - world_status

    The state are the `CertifiedWorld`s of the world that is driven in and of those in
    `reconciled_worlds` (a tuple of `bath_drake.control.world.World`) that may be next:
    at a gate the proof is there already. They are made in a periodic update alone, one
    at a time, so that no reader of a port waits for a proof. `certified_world` is that
    of the world at the input ports, or else the last one that was driven in (before
    the first update one that proves nothing), `certificate_verdict` a `WorldVerdict`,
    `certificate_seconds` what the proof took and `certified_start` the point in N,
    shape (2,), from which it was made.

    `world_status` is 1 where the motion from the reference is proved in the very world
    that stands at the input ports now: all of it, or the sublevel set that the
    certificate is about. It is 0 otherwise, also where `reconciler_status` is below
    one half, and until the next update after a change: then the robot must hold.
    """

    def __init__(self, *, period: float) -> None:
        """Declares ports and state.

        Args:
            period: Seconds between looks; the camera's.

        Raises:
            ValueError: Unless the period is positive and finite.
        """
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._field = self.DeclareAbstractInputPort("navigation_field", Value[object]())
        self._sensed = self.DeclareAbstractInputPort(
            "sensed_obstacles", Value(ObstacleSet())
        )
        self._p_NQ = self.DeclareVectorInputPort("canonical_reference", 2)
        self._reconciled = self.DeclareVectorInputPort("reconciler_status", 1)
        self._ahead = self.DeclareAbstractInputPort("reconciled_worlds", Value(()))
        # Value(...) of a tuple would take its items for arguments.
        self._worlds = self.DeclareAbstractState(Value[object]((nothing_certified(),)))
        driven = (self._field, self._sensed)
        state = {self.abstract_state_ticket(self._worlds)} | {
            self.input_port_ticket(port.get_index()) for port in driven
        }
        self.DeclareAbstractOutputPort(
            "certified_world",
            lambda: Value(nothing_certified()),
            self._calc_world,
            state,
        )
        for name, size, calc in (
            ("certificate_verdict", 1, self._calc_verdict),
            ("certificate_seconds", 1, self._calc_seconds),
            ("certified_start", 2, self._calc_start),
        ):
            self.DeclareVectorOutputPort(name, size, calc, state)
        inputs = (self._p_NQ, self._reconciled)
        tickets = {self.input_port_ticket(port.get_index()) for port in inputs}
        self.DeclareVectorOutputPort(
            "world_status", 1, self._calc_status, state | tickets
        )
        # Right after the reconciler made its world of the same frame: the longer the
        # world in force is without proof, the likelier the robot stops meanwhile.
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            period, 3.1 * FRAME_DELAY_S, self._certify
        )

    def _certified(self, context: Any) -> tuple[CertifiedWorld, ...]:
        state: Any = context.get_abstract_state(int(self._worlds))
        worlds: tuple[CertifiedWorld, ...] = state.get_value()
        return worlds

    def _in_force(
        self, context: Any, driven: NavigationField | None = None
    ) -> CertifiedWorld:
        worlds = self._certified(context)
        return certified_of(worlds, driven or self._driven(context)) or worlds[0]

    def _driven(self, context: Context) -> NavigationField:
        field = eval_value(self._field, context, NavigationField)
        return field.with_obstacles(eval_value(self._sensed, context, ObstacleSet))

    def _certify(self, context: Context, state: State) -> EventStatus:
        ahead: tuple[World, ...] = ()
        if self._ahead.HasValue(context):
            ahead = eval_value(self._ahead, context, tuple)
        before = self._certified(context)
        worlds = keep_certified(
            before,
            self._driven(context),
            eval_vector(self._p_NQ, context),
            [(world.field, world.start) for world in ahead],
        )
        if worlds is before:
            return EventStatus.DidNothing()
        state.get_mutable_abstract_state(int(self._worlds)).set_value(worlds)
        return EventStatus.Succeeded()

    def _calc_world(self, context: Any, output: Any) -> None:
        output.set_value(self._in_force(context))

    def _calc_verdict(self, context: Any, output: BasicVector) -> None:
        output.SetAtIndex(0, float(self._in_force(context).verdict))

    def _calc_seconds(self, context: Any, output: BasicVector) -> None:
        output.SetAtIndex(0, self._in_force(context).certificate.seconds)

    def _calc_start(self, context: Any, output: BasicVector) -> None:
        set_vector(output, self._in_force(context).start)

    def _calc_status(self, context: Any, output: BasicVector) -> None:
        driven = self._driven(context)
        point = eval_vector(self._p_NQ, context)
        sound = self._in_force(context, driven).proves(driven, point)
        if self._reconciled.HasValue(context):
            sound = sound and eval_scalar(self._reconciled, context) > 0.5
        output.SetAtIndex(0, float(sound))
