"""A network of one's own, as an ONNX file (extra `onnx`).

It takes one picture, (1, c, h, w) or (1, h, w, c), float32: red, green and blue of 0 to
1 and, if c is 4, depth in metres, zero where unknown. It gives one mask, (1, 1, h, w),
(1, h, w, 1) or (1, h, w), of probabilities, or of logits if any is outside 0 to 1.
Sizes that are open are taken as 256.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bath_drake.errors import SegmenterError
from bath_drake.notation import BoolArray, FloatArray
from bath_drake.perception.region import region_of
from bath_drake.perception.segmentation import SegmentationConfig, skin_mask
from bath_drake.perception.segmenter import Picture

OPEN_SIZE = 256
PROBABLE = 0.5

# What the mask may be of.
MASKS = ("skin", "person")


class OnnxSegmenter:
    """Skin is what the network says, or what has skin's colour on its person."""

    def __init__(
        self, model: Path, config: SegmentationConfig, *, mask: str = "skin"
    ) -> None:
        """Loads the network.

        Args:
            model: The .onnx file.
            config: Box, and what colours skin has.
            mask: What the network's mask is of: `skin`, or a whole `person`, of which
                the colour then tells what is skin.

        Raises:
            SegmenterError: If the runtime is not installed, the file no such network,
                or the mask none of these.
        """
        if mask not in MASKS:
            raise SegmenterError(f"mask: found {mask!r}, allowed: {', '.join(MASKS)}")
        self._config = config
        self._mask = mask
        self._model = model
        self._session: Any = _session(model)
        inputs = self._session.get_inputs()
        shape = list(inputs[0].shape) if len(inputs) == 1 else []
        fits = len(shape) == 4 and inputs[0].type == "tensor(float)"
        fits = fits and (shape[0] == 1 or not isinstance(shape[0], int))
        self._first = fits and shape[1] in (3, 4)  # channels before rows and columns
        sizes = shape[2:] if self._first else shape[1:3]
        self._size = tuple(s if isinstance(s, int) else OPEN_SIZE for s in sizes)
        fits = fits and (self._first or shape[3] in (3, 4)) and min(self._size) > 0
        if not fits:
            found = ", ".join(f"{one.shape} {one.type}" for one in inputs) or "none"
            raise SegmenterError(
                f"{model}: found input {found}; allowed one of float, "
                "(1, c, h, w) or (1, h, w, c) with c 3 or 4"
            )
        self._name = inputs[0].name
        self._channels = int(shape[1] if self._first else shape[3])

    def segment(self, picture: Picture) -> BoolArray:
        """Returns the pixels (H, W) that show skin.

        Raises:
            SegmenterError: If the network fails on the picture, gives no mask of its
                input's size, or something that is not finite.
        """
        shape = picture.camera.shape
        region = region_of(picture)
        if region is None:
            return np.zeros(shape, dtype=np.bool_)
        colour = picture.colour[..., :3]
        planes = colour.astype(np.float32) / 255.0
        if self._channels == 4:
            known = np.isfinite(picture.depth)
            depth = np.where(known, picture.depth, 0.0).astype(np.float32)
            planes = np.concatenate([planes, depth[..., None]], axis=2)
        cropped = region.crop(planes, *self._size)
        if self._first:
            cropped = cropped.transpose(2, 0, 1)
        batch = np.ascontiguousarray(cropped[None], dtype=np.float32)
        given = self._run(batch)
        found = region.paste(self._probable(given), shape) > PROBABLE
        if self._mask == "person":
            found = found & skin_mask(colour, self._config)
        return np.asarray(found)

    def _run(self, batch: NDArray[np.float32]) -> FloatArray:
        try:
            (given, *_) = self._session.run(None, {self._name: batch})
        except Exception as error:  # the runtime's own kinds have no common base
            reason = " ".join(str(error).split())[:120]
            raise SegmenterError(
                f"{self._model}: does not run on input {batch.shape}: {reason}"
            ) from error
        return np.asarray(given)

    def _probable(self, given: FloatArray) -> FloatArray:
        mask = given.squeeze()
        if mask.shape != self._size or not np.isfinite(mask).all():
            raise SegmenterError(
                f"{self._model}: found output {given.shape}, allowed a finite mask of "
                f"the input's size {self._size}"
            )
        mask = mask.astype(np.float32)
        if mask.min() < 0.0 or mask.max() > 1.0:
            # Beyond that the exponential of a float overflows, and 1 is 1.
            mask = 1.0 / (1.0 + np.exp(-np.clip(mask, -60.0, 60.0)))
        return np.asarray(mask)


def _session(model: Path) -> Any:
    try:
        import onnxruntime
    except ModuleNotFoundError as error:
        raise SegmenterError(
            "a segmenter of one's own needs onnxruntime: pip install 'bath-drake[onnx]'"
        ) from error
    if not model.is_file():
        raise SegmenterError(f"{model}: missing; expected an .onnx file")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    options.log_severity_level = 4  # what is wrong is raised, and said once
    try:
        return onnxruntime.InferenceSession(
            str(model), options, providers=["CPUExecutionProvider"]
        )
    except Exception as error:  # the runtime's own kinds have no common base
        reason = " ".join(str(error).split())[:120]
        raise SegmenterError(f"{model}: no ONNX model: {reason}") from error
