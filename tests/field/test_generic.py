"""One field for every scalar: the generic form against the compiled kernels."""

import math

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import assume, given
from pydrake.autodiffutils import AutoDiffXd, InitializeAutoDiff
from pydrake.symbolic import (
    Evaluate,
    Expression,
    Jacobian,
    MakeVectorVariable,
    Polynomial,
)

from bath_drake.field import generic, navigation
from bath_drake.field.generic import GenericField
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.parameters import pack_field

ROWS = np.array([[0.0, 0.2, 0.5, 0.3, 0.4], [-1.0, -0.8, 0.3, 0.6, 1.0]])


def make_field(kappa=5.0, power=2, goal=(1.4, 0.3), exponents=(1.0, 1.0)):
    return NavigationField(
        Workspace(np.array([0.1, 0.0]), np.array([3.0, 2.5]), power),
        np.array(goal),
        kappa,
        ObstacleSet(ROWS, np.array(exponents)),
    )


FIELDS = st.builds(
    make_field,
    kappa=st.floats(0.0, 3.0).map(lambda e: 10.0**e),
    power=st.sampled_from([2, 4, 6]),
    goal=st.tuples(st.floats(1.0, 2.0), st.floats(-1.0, 1.0)),
    exponents=st.tuples(st.floats(0.2, 3.0), st.floats(0.2, 3.0)),
)
POINTS = st.tuples(st.floats(-3.0, 3.0), st.floats(-2.6, 2.6)).map(np.array)


def well_inside(q, field):
    return navigation.min_beta(q, field) > 0.01 and np.hypot(*(q - field.goal)) > 1e-3


def gradient(value):
    """Derivatives of an AutoDiffXd; a constant may carry none."""
    return value.derivatives() if isinstance(value, AutoDiffXd) else np.zeros(2)


@given(FIELDS, POINTS)
def test_floats_give_what_the_kernels_give(field, q):
    assume(np.hypot(*(q - field.goal)) > 1e-3)
    # Where a beta is all rounding, its sign and logarithm are, too.
    assume(abs(navigation.min_beta(q, field)) > 1e-9)
    made = GenericField.of(field)
    # psi is a sum of terms up to 1e3 |ln gamma| = 1e4, beta's relative error 1e-6:
    # phi has that over kappa, and at least one rounding of ln phi <= 14.
    near = 1e-6 if navigation.min_beta(q, field) < 1e-3 else 1e-12
    np.testing.assert_allclose(
        generic.ln_phi(q, made), navigation.ln_phi(q, field), rtol=1e-9, atol=near
    )
    np.testing.assert_allclose(
        generic.phi(q, made), navigation.phi(q, field), rtol=near
    )
    if not well_inside(q, field):
        return
    assert min(generic.betas(q, made)) == pytest.approx(
        float(navigation.min_beta(q, field)), rel=1e-9, abs=1e-12
    )
    # Where the terms of the flow cancel, their rounding turns it.
    slope = navigation.grad_psi(q, field)
    assume(np.hypot(*slope) > 1e-4 * field.kappa)
    np.testing.assert_allclose(
        generic.flow_direction(q, made), navigation.flow_direction(q, field), atol=1e-8
    )
    np.testing.assert_allclose(
        np.cross([*generic.flow(q, made), 0.0], [*slope, 0.0])[2],
        0.0,
        atol=1e-8 * np.hypot(*generic.flow(q, made)) * np.hypot(*slope),
    )


@given(FIELDS, POINTS)
def test_the_plain_formula_of_the_paper_is_the_same_function(field, q):
    assume(field.kappa < 150.0)  # gamma^kappa overflows later
    assume(well_inside(q, field))
    made = GenericField.of(field)
    # kappa roundings of gamma, under a root that undoes them.
    phi = generic.phi(q, made, plain=True)
    assert phi == pytest.approx(float(navigation.phi(q, field)), rel=1e-12)
    assert generic.ln_phi(q, made, plain=True) == pytest.approx(math.log(phi))
    psi = generic.psi(q, made, plain=True)
    assert psi == pytest.approx(generic.psi(q, made), rel=1e-12, abs=1e-12)
    np.testing.assert_allclose(
        generic.flow_direction(q, made, plain=True),
        generic.flow_direction(q, made),
        atol=1e-15,
    )


@given(FIELDS, POINTS)
def test_automatic_derivatives_are_the_kernels_gradients(field, q):
    assume(well_inside(q, field))
    made = GenericField.of(field)
    x = InitializeAutoDiff(q).ravel()
    scale = np.hypot(*navigation.grad_psi(q, field))
    # Rounding of psi's terms, as its own scale, which reaches 2 kappa / 1e-3.
    np.testing.assert_allclose(
        gradient(generic.psi(x, made)),
        navigation.grad_psi(q, field),
        rtol=1e-9,
        atol=1e-12 * (scale + field.kappa / np.hypot(*(q - field.goal))),
    )
    slope = navigation.grad_phi(q, field)
    # Relative even where phi is 1 to rounding. kappa ln gamma and ln beta, 1e4 at
    # most and 1e-16 off, go through an exponential: 1e-12, and the sum may cancel.
    np.testing.assert_allclose(
        gradient(generic.phi(x, made)),
        slope,
        rtol=1e-7,
        atol=1e-7 * np.hypot(*slope) + 1e-300,
    )
    np.testing.assert_allclose(
        gradient(generic.ln_phi(x, made)) * navigation.phi(q, field),
        slope,
        rtol=1e-7,
        atol=1e-7 * np.hypot(*slope) + 1e-300,
    )


@pytest.mark.parametrize("kappa", [1.5, 8.0, 400.0])
def test_everything_is_finite_and_regular_at_the_goal(kappa):
    field = GenericField.of(make_field(kappa=kappa))
    q = InitializeAutoDiff([1.4, 0.3]).ravel()
    height = generic.phi(q, field)
    assert height.value() == 0.0
    np.testing.assert_array_equal(gradient(height), [0.0, 0.0])
    for value in (generic.psi(q, field), generic.ln_phi(q, field)):
        assert value.value() < -600.0
        assert np.isfinite(gradient(value)).all()  # what is left: ln beta's
    assert generic.flow_direction(q, field) == (0.0, 0.0)
    x, y = generic.flow(q, field)
    assert (x.value(), y.value()) == (0.0, 0.0)
    # There the flow is -2 kappa (prod beta) (q - q_d), to first order.
    pull = 2.0 * kappa * np.prod(generic.betas([1.4, 0.3], field))
    np.testing.assert_allclose(gradient(x), [-pull, 0.0], rtol=1e-12)


@pytest.mark.parametrize("q", [(0.0, 0.2), (3.2, 0.0), (9.0, -9.0), (1e300, -1e300)])
def test_outside_free_space_it_is_defined_as_in_the_kernels(q):
    field = GenericField.of(make_field())
    x = InitializeAutoDiff(np.array(q)).ravel()
    for point in (q, x):
        assert generic.phi(point, field) == 1.0
        assert generic.ln_phi(point, field) == 0.0
        assert generic.psi(point, field) == math.inf
        assert generic.flow_direction(point, field) == (0.0, 0.0)


def test_on_a_boundary_the_flow_is_the_inward_normal():
    # Representable numbers, so that beta is exactly zero at (1, 0).
    field = GenericField.of(
        NavigationField(
            Workspace(np.zeros(2), np.array([4.0, 4.0])),
            np.array([-2.0, 1.0]),
            7.5,
            ObstacleSet(np.array([[0.0, 0.0, 1.0, 0.5, 0.0]])),
        )
    )
    np.testing.assert_array_equal(generic.flow_direction([1.0, 0.0], field), [1, 0])
    np.testing.assert_array_equal(generic.flow_direction([4.0, 0.0], field), [-1, 0])
    assert generic.phi([1.0, 0.0], field) == 1.0


def test_many_small_obstacles_neither_overflow_nor_underflow(rng):
    # 32 is the room of a Diagram's field; beta reaches 1e4 for each.
    centres = rng.uniform(-0.9, 0.9, (32, 2))
    theta = np.column_stack([centres, np.full((32, 2), 0.02), np.zeros(32)])
    field = NavigationField(
        Workspace(np.zeros(2), np.ones(2) * 2.0), np.zeros(2), 40.0, ObstacleSet(theta)
    )
    made = GenericField.of(field)
    for q in rng.uniform(-1.2, 1.2, (50, 2)):
        if navigation.min_beta(q, field) > 0.1:
            np.testing.assert_allclose(
                generic.flow_direction(q, made),
                navigation.flow_direction(q, field),
                atol=1e-12,  # roundings of 33 terms
            )


def test_symbolic_formulas_evaluate_to_the_numbers():
    q = MakeVectorVariable(2, "q")
    x = [Expression(v) for v in q]
    rng = np.random.default_rng(7)
    for power in (2, 4):
        field = make_field(power=power, exponents=(0.7, 2.0))
        made = GenericField.of(field)
        phi, psi = generic.phi(x, made, plain=True), generic.psi(x, made, plain=True)
        slope = Jacobian([phi], q)
        curve = Jacobian(Jacobian([psi], q)[0], q)
        direction = generic.flow_direction(x, made, plain=True)
        for point in rng.uniform(-2.0, 2.0, (20, 2)):
            if not well_inside(point, field):
                continue
            at = dict(zip(q, point, strict=True))
            # The same formula, another order of operations.
            assert phi.Evaluate(at) == pytest.approx(
                float(navigation.phi(point, field)), rel=1e-12
            )
            assert psi.Evaluate(at) == pytest.approx(generic.psi(point, made), rel=1e-9)
            np.testing.assert_allclose(
                Evaluate(slope, at)[0],
                navigation.grad_phi(point, field),
                rtol=1e-8,
                atol=1e-15,
            )
            np.testing.assert_allclose(
                Evaluate(curve, at), navigation.hessian_psi(point, field), rtol=1e-8
            )
            np.testing.assert_allclose(
                [v.Evaluate(at) for v in direction],
                navigation.flow_direction(point, field),
                atol=1e-10,
            )


def test_the_symbolic_hessian_of_phi_agrees_with_differences_of_its_gradient():
    field = make_field()
    made = GenericField.of(field)
    q = MakeVectorVariable(2, "q")
    phi = generic.phi([Expression(v) for v in q], made, plain=True)
    hessian = Jacobian(Jacobian([phi], q)[0], q)
    h = 1e-5
    for point in ([-1.6, 0.7], [0.9, -0.4], [1.5, 0.2]):
        found = Evaluate(hessian, dict(zip(q, point, strict=True)))
        columns = [
            navigation.grad_phi(point + e, field)
            - navigation.grad_phi(point - e, field)
            for e in h * np.eye(2)
        ]
        # h^2 / 6 times third derivatives of order 100.
        np.testing.assert_allclose(found, np.array(columns) / (2 * h), atol=1e-7)
    # At the goal it is 2 beta^(-1/kappa) I.
    at_goal = Evaluate(hessian, dict(zip(q, field.goal, strict=True)))
    beta = np.prod(generic.betas(field.goal, made))
    np.testing.assert_allclose(at_goal, 2.0 * beta**-0.2 * np.eye(2), rtol=1e-12)


@pytest.mark.parametrize(("power", "degree"), [(2, 7), (4, 9)])
def test_the_flow_is_a_polynomial(power, degree):
    q = MakeVectorVariable(2, "q")
    field = GenericField.of(make_field(power=power, exponents=(0.7, 2.0)))
    for part in generic.flow([Expression(v) for v in q], field):
        assert Polynomial(part, q).TotalDegree() == degree


def test_derivatives_with_respect_to_the_fields_numbers_agree_with_differences():
    q = [-1.6, 0.7]
    vector = pack_field(make_field(exponents=(0.7, 2.0)), 2)
    made = GenericField.from_vector(
        InitializeAutoDiff(vector).ravel(), lambda x: x.value()
    )
    found = gradient(generic.phi(q, made))
    assert found.shape == vector.shape
    h = 1e-6
    for k in range(len(vector)):
        if k in (4, 8):  # whole numbers: the power, the count
            assert found[k] == 0.0
            continue
        step = h * np.eye(len(vector))[k]
        up, down = (
            generic.phi(q, GenericField.from_vector(vector + s)) for s in (step, -step)
        )
        # 1e-16 / h of rounding, h^2 times third derivatives.
        assert found[k] == pytest.approx((up - down) / (2 * h), abs=1e-9)


@pytest.mark.parametrize(
    ("index", "value", "message"), [(8, 3.0, "count"), (4, 2.5, "power")]
)
def test_impossible_vectors_are_refused(index, value, message):
    vector = pack_field(make_field(), 2)
    vector[index] = value
    with pytest.raises(ValueError, match=message):
        GenericField.from_vector(vector)
