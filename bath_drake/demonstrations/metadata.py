"""What NAME.yaml says about a recording: frame, body box, who, licence."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.demonstrations.canonical import AXES_TOLERANCE, read_only
from bath_drake.errors import DemonstrationError
from bath_drake.notation import FloatArray
from bath_drake.yaml_block import Block
from bath_drake.yaml_io import read_yaml

# No body is longer.
MAX_EXTENT = 3.0


@dataclass(frozen=True, eq=False)
class BodyBox:
    """The box of the washed body part, in the recording's frame.

    Attributes:
        centre: Shape (3,), m.
        axes: Orthonormal rows: the person's right, to the head, out of the body;
            right-handed, shape (3, 3).
        extents: Full lengths of the box along right and head (and out), from the
            1st to the 99th percentile of the body part's points, shape (2,) or
            (3,), m.

    Raises:
        ValueError: On a wrong shape or value.
    """

    centre: FloatArray
    axes: FloatArray
    extents: FloatArray

    def __post_init__(self) -> None:
        for name in ("centre", "axes", "extents"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        if self.centre.shape != (3,) or not np.all(np.isfinite(self.centre)):
            raise ValueError(f"centre must be 3 numbers, got {self.centre.tolist()}")
        if self.axes.shape != (3, 3) or not (
            np.allclose(self.axes @ self.axes.T, np.eye(3), atol=AXES_TOLERANCE)
            and np.linalg.det(self.axes) > 0.0
        ):
            raise ValueError(
                "axes must be 3 orthonormal rows right, head, out (right-handed), "
                f"got {self.axes.tolist()}"
            )
        if self.extents.shape not in ((2,), (3,)) or not np.all(
            (self.extents > 0.0) & (self.extents <= MAX_EXTENT)
        ):
            raise ValueError(
                f"extents must be 2 or 3 lengths in (0, {MAX_EXTENT:g}] m, "
                f"got {self.extents.tolist()}"
            )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, BodyBox):
            return NotImplemented
        return all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("centre", "axes", "extents")
        )


@dataclass(frozen=True)
class RecordingMetadata:
    """What is known about a recording; empty where nothing is.

    Attributes:
        frame: Name of the frame the points are in.
        body_box: The body part's box in that frame, if known.
        who: Who was recorded, or what made it.
        licence: Terms of use.
        source: Where it comes from.
        synthetic: Whether a program made it.
        generator: The program and its version or command, if synthetic.
        seed: The program's seed, if synthetic.
        gaps: (start, end) of times without samples that are no part of the motion,
            s, in the recording's own time: the marker was hidden, for instance.
    """

    frame: str = ""
    body_box: BodyBox | None = None
    who: str = ""
    licence: str = ""
    source: str = ""
    synthetic: bool = False
    generator: str = ""
    seed: int | None = None
    gaps: tuple[tuple[float, float], ...] = ()


def read_metadata(path: str | Path) -> RecordingMetadata:
    """Reads NAME.yaml; raises DemonstrationError naming file and key."""
    block = Block(
        read_yaml(path, error=DemonstrationError), str(path), error=DemonstrationError
    )
    texts = {
        key: block.take(key, str)
        for key in ("frame", "who", "licence", "source", "generator")
        if block.has(key)
    }
    box = _body_box(block.take_block("body_box")) if block.has("body_box") else None
    synthetic = block.take("synthetic", bool) if block.has("synthetic") else False
    seed = block.take("seed", int) if block.has("seed") else None
    rows = block.take_rows("gaps", None, 2) if block.has("gaps") else []
    gaps = tuple((start, end) for start, end in rows)
    if any(not start < end for start, end in gaps):
        block.fail("gaps", "found a gap that does not end after its start")
    block.finish()
    return RecordingMetadata(
        body_box=box, synthetic=synthetic, seed=seed, gaps=gaps, **texts
    )


def metadata_block(metadata: RecordingMetadata) -> dict[str, Any]:
    """Returns what NAME.yaml holds, for `dump_yaml`; what is not known stays out."""
    block: dict[str, Any] = {
        key: getattr(metadata, key)
        for key in ("frame", "who", "licence", "source", "generator")
        if getattr(metadata, key)
    }
    box = metadata.body_box
    if box is not None:
        block["body_box"] = {
            key: getattr(box, key).tolist() for key in ("centre", "axes", "extents")
        }
    if metadata.synthetic:
        block["synthetic"] = True
    if metadata.seed is not None:
        block["seed"] = metadata.seed
    if metadata.gaps:
        block["gaps"] = [list(gap) for gap in metadata.gaps]
    return block


def _body_box(block: Block) -> BodyBox:
    centre = block.take_list("centre", float, 3)
    axes = block.take_rows("axes", 3, 3)
    extents = block.take_list("extents", float)
    block.finish()
    try:
        return BodyBox(np.array(centre), np.array(axes), np.array(extents))
    except ValueError as problem:
        block.fail("", str(problem))
