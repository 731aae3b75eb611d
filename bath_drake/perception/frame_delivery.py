"""When a camera's frames arrive, if they do: lost, late and frozen ones."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bath_drake.notation import ByteArray, FloatArray
from bath_drake.perception.faults import FaultsConfig, FrameFault, within
from bath_drake.shared import Shared

_STREAM = 3


@dataclass(frozen=True, eq=False)
class Frame(Shared):
    """One frame, and the arm as it was when it was taken.

    Attributes:
        stamp: When it was taken, s.
        colour: (H, W, 4) RGBA.
        depth: (H, W), m along the optical axis.
        arm_position: (7,) joint positions, rad.
    """

    stamp: float
    colour: ByteArray
    depth: NDArray[np.float32]
    arm_position: FloatArray


@dataclass(frozen=True)
class FrameFate:
    """What becomes of a frame.

    Attributes:
        lost: It never comes.
        frozen: It shows the image of the frame before it.
        delay: It comes this much late, s.
        back: Its stamp is this much of the past, s.
    """

    lost: bool = False
    frozen: bool = False
    delay: float = 0.0
    back: float = 0.0


@dataclass(frozen=True, eq=False)
class Delivery:
    """What has come of the frames so far.

    Attributes:
        index: Of the last frame taken; -1 before the first.
        newest: The frame with the latest stamp that has come, or None.
        sent: The last frame that the camera sent, or None.
        pending: Frames on their way, and when they are due, s.
    """

    index: int = -1
    newest: Frame | None = None
    sent: Frame | None = None
    pending: tuple[tuple[float, Frame], ...] = ()


def frame_fate(config: FaultsConfig, *, seed: int, index: int, t: float) -> FrameFate:
    """Returns a frame's fate; the same for the same seed and index.

    Args:
        config: The faults.
        seed: Not negative, of the whole run.
        index: The frame's number.
        t: When it is taken, s.
    """
    draws = np.random.default_rng([seed, index, _STREAM]).random(4)

    def struck(fault: FrameFault | None, draw: float) -> bool:
        return fault is not None and within(fault, t) and draw < fault.probability

    late, backwards = config.late, config.backwards
    went_back = backwards is not None and struck(backwards, draws[3])
    return FrameFate(
        lost=struck(config.loss, draws[0]),
        frozen=struck(config.frozen, draws[1]),
        delay=late.delay if late is not None and struck(late, draws[2]) else 0.0,
        back=backwards.by if backwards is not None and went_back else 0.0,
    )


def next_delivery(
    before: Delivery, index: int, frame: Frame, fate: FrameFate
) -> Delivery:
    """Returns what has come once another frame is taken.

    A late frame is handed over when the first frame after its due time is taken, and
    not at all if a newer one has come before it.

    Args:
        before: What had come until then.
        index: Number of the frame.
        frame: As taken now.
        fate: What becomes of it.
    """
    now, pending, sent = frame.stamp, before.pending, before.sent
    if fate.back > 0.0 and not fate.lost:
        # Whoever stamps its frames so has no order of its own to deliver them in.
        past = replace(frame, stamp=now - fate.back)
        return Delivery(index=index, newest=past, sent=frame, pending=pending)
    if not fate.lost:
        if fate.frozen and sent is not None:
            frame = replace(frame, colour=sent.colour, depth=sent.depth)
        sent = frame
        pending = (*pending, (now + fate.delay, frame))
    rounding = 1e-9
    come = [f for due, f in pending if due <= now + rounding]
    if before.newest is not None:
        come.append(before.newest)
    newest = max(come, key=lambda f: f.stamp, default=None)
    return Delivery(
        index=index,
        newest=newest,
        sent=sent,
        pending=tuple(
            (due, f)
            for due, f in pending
            if due > now + rounding and (newest is None or f.stamp > newest.stamp)
        ),
    )


def dropped_frames(
    config: FaultsConfig, *, seed: int, period: float, count: int
) -> int:
    """Returns how many of a run's frames never came, or after a newer one.

    Args:
        config: The faults.
        seed: Of the run.
        period: Of the camera, s.
        count: Of the frames taken; those still on their way at the end are not dropped.
    """
    if not config.any:
        return 0
    nothing = np.zeros(0)
    delivery, come = Delivery(), set()
    for k in range(count):
        t = k * period
        frame = Frame(t, nothing.astype(np.uint8), nothing.astype(np.float32), nothing)
        fate = frame_fate(config, seed=seed, index=k, t=t)
        delivery = next_delivery(delivery, k, frame, fate)
        if delivery.newest is not None:
            come.add(delivery.newest.stamp)
    return count - len(come) - len(delivery.pending)
