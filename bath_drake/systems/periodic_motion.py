"""Circles or scrubbing on top of the discrete motion, as a Drake system."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteStateIndex,
    DiscreteValues,
    LeafSystem,
    ValueProducer,
)

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.notation import FloatArray
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.rhythm.limit_cycle import LimitCycle
from bath_drake.rhythm.superposition import Pace, Rhythm, Room, advance, offset
from bath_drake.systems._ports import (
    drake_vector,
    eval_scalar,
    eval_value,
    eval_vector,
    set_vector,
)
from bath_drake.systems._standstill import stands_still


class PeriodicMotion(LeafSystem):
    """Adds a limit cycle to the canonical reference, and paces both.

    .. pydrake_system::

        name: PeriodicMotion
        input_ports:
        - canonical_reference
        - canonical_velocity
        - canonical_position
        - navigation_field
        - final_stage
        - sensed_obstacles
        - canonical_map
        - phase (optional)
        - hold (optional)
        output_ports:
        - canonical_target
        - canonical_offset
        - discrete_velocity
        - discrete_position

    Points in canonical space N, shape (2,); velocities in 1/s. `canonical_reference` is
    the discrete motion's, `canonical_velocity` what it would have by itself;
    `discrete_velocity` is what it must have, so that the sum is no faster along the
    skin than the washing speed. `canonical_target` is the sum: `canonical_offset` on
    the reference. It is in no area of `sensed_obstacles`, within the workspace of
    `navigation_field` and the body's box, wherever the reference is, or is the
    reference itself. `discrete_position` is the measured `canonical_position` without
    the offset, to be compared with the reference. `faded` is 1 where `final_stage` is
    above one half and there is no offset any more, and else 0.

    The state is a `bath_drake.rhythm.superposition.Rhythm`: phase, deviation (2),
    share and length travelled. It stands still while `hold` is above one half or
    `phase` is not WASH; unconnected, neither is so.
    """

    def __init__(
        self,
        *,
        cycle: LimitCycle,
        length: float,
        washing_speed: float = 0.07,
        half_box: float = 1.0,
        margin: float = 0.02,
        period: float = 0.01,
    ) -> None:
        """Declares ports and state.

        Args:
            cycle: What is added.
            length: Expected of the discrete motion, in N: the cycles end before.
            washing_speed: Of the sum along the skin, at most, m/s.
            half_box: Half the side of the square that is not left, in N.
            margin: Kept to areas, rim and square, in N.
            period: Between two updates, s.

        Raises:
            ValueError: A number is not positive and finite, or the margin negative.
        """
        super().__init__()
        for name, value in (
            ("length", length),
            ("washing_speed", washing_speed),
            ("half_box", half_box),
            ("period", period),
        ):
            if not 0.0 < value < float("inf"):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        if not 0.0 <= margin < float("inf"):
            raise ValueError(f"margin must be finite and >= 0, got {margin}")
        self._cycle = cycle
        self._length = length
        self._washing_speed = washing_speed
        self._half_box = half_box
        self._margin = margin
        self._period = period
        self._p_NQ = self.DeclareVectorInputPort("canonical_reference", 2)
        self._v_NQ = self.DeclareVectorInputPort("canonical_velocity", 2)
        self._measured = self.DeclareVectorInputPort("canonical_position", 2)
        self._field = self.DeclareAbstractInputPort("navigation_field", Value[object]())
        self._final = self.DeclareVectorInputPort("final_stage", 1)
        self._areas = self.DeclareAbstractInputPort("sensed_obstacles", Value[object]())
        self._map = self.DeclareAbstractInputPort("canonical_map", Value[object]())
        self._phase = self.DeclareVectorInputPort("phase", 1)
        self._hold = self.DeclareVectorInputPort("hold", 1)
        state = self.DeclareDiscreteState(drake_vector(_packed(Rhythm())))
        self._declare_outputs(
            self.discrete_state_ticket(DiscreteStateIndex(int(state)))
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _declare_outputs(self, state: Any) -> None:
        where = {
            state,
            self._p_NQ.ticket(),
            self._field.ticket(),
            self._areas.ticket(),
        }
        pace = {
            self._v_NQ.ticket(),
            self._final.ticket(),
            self._map.ticket(),
            self._phase.ticket(),
            self._hold.ticket(),
        }
        self._offset = self.DeclareCacheEntry(
            "offset", ValueProducer(Value[object], self._calc_offset), where
        )
        # The state's update and the velocity come from one step.
        self._step = self.DeclareCacheEntry(
            "step", ValueProducer(Value[object], self._calc_step), where | pace
        )
        offset_ = {self._offset.ticket()}
        for name, calc, tickets in (
            ("canonical_target", self._calc_target, offset_ | {self._p_NQ.ticket()}),
            ("canonical_offset", self._copy_offset, offset_),
            ("discrete_velocity", self._copy_velocity, {self._step.ticket()}),
            (
                "discrete_position",
                self._calc_position,
                offset_ | {self._measured.ticket()},
            ),
        ):
            self.DeclareVectorOutputPort(name, 2, calc, tickets)
        self.DeclareVectorOutputPort(
            "faded", 1, self._calc_faded, offset_ | {self._final.ticket()}
        )

    def set_rhythm(self, context: Context, rhythm: Rhythm) -> None:
        """Puts a rhythm into this system's own `context`."""
        context.SetDiscreteState(drake_vector(_packed(rhythm)))

    def rhythm(self, context: Context) -> Rhythm:
        """The rhythm of this system's own `context`."""
        row = np.asarray(context.get_discrete_state_vector().CopyToVector())
        return Rhythm(float(row[0]), row[1:3], float(row[3]), float(row[4]))

    def _room(self, context: Context) -> Room:
        return Room(
            areas=eval_value(self._areas, context, ObstacleSet),
            workspace=eval_value(self._field, context, NavigationField).workspace,
            half_box=self._half_box,
            margin=self._margin,
        )

    def _calc_offset(self, context: Any, output: Any) -> None:
        q = eval_vector(self._p_NQ, context)
        rhythm = self.rhythm(context)
        output.set_value(offset(self._cycle, rhythm, q, self._room(context)))

    def _calc_step(self, context: Any, output: Any) -> None:
        velocity = eval_vector(self._v_NQ, context)
        rhythm = self.rhythm(context)
        if stands_still(self._phase, self._hold, context):
            output.set_value((rhythm, velocity))
            return
        q = eval_vector(self._p_NQ, context)
        to_goal = np.inf
        if eval_scalar(self._final, context) > 0.5:
            goal = eval_value(self._field, context, NavigationField).goal
            to_goal = float(np.hypot(*(goal - q)))
        half_extents = eval_value(self._map, context, CanonicalMap).half_extents
        step = advance(
            self._cycle,
            rhythm,
            q,
            velocity,
            to_goal,
            self._room(context),
            Pace(self._washing_speed, half_extents, self._length),
            self._period,
        )
        output.set_value(step)

    def _offset_now(self, context: Any) -> FloatArray:
        found: Any = self._offset.Eval(context)
        return np.asarray(found)

    def _calc_target(self, context: Any, output: BasicVector) -> None:
        reference = eval_vector(self._p_NQ, context)
        set_vector(output, reference + self._offset_now(context))

    def _copy_offset(self, context: Any, output: BasicVector) -> None:
        set_vector(output, self._offset_now(context))

    def _copy_velocity(self, context: Any, output: BasicVector) -> None:
        step: Any = self._step.Eval(context)
        set_vector(output, step[1])

    def _calc_position(self, context: Any, output: BasicVector) -> None:
        measured = eval_vector(self._measured, context)
        set_vector(output, measured - self._offset_now(context))

    def _calc_faded(self, context: Any, output: BasicVector) -> None:
        final = eval_scalar(self._final, context) > 0.5
        set_vector(output, [float(final and not self._offset_now(context).any())])

    def _update(self, context: Any, state: DiscreteValues) -> None:
        step: Any = self._step.Eval(context)
        state.set_value(drake_vector(_packed(step[0])))


def _packed(rhythm: Rhythm) -> FloatArray:
    return np.array(
        [rhythm.phase, *rhythm.deviation, rhythm.share, rhythm.travelled],
        dtype=np.float64,
    )
