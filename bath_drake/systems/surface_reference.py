"""From a canonical point to the skin there and the nozzle's pose over it."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import (
    BasicVector,
    Context,
    LeafSystem,
    ValueProducer,
)

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.recalled_skin import RecalledSkin
from bath_drake.perception.surface import (
    MAX_RADIUS,
    SurfacePatch,
    desired_nozzle_pose,
    fit_surface,
)
from bath_drake.perception.surface_velocity import moved_patch
from bath_drake.systems._ports import drake_vector, eval_value, eval_vector, set_vector
from bath_drake.systems.canonical_projector import unknown_map

# Longer than a slow camera's period; skin is no more extrapolated after it.
HORIZON_S = 0.1

_NO_PATCH = SurfacePatch(
    p_WS=np.zeros(3),
    normal_W=np.array([0.0, 0.0, 1.0]),
    curvatures=np.zeros(2),
    count=0,
    rms=0.0,
    radius=0.0,
    valid=False,
)


class SurfaceReference(LeafSystem):
    """Finds the skin at the canonical reference and squares the nozzle to it.

    .. pydrake_system::

        name: SurfaceReference
        input_ports:
        - canonical_reference
        - canonical_map
        - body_observation
        - standoff
        - surface_velocity (optional)
        - recalled_skin (optional)
        output_ports:
        - surface_patch
        - desired_nozzle_pose
        - surface_status
        - surface_normal

    `standoff` is in metres. `desired_nozzle_pose` is X_WE. `surface_status` is 1
    where the skin was seen well enough and 0 where not; then the pose is one over
    the back's plane and must not be followed, and `surface_normal`, else the outward
    unit normal (3) in W, is zero. With `surface_velocity`, rad/s and m/s
    in W, patch and pose are where the skin has gone to since the frame was taken, for
    up to `HORIZON_S`; without, where it was seen. With `recalled_skin` it is found
    where the robot hides it, too. Stateless.
    """

    def __init__(self, *, radius: float = 0.03, roll: float = 0.0) -> None:
        """Declares the ports.

        Args:
            radius: Of the fitted neighbourhood, metres.
            roll: See `bath_drake.perception.surface.desired_nozzle_pose`.

        Raises:
            ValueError: If the radius is out of its range or the roll not finite.
        """
        super().__init__()
        if not 0.0 < radius <= MAX_RADIUS:
            raise ValueError(f"radius must be in (0, {MAX_RADIUS}] m, got {radius}")
        if not np.isfinite(roll):
            raise ValueError(f"roll must be finite, got {roll}")
        self._radius = radius
        self._roll = roll
        self._p_NQ = self.DeclareVectorInputPort("canonical_reference", 2)
        self._map = self.DeclareAbstractInputPort("canonical_map", Value(unknown_map()))
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value(BodyObservation())
        )
        self._standoff = self.DeclareVectorInputPort("standoff", 1)
        self._velocity = self.DeclareVectorInputPort("surface_velocity", 6)
        self._recalled = self.DeclareAbstractInputPort(
            "recalled_skin", Value(RecalledSkin())
        )
        sources = {
            self._recalled.ticket(),
            self._p_NQ.ticket(),
            self._map.ticket(),
            self._observation.ticket(),
        }
        # Fitted once a frame and reference, however often the patch is moved on.
        self._fit = self.DeclareCacheEntry(
            "fitted_patch",
            ValueProducer(lambda: Value(_NO_PATCH), self._calc_fit),
            sources,
        )
        now = {self._fit.ticket(), self._velocity.ticket(), self.time_ticket()}
        self._patch = self.DeclareAbstractOutputPort(
            "surface_patch", lambda: Value(_NO_PATCH), self._calc_patch, now
        )
        self.DeclareAbstractOutputPort(
            "desired_nozzle_pose",
            lambda: Value(RigidTransform()),
            self._calc_pose,
            now | {self._map.ticket(), self._standoff.ticket()},
        )
        self.DeclareVectorOutputPort("surface_status", 1, self._calc_status, sources)
        self.DeclareVectorOutputPort("surface_normal", 3, self._calc_normal, now)

    def _calc_fit(self, context: Any, output: Any) -> None:
        observation = eval_value(self._observation, context, BodyObservation)
        recalled = RecalledSkin()
        if self._recalled.HasValue(context):
            recalled = eval_value(self._recalled, context, RecalledSkin)
        patch = fit_surface(
            observation.points_W,
            eval_value(self._map, context, CanonicalMap),
            eval_vector(self._p_NQ, context),
            self._radius,
            recalled.points_W,
        )
        output.set_value(patch)

    def _calc_patch(self, context: Any, output: Any) -> None:
        patch: Any = self._fit.Eval(context)
        if self._velocity.HasValue(context):
            observation = eval_value(self._observation, context, BodyObservation)
            age = context.get_time() - observation.stamp
            velocity = eval_vector(self._velocity, context)
            patch = moved_patch(patch, velocity, min(max(age, 0.0), HORIZON_S))
        output.set_value(patch)

    def _calc_pose(self, context: Any, output: Any) -> None:
        (standoff,) = eval_vector(self._standoff, context)
        patch: Any = self._patch.Eval(context)
        canonical_map = eval_value(self._map, context, CanonicalMap)
        R_WE, p_WE = desired_nozzle_pose(patch, standoff, canonical_map, self._roll)
        output.set_value(
            RigidTransform(RotationMatrix(drake_vector(R_WE)), drake_vector(p_WE))
        )

    def _calc_status(self, context: Context, output: BasicVector) -> None:
        patch: Any = self._fit.Eval(context)
        set_vector(output, [float(patch.valid)])

    def _calc_normal(self, context: Context, output: BasicVector) -> None:
        patch: Any = self._patch.Eval(context)
        set_vector(output, patch.normal_W if patch.valid else np.zeros(3))
