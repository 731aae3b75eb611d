"""The true wrench on a tool, and how the force sensor measures it."""

import numpy as np
import pytest
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    GeometryId,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    ContactResults,
    CoulombFriction,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from bath_drake.systems.contact_wrench import ContactWrench
from bath_drake.systems.force_sensor import ForceSensor

MASS, RADIUS, G = 0.4, 0.03, 9.81
# E above and beside the ball's centre, its z axis along x of W.
X_WE = RigidTransform(RotationMatrix.MakeYRotation(np.pi / 2), [0.1, 0.0, 0.05])


def material(add, *numbers):
    properties = ProximityProperties()
    add(*numbers, properties)
    AddContactMaterial(
        dissipation=5.0, friction=CoulombFriction(0.3, 0.3), properties=properties
    )
    return properties


@pytest.fixture(scope="module")
def lying_ball():
    """A ball that lies on a soft block: its wrench in E."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlant(MultibodyPlantConfig(time_step=0.005), builder)
    body = plant.AddRigidBody("ball", SpatialInertia.SolidSphereWithMass(MASS, RADIUS))
    ball = plant.RegisterCollisionGeometry(
        body,
        RigidTransform(),
        Sphere(RADIUS),
        "ball",
        material(AddRigidHydroelasticProperties, 0.01),
    )
    plant.RegisterCollisionGeometry(
        plant.world_body(),
        RigidTransform([0.0, 0.0, -0.1]),
        Box(0.4, 0.4, 0.2),
        "block",
        material(AddCompliantHydroelasticProperties, 0.05, 1e5),
    )
    plant.Finalize()
    plant.SetDefaultFloatingBaseBodyPose(body, RigidTransform([0.0, 0.0, RADIUS]))
    felt = builder.AddSystem(ContactWrench(tool=frozenset([ball])))
    builder.Connect(
        plant.get_contact_results_output_port(), felt.GetInputPort("contact_results")
    )
    simulator = Simulator(builder.Build())
    context = felt.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    felt.GetInputPort("nozzle_pose").FixValue(context, X_WE)
    simulator.AdvanceTo(1.0)
    return felt.GetOutputPort("contact_wrench").Eval(context)


def test_a_ball_that_lies_still_is_carried(lying_ball):
    force_W = X_WE.rotation().matrix() @ lying_ball[3:]
    # A percent: after a second it still sinks a little.
    np.testing.assert_allclose(force_W, [0.0, 0.0, MASS * G], atol=0.01 * MASS * G)


def test_the_torque_is_about_the_origin_of_e(lying_ball):
    torque_W = X_WE.rotation().matrix() @ lying_ball[:3]
    arm = np.array([0.0, 0.0, 0.0]) - X_WE.translation()
    # Up and down the line of the force, its place does not matter.
    expected = np.cross(arm, [0.0, 0.0, MASS * G])
    np.testing.assert_allclose(torque_W, expected, atol=0.01 * np.abs(expected).max())


def test_without_contact_there_is_no_force():
    system = ContactWrench(tool=frozenset([GeometryId.get_new_id()]))
    context = system.CreateDefaultContext()
    system.GetInputPort("contact_results").FixValue(context, ContactResults())
    system.GetInputPort("nozzle_pose").FixValue(context, X_WE)
    felt = system.GetOutputPort("contact_wrench").Eval(context)
    np.testing.assert_array_equal(felt, np.zeros(6))
    with pytest.raises(ValueError, match="at least one geometry"):
        ContactWrench(tool=frozenset())


def measured(wrench, **choices):
    sensor = ForceSensor(seed=4, **choices)
    simulator = Simulator(sensor)
    context = simulator.get_mutable_context()
    if wrench is not None:
        sensor.GetInputPort("contact_wrench").FixValue(context, wrench)
    found = []
    for k in range(1, 200):
        simulator.AdvanceTo(0.005 * k + 0.001)
        found.append(sensor.GetOutputPort("wrench").Eval(context)[1:].copy())
    return np.array(found)


def test_the_sensor_measures_the_wrench_with_its_bias_and_noise():
    wrench = np.array([0.1, -0.2, 0.05, 1.0, 0.5, -4.0])
    found = measured(wrench, force_bias=0.1)
    without = measured(None, force_bias=0.1)
    np.testing.assert_allclose(found - without, np.tile(wrench, (199, 1)), atol=1e-12)
    bias = without.mean(axis=0)
    # The mean of 199 is within four standard deviations of it.
    assert np.abs(bias[:3]).max() < 4 * 0.005 / np.sqrt(199)
    assert 4 * 0.05 / np.sqrt(199) < np.abs(bias[3:]).max() < 0.4
    assert without[:, 3:].std(axis=0) == pytest.approx(0.05, rel=0.2)


def test_a_bias_that_is_none_is_refused():
    with pytest.raises(ValueError, match="force_bias must be"):
        ForceSensor(seed=0, force_bias=-0.1)
