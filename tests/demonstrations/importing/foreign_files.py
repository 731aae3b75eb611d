"""Small files of other programs, written with the libraries that read them."""

import ezc3d
import numpy as np

T = np.arange(60) / 30.0
# A washing stroke of 40 cm, m.
HAND = np.column_stack([0.2 * T, 0.05 * np.sin(3.0 * T), 0.9 + 0.01 * T])
CORNERS = {
    "RSHO": [0.2, 0.25, 0.0],
    "LSHO": [-0.2, 0.25, 0.0],
    "RPSI": [0.1, -0.25, 0.0],
    "LPSI": [-0.1, -0.25, 0.0],
}


def write_csv(path, header="time,px,py,pz", rows=None, delimiter=","):
    rows = np.column_stack([T, HAND]) if rows is None else rows
    lines = [delimiter.join(f"{v:.6f}" for v in row) for row in rows]
    path.write_text("\n".join([header.replace(",", delimiter), *lines, ""]))
    return path


def write_c3d(path, markers, unit="mm", rate=30.0, prefix=""):
    """Markers by name: (n, 3) in the unit told."""
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [rate]
    names = [prefix + name for name in markers]
    file["parameters"]["POINT"]["LABELS"]["value"] = names
    file["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    count = len(next(iter(markers.values())))
    points = np.ones((4, len(markers), count))
    for k, track in enumerate(markers.values()):
        points[:3, k] = np.asarray(track).T
    file["data"]["points"] = points
    file.write(str(path))
    return path


def body_markers(R=None, p=(0.0, 0.0, 0.0)):
    """The back's corners, turned by R (n, 3, 3) and moved by p (n, 3), mm."""
    R = np.tile(np.eye(3), (len(T), 1, 1)) if R is None else R
    return {
        name: 1e3 * (np.einsum("nij,j->ni", R, np.array(corner)) + p)
        for name, corner in CORNERS.items()
    }


MODEL = """<Robot Type="MMM" RootNode="root">
  <RobotNode name="root"><Child name="arm"/></RobotNode>
  <RobotNode name="arm">
    <Transform><Translation x="0" y="0" z="300"/></Transform>
    <Joint type="revolute"><Axis x="0" y="0" z="1"/></Joint>
    <Child name="hand"/>
  </RobotNode>
  <RobotNode name="hand">
    <Transform><Translation x="250" y="0" z="0"/></Transform>
  </RobotNode>
</Robot>
"""


def write_model(path):
    path.write_text(MODEL)
    return path


def mmm_frames(angles, root=(0.0, 0.0, 1000.0), rpy=(0.0, 0.0, 0.0)):
    lines = []
    for k, angle in enumerate(angles):
        lines.append(
            f"<MotionFrame><Timestep>{k / 100:.3f}</Timestep>"
            f"<RootPosition>{root[0]} {root[1]} {root[2]}</RootPosition>"
            f"<RootRotation>{rpy[0]} {rpy[1]} {rpy[2]}</RootRotation>"
            f"<JointPosition>{angle:.9f}</JointPosition></MotionFrame>"
        )
    return "\n".join(lines)


def write_mmm(path, frames, height="<Height>1.8</Height>", head=""):
    path.write_text(
        f"{head}<MMM><Motion name='subject'><ModelProcessorConfig type='Winter'>"
        f"{height}</ModelProcessorConfig><JointOrder><Joint name='arm'/></JointOrder>"
        f"<MotionFrames>{frames}</MotionFrames></Motion></MMM>"
    )
    return path
