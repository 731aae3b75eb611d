"""`bath-drake bench touch`: the skin that is touched against finite elements.

The sponge's hard face is pressed into a flat piece of the hydroelastic skin that the
loop uses, and into a block of linear corotational finite elements (Drake's
DeformableModel) of soft tissue as the skin's stiffness stands for: 10 kPa,
30 mm deep, held below. The one is an elastic foundation, the other a continuum: no
closer agreement than in order of size and trend is to be expected.
"""

from typing import Any

import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Ellipsoid,
    GeometryInstance,
    ProximityProperties,
)
from pydrake.math import RigidTransform
from pydrake.multibody.fem import DeformableBodyConfig
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import PdControllerGains, PrismaticJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from bath_drake.benchmarks.figures import Figure, Progress
from bath_drake.notation import FloatArray, IntArray
from bath_drake.patient.segment_motion import SegmentedSkin
from bath_drake.patient.skin_segments import STEP, skin_segment
from bath_drake.scene.bending_person import vtk_mesh
from bath_drake.scene.touched_skin import add_touched_skin
from bath_drake.systems._ports import drake_vector
from bath_drake.systems._poses import at

DEPTHS = (0.002, 0.004, 0.006)  # m
# The sponge's face, m: as in models/arm/sponge.urdf.
_FACE = (0.030, 0.030, 0.018)
# Of the block, m, its cells, and what it is made of: Pa, and kg/m^3.
_SIZE, _CELLS = (0.15, 0.15, 0.03), (13, 13, 3)
YOUNG, _POISSON, _DENSITY = 1.0e4, 0.45, 1000.0
_STEP = 0.005  # s
_LOWERING, _SETTLING = 0.02, 0.15  # m/s and s
_UP = np.array([0.0, 0.0, 1.0])


def run(progress: Progress, depths: tuple[float, ...] = DEPTHS) -> list[Figure]:
    """Presses both to each depth, rising."""
    progress("hydroelastic skin", 0.0)
    skin = [hydroelastic_force(depth) for depth in depths]
    progress("finite elements", 0.1)
    block = finite_element_forces(depths)
    progress("done", 1.0)
    figures: list[Figure] = []
    for depth, ours, theirs in zip(depths, skin, block, strict=True):
        name = f"touch_at_{1e3 * depth:.0f}_mm"
        figures += [
            Figure(f"{name}_hydroelastic", ours, "N"),
            Figure(f"{name}_finite_elements", theirs, "N"),
            Figure(f"{name}_ratio", ours / theirs, ""),
        ]
    return figures


def hydroelastic_force(depth: float) -> float:
    """Returns the force, N, on the face so deep in flat skin, m, at rest."""
    lines = STEP * np.arange(-8, 9)
    grid = np.stack([*np.meshgrid(lines, lines, indexing="ij"), np.zeros((17, 17))], -1)
    piece = skin_segment(grid, np.ones((17, 17), dtype=bool), _UP)
    builder = DiagramBuilder()
    config = MultibodyPlantConfig(time_step=_STEP, use_sampled_output_ports=False)
    plant, graph = AddMultibodyPlant(config, builder)
    skin = SegmentedSkin((piece,), None, np.zeros(1, dtype=np.int64))
    add_touched_skin(plant, graph, skin, RigidTransform())
    face = _add_face(plant)
    plant.WeldFrames(
        plant.world_frame(), face.body_frame(), at([0.0, 0.0, _FACE[2] - depth])
    )
    plant.Finalize()
    diagram = builder.Build()
    context = plant.GetMyMutableContextFromRoot(diagram.CreateDefaultContext())
    instance = plant.GetModelInstanceByName("skin")
    still = drake_vector(np.zeros(12))
    plant.get_desired_state_input_port(instance).FixValue(context, still)
    results: Any = plant.get_contact_results_output_port().Eval(context)
    return float(
        sum(
            abs(results.hydroelastic_contact_info(k).F_Ac_W().translational()[2])
            for k in range(results.num_hydroelastic_contacts())
        )
    )


def finite_element_forces(depths: tuple[float, ...]) -> list[float]:
    """Returns the force, N, on the face at each depth, m, rising, once settled."""
    builder = DiagramBuilder()
    config = MultibodyPlantConfig(time_step=_STEP, discrete_contact_approximation="sap")
    plant, _ = AddMultibodyPlant(config, builder)
    _add_block(plant)
    face = _add_face(plant)
    joint: Any = plant.AddJoint(
        PrismaticJoint(
            "down", plant.world_frame(), face.body_frame(), drake_vector(-_UP)
        )
    )
    motor = plant.AddJointActuator("motor", joint)
    motor.set_controller_gains(PdControllerGains(p=1e6, d=1e3))
    plant.Finalize()
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    told = plant.get_desired_state_input_port(joint.model_instance())
    # Along the joint, the face's lowest point is at its centre's depth plus so much.
    touching = -_FACE[2]
    joint.set_translation(context, touching)
    forces, now, there = [], 0.0, 0.0
    for depth in depths:
        for k in range(1, round((depth - there) / _LOWERING / _STEP) + 1):
            place = touching + there + k * _LOWERING * _STEP
            told.FixValue(context, drake_vector([place, _LOWERING]))
            now += _STEP
            simulator.AdvanceTo(now)
        there = depth
        told.FixValue(context, drake_vector([touching + depth, 0.0]))
        now += _SETTLING
        simulator.AdvanceTo(now)
        results: Any = plant.get_contact_results_output_port().Eval(context)
        forces.append(
            sum(
                abs(results.deformable_contact_info(k).F_Ac_W().translational()[2])
                for k in range(results.num_deformable_contacts())
            )
        )
    return [float(force) for force in forces]


def _add_face(plant: MultibodyPlant) -> Any:
    face = plant.AddRigidBody(
        "face",
        plant.AddModelInstance("tool"),
        SpatialInertia.SolidSphereWithMass(0.2, _FACE[2]),
    )
    properties = ProximityProperties()
    AddRigidHydroelasticProperties(0.006, properties)
    AddContactMaterial(
        dissipation=1.0, friction=CoulombFriction(0.3, 0.3), properties=properties
    )
    plant.RegisterCollisionGeometry(
        face, RigidTransform(), Ellipsoid(*_FACE), "face", properties
    )
    plant.set_gravity_enabled(face.model_instance(), False)
    return face


def _add_block(plant: MultibodyPlant) -> None:
    """A block of tissue, its top at z = 0, that is held below."""
    nodes, tetrahedra = kuhn_block(_SIZE, _CELLS)
    instance = GeometryInstance(
        RigidTransform(), vtk_mesh(nodes, tetrahedra, "tissue"), "tissue"
    )
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=1.0, friction=CoulombFriction(0.3, 0.3), properties=properties
    )
    instance.set_proximity_properties(properties)
    material = DeformableBodyConfig()
    material.set_youngs_modulus(YOUNG)
    material.set_poissons_ratio(_POISSON)
    material.set_mass_density(_DENSITY)
    material.set_stiffness_damping_coefficient(0.02)
    model: Any = plant.mutable_deformable_model()
    body = model.RegisterDeformableBody(instance, material, 1.0)
    model.SetWallBoundaryCondition(
        body, drake_vector([0.0, 0.0, -_SIZE[2] + 1e-4]), drake_vector(_UP)
    )


def kuhn_block(
    size: tuple[float, float, float], cells: tuple[int, int, int]
) -> tuple[FloatArray, IntArray]:
    """Returns a block in tetrahedra, six a cell (Kuhn, 1960).

    Args:
        size: Along x, y and z, m; it is centred in x and y and lies below z = 0.
        cells: Along each.

    Returns:
        Nodes (n, 3), m, and (6 cells, 4) indices, every volume positive.
    """
    counts = [k + 1 for k in cells]
    lines = [
        np.linspace(-s / 2.0, s / 2.0, k) for s, k in zip(size, counts, strict=True)
    ]
    lines[2] = lines[2] - size[2] / 2.0
    nodes = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(nodes)).reshape(counts)
    first = number[:-1, :-1, :-1].ravel()
    step = np.array([counts[1] * counts[2], counts[2], 1])
    tetrahedra = []
    for order, even in (
        ((0, 1, 2), True),
        ((1, 2, 0), True),
        ((2, 0, 1), True),
        ((0, 2, 1), False),
        ((2, 1, 0), False),
        ((1, 0, 2), False),
    ):
        # From one corner to the opposite one, along one edge after the other.
        corners = np.concatenate([[0], np.cumsum(step[list(order)])])
        if not even:
            corners = corners[[0, 2, 1, 3]]
        tetrahedra.append(first[:, None] + corners)
    return nodes, np.concatenate(tetrahedra)
