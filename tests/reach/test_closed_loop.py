"""What is foretold of a path is what the closed loop then comes to."""

import numpy as np
import pytest

from bath_drake.control.approach import Phase
from bath_drake.diagrams import build_reproduction
from bath_drake.reach.judge import Cause
from bath_drake.reach.kinematics import condition_number
from bath_drake.reach.precheck import not_reached, reachability
from bath_drake.scenario import find_skill, load_scenario
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.simulation import run
from bath_drake.skill_file import load_skill
from bath_drake.verification import evaluate


@pytest.mark.slow
@pytest.mark.parametrize(
    "person", [pytest.param("m_heavy", marks=pytest.mark.exhaustive), "f_thin"]
)
def test_the_loops_condition_numbers_along_the_path_are_those_foretold(person):
    scenario = load_scenario("reproduction")
    scenario.scene.person = person
    scenario.perception.source = "ideal"
    scenario.scene.arm.fidelity = "kinematic"
    motion = scenario.scene.motion
    motion.twist_amplitude = motion.lean_amplitude = motion.breath_amplitude = 0.0
    skill = load_skill(find_skill(scenario.skill))
    found = reachability(scenario, skill, back=False)
    assert found.path.reached
    log = run(build_reproduction(scenario, skill), scenario)
    assert log.outcome == "GOAL_REACHED"
    washing = log.phase == Phase.WASH
    chain = arm_chain(scenario.scene.arm)
    emitted = log.checked_command[washing][:, :7]
    loop = np.array([condition_number(q, chain) for q in emitted])
    reference = log.canonical_reference[washing]
    apart = np.linalg.norm(reference[:, None] - found.rest.p_N[None], axis=2)
    nearest = apart.argmin(axis=1)
    # The first place stands for the way there as well.
    loop, nearest = loop[nearest > 0], nearest[nearest > 0]
    foretold = found.rest.condition[nearest]
    ratio = loop / foretold
    # The loop slows down at the goal, where its null space is drawn on; between the
    # path's points, 0.02 apart, the condition number changes as well.
    assert abs(ratio - 1.0).mean() < 0.03
    assert abs(ratio - 1.0).max() < 0.2
    assert loop.max() == pytest.approx(foretold.max(), rel=0.1)


@pytest.mark.slow
@pytest.mark.exhaustive
@pytest.mark.parametrize("person", ["f_avg", "f_thin"])
def test_the_loop_is_held_where_it_is_foretold_that_a_link_comes_too_near(person):
    scenario = load_scenario("other_arm")
    scenario.scene.person = person
    scenario.perception.source = "ideal"
    scenario.scene.arm.fidelity = "kinematic"
    # Drawn to this the wrist comes to the person's shoulder.
    scenario.scene.arm.posture = [1.645, -1.420, -1.351, -1.303, -2.247, -1.322, 0.304]
    skill = load_skill(find_skill(scenario.skill))
    found = reachability(scenario, skill, back=False, search=False)
    causes = {part["cause"] for part in not_reached(found.rest)}
    assert causes == {Cause.LINK_NEAR.words}
    log = run(build_reproduction(scenario, skill), scenario)
    assert log.outcome == "TIMED_OUT"
    held = evaluate(log, scenario, skill).metrics["guard_s"]
    assert held["link_near"] > 5.0
