"""ROS 1 and ROS 2 bags: the poses of one topic. No ROS is needed (`rosbags`)."""

from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.demonstrations.importing.checks import MAX_SAMPLES
from bath_drake.demonstrations.importing.source import (
    ImportOptions,
    Track,
    listed,
)
from bath_drake.errors import DemonstrationError

# Where the point is in each kind of message.
KINDS = {
    "geometry_msgs/msg/PoseStamped": ("pose", "position"),
    "geometry_msgs/msg/PointStamped": ("point",),
    "geometry_msgs/msg/TransformStamped": ("transform", "translation"),
}


def read_bag(path: Path, options: ImportOptions) -> Track:
    """Reads the stamped points of a topic; times are the headers' stamps.

    Raises:
        DemonstrationError: Naming the bag and what is wrong or missing in it.
    """
    reader = _library()
    try:
        topic, rows, frames = _messages(reader, path, options)
    except DemonstrationError:
        raise
    # Whatever it is, the bag made the library raise it.
    except Exception as problem:
        told = str(problem).splitlines() or [type(problem).__name__]
        raise DemonstrationError(f"{path}: not a readable bag ({told[0]})") from None
    if len(frames) > 1:
        raise DemonstrationError(
            f"{path}: {topic}: found frames {', '.join(sorted(frames))}, expected one"
        )
    if not rows:
        raise DemonstrationError(f"{path}: {topic}: no message")
    table = np.array(rows, dtype=np.float64)
    # Nanoseconds since 1970 are more than a float holds: from the first one on.
    stamps = np.array([row[0] for row in rows], dtype=np.int64)
    t = (stamps - stamps[0]) * 1e-9
    points = table[:, 1:] * options.metres("m")
    places = tuple(f"message {k + 1}" for k in range(len(rows)))
    return Track(t, points, f"topic {topic}", places, frame=next(iter(frames)))


def _library() -> Any:
    try:
        from rosbags.highlevel import AnyReader
    except ImportError:
        raise DemonstrationError(
            "ROS bags are read with rosbags, which is not installed: "
            "pip install 'bath-drake[ros]'"
        ) from None
    return AnyReader


def _messages(
    reader: Any, path: Path, options: ImportOptions
) -> tuple[str, list[tuple[float, ...]], set[str]]:
    """The topic, its rows (ns, x, y, z) and the frames they are in."""
    rows: list[tuple[float, ...]] = []
    frames: set[str] = set()
    with reader([path]) as bag:
        topics = {c.topic: c.msgtype for c in bag.connections if c.msgtype in KINDS}
        topic = _chosen(path, topics, options.topic)
        chosen = [
            c for c in bag.connections if (c.topic, c.msgtype) == (topic, topics[topic])
        ]
        for connection, _, data in bag.messages(connections=chosen):
            message = bag.deserialize(data, connection.msgtype)
            rows.append(_row(message, KINDS[topics[topic]]))
            frames.add(str(message.header.frame_id))
            if len(rows) > MAX_SAMPLES:
                raise DemonstrationError(
                    f"{path}: {topic}: found more than {MAX_SAMPLES} messages, which "
                    "is no stroke"
                )
    return topic, rows, frames


def _chosen(path: Path, topics: dict[str, str], told: str) -> str:
    names = sorted(topics)
    if told and told not in topics:
        raise DemonstrationError(
            f"{path}: --topic: found no topic {told!r} of poses, points or transforms; "
            f"there are: {listed(names)}"
        )
    if not told and len(names) != 1:
        raise DemonstrationError(
            f"{path}: found {len(names)} topics of poses, points or transforms; say "
            f"which with --topic; there are: {listed(names)}"
        )
    return told or names[0]


def _row(message: Any, attributes: tuple[str, ...]) -> tuple[float, ...]:
    point = message
    for name in attributes:
        point = getattr(point, name)
    stamp = message.header.stamp
    nanoseconds = int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
    return nanoseconds, float(point.x), float(point.y), float(point.z)
