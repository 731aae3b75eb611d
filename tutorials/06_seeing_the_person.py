# %% [markdown]
# # Seeing the person
#
# From a depth camera's images to where the nozzle is to be, stage by stage and each as
# a picture: the images with a Kinect's noise, the back in them, the canonical map, the
# wound, and the skin under a stroke. The person bends, breathes and has a wound; the
# truth of the mesh is used to draw errors, never to find anything.

# %%
import matplotlib.pyplot as plt
import numpy as np
from pydrake.systems.analysis import Simulator

from bath_drake.diagrams import build_perception
from bath_drake.patient.motion import trunk_bend
from bath_drake.patient.people import load_person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin import TrueSkin
from bath_drake.perception.canonical import apply_homography
from bath_drake.perception.colour_noise import ColourNoiseConfig
from bath_drake.perception.surface import fit_path
from bath_drake.scenario import find_skill, load_scenario
from bath_drake.scene.config import WoundConfig
from bath_drake.scene.studio import true_person_pose
from bath_drake.skill_file import load_skill

# %% [markdown]
# ## A Diagram that only looks
#
# `build_perception` has the scene, the camera and what is made of its images; the arm
# stays at home. Two seconds in, the person has begun to bend.

# %%
scenario = load_scenario("bending")
scenario.scene.person = "f_avg"
scenario.scene.camera.colour_noise = ColourNoiseConfig()
scenario.scene.wound = WoundConfig(centre=[0.35, -0.1], semi_axes=[0.14, 0.1])
diagram = build_perception(scenario)
simulator = Simulator(diagram)
time = 2.005  # some milliseconds after a frame: the map and the areas are known
simulator.AdvanceTo(time)
context = simulator.get_context()


def output(system, port):
    subsystem = diagram.GetSubsystemByName(system)
    return subsystem.GetOutputPort(port).Eval(subsystem.GetMyContextFromRoot(context))


# %% [markdown]
# ## What the camera sees
#
# Drake renders; `ColourNoise` and `DepthNoise` make of it what a Kinect v2 measures:
# pixels without depth at edges and where skin is seen at a flat angle, a millimetre or
# two of noise elsewhere (docs/sensors.md).

# %%
colour = output("colour_noise", "noisy_colour_image").data[..., :3]
clean = output("camera", "depth_image_32f").data[..., 0]
depth = output("depth_noise", "noisy_depth_image").data[..., 0]
observation = diagram.GetOutputPort("body_observation").Eval(context)
rows, columns = np.nonzero(observation.mask)
view = (
    slice(max(rows.min() - 45, 0), rows.max() + 25),
    slice(max(columns.min() - 45, 0), columns.max() + 45),
)
extent = (view[1].start, view[1].stop, view[0].stop, view[0].start)

figure, axes = plt.subplots(1, 3, figsize=(12, 4.6), layout="constrained")
axes[0].imshow(colour[view], extent=extent)
axes[0].set_title("Colour")
shown = axes[1].imshow(
    np.where((depth > 0) & np.isfinite(depth), depth, np.nan)[view],
    extent=extent,
    vmin=float(np.nanmin(clean[observation.mask])),
    vmax=float(np.nanmax(clean[observation.mask])),
    cmap="viridis",
)
figure.colorbar(shown, ax=axes[1], label="depth [m]")
axes[1].set_title("Depth; white was not measured")
shown = axes[2].imshow(
    1e3 * (depth - clean)[view], extent=extent, vmin=-5, vmax=5, cmap="RdBu"
)
figure.colorbar(shown, ax=axes[2], label="measured less true [mm]")
axes[2].set_title("The sensor's noise")
plt.show()

# %% [markdown]
# ## The back
#
# What lies in the workspace's box, has skin's colour and is stout enough for a torso;
# without the tops of the shoulders, the neck and what the sensor lost.

# %%
figure, axis = plt.subplots(figsize=(5, 5), layout="constrained")
axis.imshow(colour[view], extent=extent)
axis.contour(
    np.arange(*extent[:2]) + 0.5,
    np.arange(extent[3], extent[2]) + 0.5,
    observation.mask[view].astype(float),
    levels=[0.5],
    colors="#00a37a",
)
axis.set_title(f"The back: {1e4 * observation.area:.0f} cm² of skin in sight")
plt.show()

# %% [markdown]
# ## The canonical map
#
# The plane of the back's principal axes, its y axis along the midline, and the box of
# the 1-99 % extents in it: what canonical space N scales to [-1, 1]². T_IN takes N into
# the picture. The restricted area is an ellipse in N, the wound with its margin.

# %%
body = diagram.GetOutputPort("canonical_map").Eval(context)
areas = diagram.GetOutputPort("sensed_obstacles").Eval(context)
camera = scenario.scene.camera.pinhole()
T_IN = body.image_transform(camera, observation.R_WC, observation.p_WC)
ticks = np.linspace(-1.0, 1.0, 9)
line = np.linspace(-1.0, 1.0, 50)

figure, axis = plt.subplots(figsize=(5, 5), layout="constrained")
axis.imshow(colour[view], extent=extent)
for tick in ticks:
    for grid in ([np.full(50, tick), line], [line, np.full(50, tick)]):
        axis.plot(*apply_homography(T_IN, np.stack(grid, axis=1)).T, "#f0e442", lw=0.7)
for ellipse in areas.boundary():
    axis.plot(*apply_homography(T_IN, ellipse).T, "#aa3377", lw=2)
axis.set_title(f"Canonical space and {len(areas)} restricted area")
plt.show()
print(f"half extents {np.round(100 * body.half_extents, 1)} cm")

# %% [markdown]
# ## The skin under a stroke
#
# At each place of the shipped skill's mean demonstration a quadric is fitted to the
# points around. It gives the point, the normal, how the skin curves, and a quality: how
# probably the normal is within 3 degrees of the true one.

# %%
skill = load_skill(find_skill(scenario.skill))
stroke = skill.mean_demonstration[:: max(1, len(skill.mean_demonstration) // 60)]
patches = fit_path(observation.points_W, body, stroke)
fitted = [patch for patch in patches if patch.valid]

person = load_person(scenario.scene.person)
bend = trunk_bend(observation.stamp, scenario.scene.motion)
skin = TrueSkin(person, bending_skin(person).points(bend))
X_WM = true_person_pose(scenario.scene, person, observation.stamp)
R_WM, p_WM = np.array(X_WM.rotation().matrix()), np.array(X_WM.translation())
p_M = (np.array([patch.p_WS for patch in fitted]) - p_WM) @ R_WM
_, nearest, normals_M = skin.nearest(p_M)
normals_W = np.array([patch.normal_W for patch in fitted])
cosine = np.clip((normals_W * (normals_M @ R_WM.T)).sum(axis=1), -1.0, 1.0)
height_mm = 1e3 * ((p_M - nearest) * normals_M).sum(axis=1)

figure, axes = plt.subplots(1, 2, figsize=(11, 4.6), layout="constrained")
axes[0].imshow(colour[view], extent=extent)
for patch in fitted:
    ends = np.array([patch.p_WS, patch.p_WS + 0.05 * patch.normal_W])
    p_C = (ends - observation.p_WC) @ observation.R_WC
    axes[0].plot(*camera.project(p_C).T, "#1763e0", lw=1)
axes[0].set_title("Normals, 5 cm long")
axes[1].plot(np.degrees(np.arccos(cosine)), label="normal's error [°]")
axes[1].plot(np.abs(height_mm), label="height's error [mm]")
axes[1].plot([patch.quality for patch in fitted], label="quality")
axes[1].set_xlabel("place along the stroke")
axes[1].set_ylim(bottom=0.0)
axes[1].legend()
axes[1].set_title("Against the bent mesh")
plt.show()
print(
    f"{len(fitted)} of {len(patches)} places fitted; normals off by "
    f"{np.degrees(np.median(np.arccos(cosine))):.1f} degrees (median), heights by "
    f"{np.sqrt(np.mean(height_mm**2)):.2f} mm (rms)"
)

# %% [markdown]
# From here `SurfaceReference` squares the nozzle to the skin, moved on to now by
# `SurfaceVelocity`; `bath-drake bench perception` measures all of it on every shipped
# person.
