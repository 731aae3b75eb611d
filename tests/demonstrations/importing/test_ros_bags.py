"""Poses, points and transforms of ROS 1 and ROS 2 bags; no ROS is installed."""

import sys

import numpy as np
import pytest
from foreign_files import HAND, T

from bath_drake.cli import main
from bath_drake.demonstrations.recording import read_recording

rosbag1 = pytest.importorskip("rosbags.rosbag1")
from rosbags.rosbag2 import StoragePlugin  # noqa: E402
from rosbags.rosbag2 import Writer as Writer2  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

# Nanoseconds of the first stamp: today a float64 of seconds has microseconds left.
BEGIN = 1_790_000_000_123_456_789


def message(store, kind, k, point, frame="world"):
    types = store.types
    stamp = BEGIN + round(1e9 * T[k])
    time = types["builtin_interfaces/msg/Time"](
        sec=stamp // 1_000_000_000, nanosec=stamp % 1_000_000_000
    )
    fields = {"stamp": time, "frame_id": frame}
    header_type = types["std_msgs/msg/Header"]
    if "seq" in header_type.__dataclass_fields__:
        fields["seq"] = k
    header = header_type(**fields)
    turn = types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    where = dict(zip("xyz", map(float, point), strict=True))
    if kind == "PoseStamped":
        inner = types["geometry_msgs/msg/Pose"](
            position=types["geometry_msgs/msg/Point"](**where), orientation=turn
        )
        return types["geometry_msgs/msg/PoseStamped"](header=header, pose=inner)
    if kind == "PointStamped":
        inner = types["geometry_msgs/msg/Point"](**where)
        return types["geometry_msgs/msg/PointStamped"](header=header, point=inner)
    inner = types["geometry_msgs/msg/Transform"](
        translation=types["geometry_msgs/msg/Vector3"](**where), rotation=turn
    )
    return types["geometry_msgs/msg/TransformStamped"](
        header=header, child_frame_id="hand", transform=inner
    )


def write_ros1(path, topics, points=HAND, frames=None):
    store = get_typestore(Stores.ROS1_NOETIC)
    with rosbag1.Writer(path) as writer:
        for topic, kind in topics.items():
            name = f"geometry_msgs/msg/{kind}"
            connection = writer.add_connection(topic, name, typestore=store)
            for k, point in enumerate(points):
                frame = "world" if frames is None else frames[k]
                sent = message(store, kind, k, point, frame)
                data = store.serialize_ros1(sent, name)
                writer.write(connection, BEGIN + round(1e9 * T[k]), data)
    return path


def write_ros2(path, kind, plugin):
    store = get_typestore(Stores.ROS2_HUMBLE)
    name = f"geometry_msgs/msg/{kind}"
    with Writer2(path, version=9, storage_plugin=plugin) as writer:
        connection = writer.add_connection("/hand", name, typestore=store)
        for k, point in enumerate(HAND):
            data = store.serialize_cdr(message(store, kind, k, point), name)
            writer.write(connection, BEGIN + round(1e9 * T[k]), data)
    return path


def imported(file, tmp_path, *words):
    output = tmp_path / "demo.csv"
    assert main(["import", str(file), "-o", str(output), *words]) == 0
    return read_recording(output)


def refused(capsys, file, tmp_path, *words):
    assert main(["import", str(file), "-o", str(tmp_path / "demo.csv"), *words]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert not (tmp_path / "demo.csv").exists()
    return said


KINDS = ("PoseStamped", "PointStamped", "TransformStamped")


@pytest.mark.parametrize("kind", KINDS)
def test_a_topic_of_a_ros_1_bag(kind, tmp_path):
    recording = imported(write_ros1(tmp_path / "a.bag", {"/hand": kind}), tmp_path)
    np.testing.assert_allclose(recording.points, HAND, atol=1e-6)
    # To the microseconds that are written.
    np.testing.assert_allclose(recording.t, T, atol=1e-6)
    assert recording.metadata.frame == "world"


@pytest.mark.parametrize("plugin", [StoragePlugin.SQLITE3, StoragePlugin.MCAP])
def test_a_topic_of_a_ros_2_bag(plugin, tmp_path):
    recording = imported(write_ros2(tmp_path / "bag", "PoseStamped", plugin), tmp_path)
    np.testing.assert_allclose(recording.points, HAND, atol=1e-6)


def test_of_several_topics_one_is_told(tmp_path, capsys):
    file = write_ros1(tmp_path / "a.bag", {"/a": "PoseStamped", "/b": "PointStamped"})
    said = refused(capsys, file, tmp_path)
    assert "found 2 topics" in said
    assert "--topic; there are: /a, /b" in said
    assert "found no topic '/c'" in refused(capsys, file, tmp_path, "--topic", "/c")
    assert len(imported(file, tmp_path, "--topic", "/b").t) == len(T)


def test_frames_must_not_change(tmp_path, capsys):
    frames = ["world"] * 30 + ["map"] * 30
    file = write_ros1(tmp_path / "a.bag", {"/a": "PoseStamped"}, frames=frames)
    assert "found frames map, world" in refused(capsys, file, tmp_path)


@pytest.mark.parametrize("kept", [0, 40, 0.5, 0.98])
def test_a_damaged_bag_is_refused_by_name(kept, tmp_path, capsys):
    file = write_ros1(tmp_path / "a.bag", {"/hand": "PoseStamped"})
    content = file.read_bytes()
    file.write_bytes(content[: round(kept * len(content)) if kept < 1 else kept])
    assert "a.bag: " in refused(capsys, file, tmp_path)


def test_one_point_and_no_length_are_refused(tmp_path, capsys):
    file = write_ros1(tmp_path / "a.bag", {"/hand": "PoseStamped"}, HAND[:1])
    assert "found 1 points" in refused(capsys, file, tmp_path)
    file = write_ros1(tmp_path / "b.bag", {"/hand": "PoseStamped"}, 0.0 * HAND)
    assert "has no length" in refused(capsys, file, tmp_path)
    file = write_ros1(tmp_path / "c.bag", {"/hand": "PoseStamped"}, 1000.0 * HAND)
    assert "millimetres?" in refused(capsys, file, tmp_path)


def test_without_the_library_the_extra_is_named(tmp_path, capsys, monkeypatch):
    file = tmp_path / "a.bag"
    file.write_bytes(b"")
    for name in [name for name in sys.modules if name.startswith("rosbags")]:
        monkeypatch.setitem(sys.modules, name, None)
    said = refused(capsys, file, tmp_path)
    assert "pip install 'bath-drake[ros]'" in said
