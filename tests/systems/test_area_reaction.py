"""An area that appears is in force within a tenth of a second, wherever it appears."""

import functools

import numpy as np
import pytest
from made_up_back import BODY, observed_back
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.systems.restricted_area_detector import RestrictedAreaDetector
from bath_drake.systems.world_reconciler import WorldReconciler

PERIOD = 1.0 / 30.0
WITHIN = 0.1
FIELD = NavigationField(
    Workspace(np.zeros(2), np.full(2, 2.0)), np.array([0.7, 0.0]), 6.0, ObstacleSet()
)
# The disc of `observed_back` in N.
PLACE = np.array([0.05, 0.05]) / BODY.half_extents


class Frames(LeafSystem):
    """Observations of a camera, with a wound from some time on."""

    def __init__(self, appears_at):
        super().__init__()
        self._appears_at = appears_at
        self.DeclareAbstractOutputPort(
            "body_observation",
            lambda: Value(BodyObservation()),
            lambda context, out: out.set_value(self._frame(context.get_time())),
            {self.time_ticket()},
        )

    def _frame(self, t):
        # The newest frame's own time; rounding must not make it the one before.
        stamp = np.floor(t / PERIOD + 1e-6) * PERIOD
        return observed(bool(stamp >= self._appears_at), float(stamp))


@functools.lru_cache(maxsize=8)
def observed(wound, stamp):
    return observed_back(wound=wound, stamp=stamp)


# s: with a frame, and just after one, when the next is a whole period away.
@pytest.mark.parametrize("appears_at", [10 * PERIOD, 10 * PERIOD + 1e-3])
@pytest.mark.parametrize("point", [[-0.7, 0.0], PLACE], ids=["elsewhere", "over it"])
def test_an_area_that_appears_is_in_force_within_a_tenth_of_a_second(appears_at, point):
    builder = DiagramBuilder()
    frames = builder.AddSystem(Frames(appears_at))
    detector = builder.AddSystem(RestrictedAreaDetector(margin=0.02, period=PERIOD))
    reconciler = builder.AddSystem(WorldReconciler(period=PERIOD))
    builder.Connect(
        frames.GetOutputPort("body_observation"),
        detector.GetInputPort("body_observation"),
    )
    builder.Connect(
        detector.GetOutputPort("sensed_obstacles"),
        reconciler.GetInputPort("sensed_obstacles"),
    )
    diagram = builder.Build()
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    of = {s: s.GetMyMutableContextFromRoot(root) for s in (detector, reconciler)}
    detector.GetInputPort("canonical_map").FixValue(of[detector], Value(BODY))
    reconciler.GetInputPort("navigation_field").FixValue(
        of[reconciler], Value[object](FIELD)
    )
    reconciler.GetInputPort("canonical_reference").FixValue(of[reconciler], point)
    areas = reconciler.GetOutputPort("restricted_areas")
    status = reconciler.GetOutputPort("world_status")
    simulator.AdvanceTo(appears_at - 1e-3)
    assert len(areas.Eval(of[reconciler])) == 0
    assert status.Eval(of[reconciler])[0] == 1.0
    simulator.AdvanceTo(appears_at + WITHIN)
    assert len(areas.Eval(of[reconciler])) == 1
    # With the motion inside it there is no sound world: the robot holds.
    inside = point is PLACE
    assert status.Eval(of[reconciler])[0] == float(not inside)
