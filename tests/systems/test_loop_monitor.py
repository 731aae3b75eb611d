import numpy as np
import pytest
from pydrake.systems.analysis import Simulator, SimulatorStatus

from bath_drake.control.approach import Phase
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.safety.outcome import LoopBounds, LoopOutcome, judge_loop
from bath_drake.systems.loop_monitor import LoopMonitor

FIELD = NavigationField(
    workspace=Workspace(np.zeros(2), np.full(2, 2.0)),
    goal=np.array([0.6, 0.0]),
    kappa=5.0,
    obstacles=ObstacleSet(),
)
BOUNDS = LoopBounds(duration=1.0, goal_tolerance=0.02, min_clearance=0.02)
FAR = np.array([-0.5, 0.1])
PORTS = {
    "canonical_position",
    "navigation_field",
    "final_stage",
    "phase",
    "nozzle_clearance",
}


class Run:
    """A monitor that is shown one unchanging situation."""

    def __init__(
        self,
        *,
        position=FAR,
        phase=Phase.WASH,
        clearance=0.06,
        final=True,
        period=0.02,
    ):
        self.monitor = LoopMonitor(bounds=BOUNDS, period=period)
        self.simulator = Simulator(self.monitor)
        self.context = self.simulator.get_mutable_context()
        for name, value in (
            ("canonical_position", position),
            ("navigation_field", FIELD),
            ("final_stage", [float(final)]),
            ("phase", [float(phase)]),
            ("nozzle_clearance", [clearance]),
        ):
            self.monitor.GetInputPort(name).FixValue(self.context, value)

    def advance(self, seconds):
        """Returns the termination's message, None if there was none."""
        status = self.simulator.AdvanceTo(seconds)
        if status.reason() == SimulatorStatus.ReturnReason.kReachedTerminationCondition:
            return status.message()
        return None

    @property
    def time(self):
        return self.context.get_time()


def test_the_ports_are_the_documented_ones():
    monitor = LoopMonitor(bounds=BOUNDS)
    ports = {
        monitor.get_input_port(k).get_name() for k in range(monitor.num_input_ports())
    }
    assert ports == PORTS
    assert monitor.num_output_ports() == 0


def test_it_ends_the_run_at_the_goal():
    run = Run(position=FIELD.goal + np.array([0.019, 0.0]))
    assert run.advance(0.5) == "GOAL_REACHED"
    # The first look is one period in.
    assert run.time == pytest.approx(0.02)


def test_it_ends_the_run_on_time_out():
    run = Run()
    assert run.advance(5.0) == "TIMED_OUT"
    assert run.time == pytest.approx(BOUNDS.duration)


@pytest.mark.parametrize("clearance", [0.019, -0.05])
@pytest.mark.parametrize("phase", Phase)
def test_it_ends_the_run_too_close_to_the_skin(clearance, phase):
    assert Run(clearance=clearance, phase=phase).advance(0.5) == "TOO_CLOSE"


def test_too_close_goes_before_the_goal():
    assert Run(clearance=0.01, position=FIELD.goal).advance(0.5) == "TOO_CLOSE"


@pytest.mark.parametrize(
    "situation",
    [
        {},
        {"position": FIELD.goal + np.array([0.021, 0.0])},
        {"position": FIELD.goal, "phase": Phase.REACH},
        {"position": FIELD.goal, "phase": Phase.DESCEND},
        {"position": FIELD.goal, "final": False},
        {"clearance": 0.021},
        # Skin that was not seen says nothing about the distance.
        {"clearance": np.inf},
    ],
)
def test_nothing_ends_the_run_before_its_time(situation):
    run = Run(**situation)
    assert run.advance(0.98) is None
    assert run.time == pytest.approx(0.98)


def test_it_judges_as_the_pure_function():
    run = Run(position=FAR, clearance=0.05)
    expected = judge_loop(
        time=0.0,
        washing=True,
        goal_distance=float(np.linalg.norm(FAR - FIELD.goal)),
        clearance=0.05,
        bounds=BOUNDS,
    )
    assert run.monitor.outcome(run.context) is expected is LoopOutcome.RUNNING


def test_no_look_is_taken_at_time_zero():
    # Before the first frame nothing is known: its inputs may even be missing.
    Simulator(LoopMonitor(bounds=BOUNDS)).Initialize()


@pytest.mark.parametrize("period", [0.0, -0.1, float("nan"), float("inf")])
def test_the_period_must_be_positive(period):
    with pytest.raises(ValueError, match="period must be positive"):
        LoopMonitor(bounds=BOUNDS, period=period)


def test_a_run_that_begins_later_takes_as_long():
    run = Run()
    run.context.SetTime(5.0)
    run.monitor.set_span(run.context, 5.0, 0.5)
    assert run.advance(9.0) == "TIMED_OUT"
    assert run.time == pytest.approx(5.5)
