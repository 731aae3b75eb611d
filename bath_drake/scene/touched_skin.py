"""The skin that can be touched, in the arm's plant: compliant slabs on joints."""

import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    CollisionFilterDeclaration,
    GeometrySet,
    ProximityProperties,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    ModelInstanceIndex,
    PdControllerGains,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    SpatialInertia,
)

from bath_drake.patient.segment_motion import SegmentedSkin
from bath_drake.patient.skin_segments import DEPTH
from bath_drake.scene.bending_person import vtk_mesh
from bath_drake.systems._ports import drake_vector
from bath_drake.systems._poses import at

# Pa per metre that the skin is pressed in, as an elastic foundation: to the sponge
# about what 30 mm of tissue of 10 kPa are (`bath-drake bench touch`). An assumption of
# ours, not a measurement.
STIFFNESS = 1.0e6
_DISSIPATION = 1.0  # s/m, after Hunt and Crossley
_FRICTION = 0.3  # wet and soapy
# So stiff that the person does not notice the sponge: N/m and N s/m, N m/rad and
# N m s/rad. Both are implicit in Drake's solver.
_SLIDE = PdControllerGains(p=1e7, d=1e4)
_TURN = PdControllerGains(p=1e5, d=1e2)
_MASS, _SIZE = 2.0, 0.15  # kg and m, of a slab: any will do
_AXES = np.eye(3)


def add_touched_skin(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    skin: SegmentedSkin,
    X_WM: RigidTransform,
) -> ModelInstanceIndex:
    """Adds the slabs as instance `skin`; its desired state is to be fed.

    Args:
        plant: Not yet finalised, in a SceneGraph.
        scene_graph: That one.
        skin: The slabs.
        X_WM: The person's pose that their joints are measured from.
    """
    instance = plant.AddModelInstance("skin")
    geometries = GeometrySet()
    for k, segment in enumerate(skin.segments):
        body = _hang(plant, instance, f"skin{k + 1}", X_WM @ at(segment.centre))
        geometry = plant.RegisterCollisionGeometry(
            body,
            RigidTransform(),
            vtk_mesh(segment.nodes, segment.tetrahedra, f"skin{k + 1}"),
            f"skin{k + 1}",
            _properties(),
        )
        geometries.Add(geometry)
    # They overlap on purpose.
    scene_graph.collision_filter_manager().Apply(
        CollisionFilterDeclaration().ExcludeWithin(geometries)
    )
    plant.set_gravity_enabled(instance, False)
    return instance


def _properties() -> ProximityProperties:
    properties = ProximityProperties()
    # A mesh has no hint; its pressure grows from nothing on the skin to the modulus
    # at its greatest depth.
    AddCompliantHydroelasticProperties(1.0, STIFFNESS * DEPTH, properties)
    AddContactMaterial(
        dissipation=_DISSIPATION,
        friction=CoulombFriction(_FRICTION, _FRICTION),
        properties=properties,
    )
    return properties


def _hang(
    plant: MultibodyPlant, instance: ModelInstanceIndex, name: str, X_WB: RigidTransform
) -> RigidBody:
    """A body that three joints slide and three turn, with an actuator each."""
    frame = plant.AddFrame(FixedOffsetFrame(f"{name}_base", plant.world_frame(), X_WB))
    for k, axis in enumerate([*_AXES, *_AXES[::-1]]):
        last = k == 5
        inertia = (
            SpatialInertia.SolidBoxWithMass(_MASS, _SIZE, _SIZE, _SIZE)
            if last
            else SpatialInertia.Zero()
        )
        body = plant.AddRigidBody(name if last else f"{name}_{k}", instance, inertia)
        kind = PrismaticJoint if k < 3 else RevoluteJoint
        joint = plant.AddJoint(
            kind(f"{name}_joint{k}", frame, body.body_frame(), drake_vector(axis))
        )
        actuator = plant.AddJointActuator(f"{name}_motor{k}", joint)
        actuator.set_controller_gains(_SLIDE if k < 3 else _TURN)
        frame = body.body_frame()
    return body
