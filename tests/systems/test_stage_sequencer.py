import numpy as np
import pytest
from made_up_skill import crossing_chain
from pydrake.systems.analysis import Simulator

from bath_drake.composition.chain import Chain
from bath_drake.control.staging import around_areas
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.systems.stage_sequencer import StageSequencer

CHAIN = crossing_chain()
START = np.array([-0.7, -0.3])
IN_GATE = [gate.centre + 0.01 * gate.direction for gate in CHAIN.gates]


class Run:
    """A sequencer that is shown one point after the other."""

    def __init__(self, chain=CHAIN, areas=None):
        self.dut = StageSequencer(period=0.01)
        self.simulator = Simulator(self.dut)
        self.context = self.simulator.get_mutable_context()
        self.dut.GetInputPort("navigation_chain").FixValue(self.context, chain)
        if areas is not None:
            self.dut.GetInputPort("sensed_obstacles").FixValue(self.context, areas)
        self.show(START)

    def show(self, point):
        self.dut.GetInputPort("canonical_reference").FixValue(self.context, point)

    def advance(self):
        self.simulator.AdvanceTo(self.context.get_time() + 0.01)
        return int(self.out("stage")[0])

    def out(self, port):
        return self.dut.GetOutputPort(port).Eval(self.context)


def test_it_begins_with_the_first_field():
    run = Run()
    assert run.out("navigation_field") == CHAIN.fields[0]
    assert run.out("remaining_chain") == CHAIN
    assert run.out("final_stage")[0] == 0.0
    assert run.advance() == 0


def test_it_steps_on_in_the_gates_and_never_back():
    run = Run()
    for stage, point in ((1, IN_GATE[0]), (1, START), (2, IN_GATE[1]), (2, START)):
        run.show(point)
        assert run.advance() == stage
        assert run.out("navigation_field") == CHAIN.fields[stage]
        assert run.out("remaining_chain") == CHAIN.rest(stage)
        assert run.out("final_stage")[0] == float(stage == 2)


def test_another_stages_gate_does_not_count():
    run = Run()
    run.show(IN_GATE[1])
    assert run.advance() == 0


def test_a_single_field_is_the_final_stage_from_the_start():
    run = Run(Chain(CHAIN.fields[:1]))
    assert run.out("final_stage")[0] == 1.0
    run.show(CHAIN.fields[0].goal)
    assert run.advance() == 0


def test_covered_goals_are_moved_as_by_the_pure_function():
    areas = ObstacleSet(np.array([[*CHAIN.fields[0].goal, 0.1, 0.1, 0.0]]))
    run = Run(areas=areas)
    moved = around_areas(CHAIN, areas)
    assert run.out("remaining_chain") == moved
    assert run.out("navigation_field").goal.tolist() == moved.fields[0].goal.tolist()
    run.show(moved.fields[0].goal)
    assert run.advance() == 1


def test_a_stage_without_a_free_goal_is_left_out():
    # All the body's right half: the first goal is deep in it.
    run = Run(areas=ObstacleSet(np.array([[1.2, 0.0, 1.1, 2.0, 0.0]])))
    assert run.advance() == 1


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan"), float("inf")])
def test_its_period_must_be_positive(period):
    with pytest.raises(ValueError, match="period must be positive"):
        StageSequencer(period=period)
