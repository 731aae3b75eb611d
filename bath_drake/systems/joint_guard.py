"""The guard at the robot command: the last thing before the arm."""

from functools import lru_cache
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
    State,
)

from bath_drake.notation import FloatArray
from bath_drake.safety.guard_ticks import JointTick, joint_tick
from bath_drake.safety.joint_command import Emitted, JointRange, condition_number
from bath_drake.safety.limits import GuardLimits, check_limits
from bath_drake.safety.reasons import Mode
from bath_drake.systems._guard_facts import FactPorts
from bath_drake.systems._guard_outputs import declare_guard_outputs
from bath_drake.systems._ports import drake_vector, eval_vector, set_vector
from bath_drake.systems.nozzle_kinematics import NOZZLE_FRAME

_ORIGIN = drake_vector([0.0, 0.0, 0.0])


class JointGuard(LeafSystem):
    """Passes a checked joint command, brakes, or retreats along the normal.

    .. pydrake_system::

        name: JointGuard
        input_ports:
        - joint_command
        - body_observation
        - frame_status, camera_status, map_status, body_status, surface_status,
          surface_normal, world_status, ik_status, self_distance, obstacle_distance,
          nozzle_clearance, command_stamp, wrench, loop_seconds, robot_stamp,
          following_error, reset, other_reason (optional)
        output_ports:
        - checked_command
        - hold
        - condition_number
        - guard_mode
        - guard_reason
        - present_reason
        - guard_counts
        - limited_count

    `joint_command` and `checked_command` (14) are q, v. An optional port that is not
    connected is not watched; see `bath_drake.safety.facts.GuardFacts` for what each
    says. Without `surface_normal` a RETREAT is a HOLD. `hold` is 0 under PASS and else
    1, for those who plan. `condition_number` is that of the nozzle's Jacobian at the
    emitted positions. `guard_mode` and `guard_reason` are of
    `bath_drake.safety.reasons`; `present_reason` is NONE as soon as all is well, and
    what another guard may take as its `other_reason`; `guard_counts` counts how often
    each reason began, `limited_count` the ticks at which less passed than asked for.

    Everything is checked in the periodic update, with the period `loop.period` of the
    limits, and every output is state: nothing leaves that was not checked.
    """

    def __init__(
        self,
        *,
        plant: MultibodyPlant,
        home: FloatArray,
        limits: GuardLimits,
        offset: float = 0.0,
    ) -> None:
        """Declares ports and state.

        Args:
            plant: The arm alone, finalised, seven positions.
            home: (7,) what is emitted first, at rest, rad.
            limits: What to keep to.
            offset: Of the first check, s.

        Raises:
            ValueError: If a limit is out of its range, the plant has other than seven
                positions, or home is out of the joints' range less the margin.
        """
        super().__init__()
        check_limits(limits)
        if plant.num_positions() != 7:
            raise ValueError(
                f"plant must have 7 positions, got {plant.num_positions()}"
            )
        self._limits, self._plant = limits, plant
        self._joints = JointRange(
            np.array(plant.GetPositionLowerLimits()) + limits.joints.margin,
            np.array(plant.GetPositionUpperLimits()) - limits.joints.margin,
        )
        self._check_within(home)
        self._frame = plant.GetFrameByName(NOZZLE_FRAME)
        self._world: Any = plant.world_frame()
        # A scratch pad, written before every use: it remembers nothing.
        self._scratch = plant.CreateDefaultContext()
        # A function of q alone, asked for by the update and again by who logs or plans.
        self._at = lru_cache(maxsize=8)(self._kinematics)
        self._command = self.DeclareVectorInputPort("joint_command", 14)
        self._facts = FactPorts(self)
        start = JointTick(emitted=Emitted.at_rest(home))
        index = self.DeclareAbstractState(Value[object](start))
        self._state, ticket = int(index), self.abstract_state_ticket(index)
        for name, size, calc in (
            ("checked_command", 14, self._calc_command),
            ("hold", 1, self._calc_hold),
            ("condition_number", 1, self._calc_condition),
        ):
            self.DeclareVectorOutputPort(name, size, calc, {ticket})
        declare_guard_outputs(self, self.last_tick, ticket)
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            limits.loop.period, offset, self._update
        )

    def last_tick(self, context: Any) -> JointTick:
        """Returns what the last update came to, from this system's own `context`."""
        tick: JointTick = context.get_abstract_state(self._state).get_value()
        return tick

    def set_command(self, context: Any, q: FloatArray) -> None:
        """Puts what is emitted (7,), rad, at rest, into this system's own `context`.

        Raises:
            ValueError: If it is out of the joints' range less the margin.
        """
        self._check_within(q)
        tick = JointTick(emitted=Emitted.at_rest(q))
        context.get_mutable_abstract_state(self._state).set_value(tick)

    def _check_within(self, q: FloatArray) -> None:
        low, high = self._joints.low, self._joints.high
        if np.shape(q) != (7,) or not ((q >= low) & (q <= high)).all():
            raise ValueError(
                f"home must be 7 positions within {low.tolist()} and"
                f" {high.tolist()}, got {np.asarray(q).tolist()}"
            )

    def _update(self, context: Context, state: State) -> EventStatus:
        before = self.last_tick(context)
        jacobian_W, condition = self._at(before.emitted.q.tobytes())
        tick = joint_tick(
            before,
            eval_vector(self._command, context),
            jacobian_W,
            self._facts.read(context, condition),
            joints=self._joints,
            dt=self._limits.loop.period,
            limits=self._limits,
        )
        state.get_mutable_abstract_state(self._state).set_value(tick)
        return EventStatus.Succeeded()

    def _kinematics(self, q: bytes) -> tuple[FloatArray, float]:
        """The nozzle's Jacobian (6, 7) in W, and its condition number."""
        plant, scratch, world = self._plant, self._scratch, self._world
        plant.SetPositions(scratch, drake_vector(np.frombuffer(q)))
        J_W: Any = plant.CalcJacobianSpatialVelocity(
            scratch, JacobianWrtVariable.kV, self._frame, _ORIGIN, world, world
        )
        R_WE = self._frame.CalcRotationMatrixInWorld(scratch).matrix()
        return np.ascontiguousarray(J_W), condition_number(J_W, R_WE)

    def _calc_command(self, context: Context, output: BasicVector) -> None:
        set_vector(output, self.last_tick(context).emitted.vector())

    def _calc_hold(self, context: Context, output: BasicVector) -> None:
        mode = self.last_tick(context).state.mode
        set_vector(output, [float(mode is not Mode.PASS)])

    def _calc_condition(self, context: Context, output: BasicVector) -> None:
        _, condition = self._at(self.last_tick(context).emitted.q.tobytes())
        set_vector(output, [condition])
