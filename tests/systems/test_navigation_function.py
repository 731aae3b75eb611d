"""The navigation function as a system: ports, parameters and scalar conversion."""

import numpy as np
import pytest
from pydrake.autodiffutils import (
    AutoDiffXd,
    ExtractGradient,
    ExtractValue,
    InitializeAutoDiff,
)
from pydrake.planning import DirectCollocation
from pydrake.solvers import MathematicalProgram, Solve
from pydrake.symbolic import (
    Expression,
    Jacobian,
    MakeVectorVariable,
    Polynomial,
    Variables,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, InputPortSelection
from pydrake.systems.primitives import Integrator

from bath_drake.composition.chain import Chain
from bath_drake.field import generic
from bath_drake.field.generic import GenericField
from bath_drake.field.navigation import (
    NavigationField,
    flow_direction,
    grad_phi,
    phi,
)
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.parameters import pack_field
from bath_drake.field.rollout import rollout
from bath_drake.systems.navigation_function import (
    NavigationFunction,
    NavigationFunction_,
)
from bath_drake.systems.virtual_obstacle_source import VirtualObstacleSource

FIELD = NavigationField(
    Workspace(np.zeros(2), np.full(2, 2.0)),
    np.array([0.6, 0.0]),
    5.0,
    ObstacleSet(np.array([[0.0, 0.1, 0.2, 0.1, 0.3], [0.1, -0.6, 0.2, 0.2, 0.0]])),
)
OTHER = NavigationField(
    Workspace(np.zeros(2), np.full(2, 1.5), 4),
    np.array([0.5, 0.4]),
    9.0,
    ObstacleSet(np.array([[0.0, 0.0, 0.3, 0.1, 1.0]])),
)
P_NQ = np.array([-0.8, 0.15])
PORTS = ("phi", "ln_phi", "flow_direction", "flow", "beta")


@pytest.fixture
def dut():
    return NavigationFunction(field=FIELD, max_obstacles=4)


def fixed(system, value):
    context = system.CreateDefaultContext()
    system.GetInputPort("canonical_position").FixValue(context, value)
    return context


def outputs(system, context):
    return {name: system.GetOutputPort(name).Eval(context) for name in PORTS}


def test_every_port_gives_the_pure_function(dut):
    made = GenericField.of(FIELD)
    found = outputs(dut, fixed(dut, P_NQ))
    assert found["phi"] == [generic.phi(P_NQ, made)]
    assert found["ln_phi"] == [generic.ln_phi(P_NQ, made)]
    np.testing.assert_array_equal(found["flow"], generic.flow(P_NQ, made))
    direction = generic.flow_direction(P_NQ, made)
    np.testing.assert_array_equal(found["flow_direction"], direction)
    betas = generic.betas(P_NQ, made)
    np.testing.assert_array_equal(found["beta"], [*betas, 1.0, 1.0])


def test_the_parameter_is_a_part_of_the_virtual_obstacle_sources(dut):
    source = VirtualObstacleSource(chain=Chain((OTHER,)), max_stages=1, max_obstacles=4)
    there = source.CreateDefaultContext().get_numeric_parameter(0)
    context = fixed(dut, P_NQ)
    before = outputs(dut, context)["phi"]
    theta = context.get_mutable_numeric_parameter(0)
    theta.SetFromVector(there.CopyToVector()[1:-5])
    np.testing.assert_allclose(outputs(dut, context)["phi"], phi(P_NQ, OTHER))
    dut.set_field(context, FIELD)
    assert outputs(dut, context)["phi"] == before


def test_a_field_that_does_not_fit_is_refused(dut):
    with pytest.raises(ValueError, match="at most 1 fit"):
        NavigationFunction(field=FIELD, max_obstacles=1)
    small = NavigationFunction(field=OTHER)
    with pytest.raises(ValueError, match="at most 1 fit"):
        small.set_field(small.CreateDefaultContext(), FIELD)


def test_autodiff_gives_the_gradient(dut):
    system = dut.ToAutoDiffXd()
    found = outputs(system, fixed(system, InitializeAutoDiff(P_NQ)))
    numbers = outputs(dut, fixed(dut, P_NQ))
    for name in PORTS:
        # The same operations on the same numbers.
        np.testing.assert_allclose(
            ExtractValue(found[name]).ravel(), numbers[name], rtol=1e-14
        )
    np.testing.assert_allclose(
        ExtractGradient(found["phi"])[0], grad_phi(P_NQ, FIELD), rtol=1e-12
    )


@pytest.mark.parametrize("q", [(0.0, 0.1), (0.6, 0.0), (3.0, 3.0)])
def test_constants_outside_free_space_carry_derivatives_too(dut, q):
    # An AutoDiffXd without derivatives among others crashes compiled solvers.
    system = dut.ToAutoDiffXd()
    found = outputs(system, fixed(system, InitializeAutoDiff(q)))
    for name in PORTS:
        assert all(x.derivatives().shape == (2,) for x in found[name])


def test_autodiff_parameters_give_the_sensitivity_to_the_obstacles(dut):
    system = dut.ToAutoDiffXd()
    context = fixed(system, P_NQ.astype(AutoDiffXd))
    vector = pack_field(FIELD, 4)
    theta = context.get_mutable_numeric_parameter(0)
    theta.SetFromVector(InitializeAutoDiff(vector).ravel())
    found = ExtractGradient(outputs(system, context)["flow_direction"])
    assert found.shape == (2, vector.size)
    h = 1e-6
    for k in (5, 7, 9, 13, 16):  # goal, kappa, a centre, an angle, the other's y
        step = h * np.eye(vector.size)[k]
        up, down = (
            generic.flow_direction(P_NQ, GenericField.from_vector(vector + s))
            for s in (step, -step)
        )
        difference = (np.array(up) - np.array(down)) / (2 * h)
        # 1e-16 / h of rounding, h^2 times third derivatives.
        np.testing.assert_allclose(found[:, k], difference, atol=1e-8)
    np.testing.assert_array_equal(found[:, 9 + 12 :], 0.0)  # no obstacle there


def test_symbolic_outputs_are_formulas_of_the_position(dut):
    system = dut.ToSymbolic()
    q = MakeVectorVariable(2, "q")
    found = outputs(system, fixed(system, [Expression(v) for v in q]))
    numbers = outputs(dut, fixed(dut, P_NQ))
    at = dict(zip(q, P_NQ, strict=True))
    for name in PORTS:
        np.testing.assert_allclose(
            [e.Evaluate(at) for e in found[name]],
            numbers[name],
            rtol=1e-12,  # kappa roundings of gamma in Eq. 1 as it stands
        )
    slope = [e.Evaluate(at) for e in Jacobian(found["phi"], q)[0]]
    np.testing.assert_allclose(slope, grad_phi(P_NQ, FIELD), rtol=1e-11)


def test_an_obstacle_may_be_symbolic_but_not_the_number_of_them(dut):
    system = dut.ToSymbolic()
    context = fixed(system, [Expression(x) for x in P_NQ])
    x = MakeVectorVariable(1, "x")[0]
    vector = [Expression(v) for v in pack_field(FIELD, 4)]
    vector[9] = Expression(x)
    context.get_mutable_numeric_parameter(0).SetFromVector(vector)
    height = outputs(system, context)["phi"][0]
    assert height.Evaluate({x: 0.0}) == pytest.approx(float(phi(P_NQ, FIELD)))
    vector[8] = Expression(x)
    context.get_mutable_numeric_parameter(0).SetFromVector(vector)
    with pytest.raises(RuntimeError):
        outputs(system, context)


def test_scalar_conversion_there_and_back_changes_nothing(dut):
    there = dut.ToAutoDiffXd()
    assert isinstance(there, NavigationFunction_[AutoDiffXd])
    back = there.ToScalarType[float]()
    assert isinstance(back, NavigationFunction)
    symbolic = there.ToSymbolic()
    assert isinstance(symbolic, NavigationFunction_[Expression])
    once = outputs(dut, fixed(dut, P_NQ))
    again = outputs(back, fixed(back, P_NQ))
    for name in PORTS:
        np.testing.assert_array_equal(again[name], once[name])
    # A field set later travels with the Context.
    context = fixed(dut, P_NQ)
    dut.set_field(context, OTHER)
    other = there.CreateDefaultContext()
    other.SetTimeStateAndParametersFrom(context)
    there.GetInputPort("canonical_position").FixValue(other, P_NQ.astype(AutoDiffXd))
    height = outputs(there, other)["phi"][0]
    assert height.value() == pytest.approx(float(phi(P_NQ, OTHER)), rel=1e-14)


@pytest.fixture
def loop(dut):
    builder = DiagramBuilder()
    builder.AddNamedSystem("navigation_function", dut)
    state = builder.AddNamedSystem("canonical_point", Integrator(2))
    builder.Connect(dut.GetOutputPort("flow_direction"), state.get_input_port())
    builder.Connect(state.get_output_port(), dut.GetInputPort("canonical_position"))
    return builder.Build()


def test_with_an_integrator_it_drives_the_roll_out(loop):
    path = rollout(P_NQ, FIELD, step=1e-3).path
    simulator = Simulator(loop)
    simulator.get_mutable_integrator().set_target_accuracy(1e-6)
    context = simulator.get_mutable_context()
    context.SetContinuousState(P_NQ)
    for arc in (0.3, 0.7, 1.2):  # unit speed: time is arc length
        simulator.AdvanceTo(arc)
        # Midpoint steps of 1e-3 and the integrator's accuracy.
        np.testing.assert_allclose(
            context.get_continuous_state_vector().CopyToVector(),
            path[round(arc / 1e-3)],
            atol=1e-5,
        )


def test_a_diagram_with_it_converts_to_autodiff(loop):
    system = loop.ToAutoDiffXd()
    context = system.CreateDefaultContext()
    context.SetContinuousState(InitializeAutoDiff(P_NQ).ravel())
    rates = system.EvalTimeDerivatives(context).CopyToVector()
    np.testing.assert_allclose(
        ExtractValue(rates).ravel(), flow_direction(P_NQ, FIELD), rtol=1e-12
    )
    h = 1e-6
    columns = [
        (flow_direction(P_NQ + e, FIELD) - flow_direction(P_NQ - e, FIELD)) / (2 * h)
        for e in h * np.eye(2)
    ]
    # 1e-16 / h of rounding, h^2 times third derivatives.
    np.testing.assert_allclose(ExtractGradient(rates), np.transpose(columns), atol=1e-7)
    assert loop.ToSymbolic() is not None


def test_in_symbols_phi_falls_along_its_own_flow(dut, rng):
    system = dut.ToSymbolic()
    q = MakeVectorVariable(2, "q")
    found = outputs(system, fixed(system, [Expression(v) for v in q]))
    slope = Jacobian(found["phi"], q)[0]
    rate = slope[0] * found["flow"][0] + slope[1] * found["flow"][1]
    for point in rng.uniform(-1.3, 1.3, (50, 2)):
        at = dict(zip(q, point, strict=True))
        if min(e.Evaluate(at) for e in found["beta"]) > 0.0:
            assert rate.Evaluate(at) < 0.0


def test_direct_collocation_finds_the_roll_out(loop):
    count, arc = 21, 1.2
    program = DirectCollocation(
        loop,
        loop.CreateDefaultContext(),
        count,
        arc / (count - 1),
        arc / (count - 1),
        input_port_index=InputPortSelection.kNoInput,
    )
    path = rollout(P_NQ, FIELD, step=1e-3).path[:: round(1e3 * arc) // (count - 1)]
    program.prog().AddBoundingBoxConstraint(P_NQ, P_NQ, program.initial_state())
    for k in range(count):  # straight through an obstacle
        guess = P_NQ + (path[count - 1] - P_NQ) * k / (count - 1)
        program.prog().SetInitialGuess(program.state(k), guess)
    result = Solve(program.prog())
    assert result.is_success()
    found = [result.GetSolution(program.state(k)) for k in range(count)]
    # Cubic pieces of 0.06: the fourth power of it, times derivatives of order 100.
    np.testing.assert_allclose(found, path[:count], atol=1e-3)


@pytest.mark.parametrize(("radius", "proved"), [(0.3, True), (0.7, False)])
def test_sums_of_squares_prove_a_neighbourhood_of_the_goal(dut, radius, proved):
    program = MathematicalProgram()
    d = program.NewIndeterminates(2, "d")
    system = dut.ToSymbolic()
    q = [x + v for x, v in zip(FIELD.goal.tolist(), d, strict=True)]
    context = fixed(system, q)
    flow = [e.Expand() for e in outputs(system, context)["flow"]]
    # Within the radius d(|d|^2)/dt < 0; 0.7 reaches behind an obstacle.
    rate = Polynomial(2.0 * (d[0] * flow[0] + d[1] * flow[1]), d)
    square = Polynomial(d[0] ** 2 + d[1] ** 2, d)
    multiplier, _ = program.NewSosPolynomial(Variables(d), 6)
    program.AddSosConstraint(
        -0.01 * rate - multiplier * (radius**2 - square) - 1e-3 * square
    )
    assert Solve(program).is_success() == proved
