"""A drawn back for fast tests, and rendered people for the `render` ones."""

from dataclasses import dataclass

import numpy as np
import pytest

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.observation import observe_body
from bath_drake.perception.segmentation import SegmentationConfig

SKIN = (200, 150, 120)
WALL = (200, 198, 195)
TRUNKS = (40, 50, 110)

# The camera looks along +y of W, level, x to the right.
R_WC = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
P_WC = np.array([0.0, -1.3, 1.0])


@dataclass
class Frame:
    """One frame and what made it."""

    colour: np.ndarray
    depth: np.ndarray
    robot_mask: np.ndarray
    camera: PinholeCamera
    R_WC: np.ndarray
    p_WC: np.ndarray
    back: np.ndarray
    config: SegmentationConfig

    def observe(self, previous=None, stamp=0.0):
        return observe_body(
            self.colour,
            self.depth,
            self.robot_mask,
            camera=self.camera,
            R_WC=self.R_WC,
            p_WC=self.p_WC,
            config=self.config,
            stamp=stamp,
            previous=previous,
        )


def draw(*, shift=(0.0, 0.0), skin=SKIN, arm=True, wound=None, robot=None):
    """A back 0.34 m x 0.46 m, bulging by 40 mm, before a wall; metres at y = 0."""
    camera = PinholeCamera()
    x, z = camera.rays[..., 0] * 1.3 - shift[0], -camera.rays[..., 1] * 1.3 - shift[1]
    back = (np.abs(x) / 0.17) ** 6 + (np.abs(z) / 0.23) ** 6 <= 1.0
    # Upper arms hang beside the flanks, joined at the shoulders.
    side = np.abs(x)
    limb = (np.abs(side - 0.215) < 0.03) & (z > -0.15) & (z < 0.16)
    limb |= (side > 0.15) & (side < 0.22) & (z > 0.1) & (z < 0.16)
    limb &= arm
    depth = np.where(back | limb, 1.3 + 0.04 * (x / 0.17) ** 2, 2.6)
    colour = np.empty((*camera.shape, 3), dtype=np.uint8)
    colour[:] = WALL
    colour[(np.abs(x) < 0.2) & (z < -0.2) & (z > -0.35)] = TRUNKS
    colour[back | limb] = skin
    if wound is not None:
        cx, cz, a, b = wound
        colour[((x - cx) / a) ** 2 + ((z - cz) / b) ** 2 <= 1.0] = (25, 12, 12)
    robot_mask = np.zeros(camera.shape, dtype=bool)
    if robot is not None:
        left, right, low, high = robot
        robot_mask = (x > left) & (x < right) & (z > low) & (z < high)
        colour[robot_mask] = (230, 230, 230)
        depth[robot_mask] = 1.1
    config = SegmentationConfig(
        box_low_W=np.array([-0.6, -0.4, 0.5]), box_high_W=np.array([0.6, 0.4, 1.6])
    )
    return Frame(colour, depth, robot_mask, camera, R_WC, P_WC, back, config)


@pytest.fixture(scope="session")
def draw_frame():
    return draw


@pytest.fixture(scope="session")
def render_person():
    """Returns a function that renders a shipped person, seen from behind."""
    pytest.importorskip("pydrake")
    from pydrake.geometry import (
        Box,
        ClippingRange,
        ColorRenderCamera,
        DepthRange,
        DepthRenderCamera,
        GeometryInstance,
        MakeRenderEngineVtk,
        Mesh,
        PerceptionProperties,
        RenderCameraCore,
        RenderEngineVtkParams,
        RenderLabel,
        Rgba,
        SceneGraph,
    )
    from pydrake.math import RigidTransform, RotationMatrix
    from pydrake.systems.framework import DiagramBuilder
    from pydrake.systems.sensors import CameraInfo, RgbdSensor

    from bath_drake.resources import models_folder

    parts = ("body", "back", "hair", "trunks")
    cache = {}

    def mesh(person):
        data = np.load(models_folder() / "people" / person / "mesh.npz")
        return data["V"].astype(np.float64), data["F"], data["label"]

    def box_outline(size, pose):
        corners = np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, -1).T * size
        return (pose @ corners.T).T

    def render(person, *, lean=0.0, arm=None, wound=None, room=True):
        """`arm` (x, share of height) where a rod ends; `wound` (x, share, side)."""
        key = person, lean, arm, wound
        if key in cache:
            return cache[key]
        vertices, faces, label = mesh(person)
        X_WM = RigidTransform(
            RotationMatrix.MakeYRotation(np.radians(lean)), np.zeros(3)
        )
        back = vertices[label == 1]
        middle = (back.min(axis=0) + back.max(axis=0)) / 2.0 * [0.0, 1.0, 1.0]
        builder = DiagramBuilder()
        graph = builder.AddSystem(SceneGraph())
        source = graph.RegisterSource("scene")
        graph.AddRenderer("vtk", MakeRenderEngineVtk(RenderEngineVtkParams()))

        def add(shape, pose, name, label, rgba=None):
            instance = GeometryInstance(pose, shape, name)
            properties = PerceptionProperties()
            properties.AddProperty("label", "id", RenderLabel(label))
            if rgba is not None:
                properties.AddProperty("phong", "diffuse", Rgba(*rgba))
            instance.set_perception_properties(properties)
            graph.RegisterAnchoredGeometry(source, instance)

        for k, part in enumerate(parts):
            path = str(models_folder() / "people" / person / f"{part}.gltf")
            add(Mesh(path), X_WM, part, 100 + k)
        floor = RigidTransform(np.array([0.0, 0.0, -0.05]))
        add(Box(6.0, 6.0, 0.1), floor, "floor", 1, (0.75, 0.73, 0.7))
        wall = RigidTransform(np.array([0.0, -1.6, 1.5]))
        add(Box(6.0, 0.1, 3.0), wall, "wall", 2, (0.85, 0.83, 0.78))
        hulls = []
        for name, place, size, rgba, gap in (
            ("arm", arm, np.array([0.06, 0.06, 0.7]), (0.9, 0.9, 0.9), 0.08),
            ("wound", wound, None, (0.05, 0.03, 0.03), 0.0),
        ):
            if place is None:
                continue
            height = back[:, 2].min() + place[1] * np.ptp(back[:, 2])
            near = np.hypot(back[:, 0] - place[0], back[:, 2] - height).argmin()
            p = back[near] + [0.0, gap, 0.0]
            if name == "arm":
                # From the skin down and backwards, as the robot comes.
                pose = RigidTransform(
                    RotationMatrix.MakeXRotation(np.radians(35.0)), p
                ) @ RigidTransform(np.array([0.0, 0.0, -0.35]))
                hulls.append(box_outline(size, pose))
                add(Box(*size), pose, name, 3, rgba)
            else:
                side = place[2]
                pose = RigidTransform(X_WM.multiply(p))
                add(Box(side, 0.03, side), pose, name, 110, rgba)
        elevation = np.radians(42.0)
        p_WC = middle + 1.45 * np.array([0.0, np.cos(elevation), np.sin(elevation)])
        z = (middle - p_WC) / np.linalg.norm(middle - p_WC)
        x = np.cross(z, [0.0, 0.0, 1.0])
        x /= np.linalg.norm(x)
        R_WC = np.column_stack([x, np.cross(z, x), z])
        camera = PinholeCamera()
        info = CameraInfo(512, 424, camera.fx, camera.fy, camera.cx, camera.cy)
        core = RenderCameraCore("vtk", info, ClippingRange(0.1, 8.0), RigidTransform())
        sensor = builder.AddSystem(
            RgbdSensor(
                graph.world_frame_id(),
                RigidTransform(RotationMatrix(R_WC), p_WC),
                ColorRenderCamera(core, False),
                DepthRenderCamera(core, DepthRange(0.5, 4.5)),
            )
        )
        builder.Connect(graph.get_query_output_port(), sensor.query_object_input_port())
        diagram = builder.Build()
        context = sensor.GetMyContextFromRoot(diagram.CreateDefaultContext())
        colour = sensor.color_image_output_port().Eval(context).data[..., :3].copy()
        depth = sensor.depth_image_32F_output_port().Eval(context).data[..., 0].copy()
        labels = sensor.label_image_output_port().Eval(context).data[..., 0].copy()
        from bath_drake.perception.self_filter import robot_silhouette

        frame = Frame(
            colour,
            depth.astype(np.float64),
            robot_silhouette(hulls, camera, R_WC, p_WC),
            camera,
            R_WC,
            p_WC,
            (labels == 101) | (labels == 110),
            SegmentationConfig(
                box_low_W=np.array([-0.6, -0.9, 0.3]),
                box_high_W=np.array([0.6, 0.3, 1.5]),
            ),
        )
        frame.labels = labels
        frame.X_WM = X_WM
        frame.mesh = vertices, faces, label
        cache[key] = frame
        return frame

    return render
