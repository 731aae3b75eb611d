"""A small network that knows people, and the colour of skin (extra `neural`)."""

from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.errors import SegmenterError
from bath_drake.notation import BoolArray
from bath_drake.perception.region import region_of
from bath_drake.perception.segmentation import SegmentationConfig, skin_mask
from bath_drake.perception.segmenter import Picture

# More probable than this a pixel shows a person.
PROBABLE = 0.5


class NeuralSegmenter:
    """Skin is what has its colour and is on a person.

    The network (MediaPipe's selfie segmentation) looks at the square around what is in
    the workspace box, for in the whole picture a person is small.
    """

    def __init__(
        self, model: Path, config: SegmentationConfig, *, with_colour: bool = True
    ) -> None:
        """Loads the network.

        Args:
            model: A .tflite file that maps (1, h, w, 3), RGB of 0 to 1, to
                (1, h, w, 1), the probability of a person.
            config: Box, and what colours skin has.
            with_colour: Whether colour counts too. Without it, as under coloured light,
                clothes at the waist are taken for skin.

        Raises:
            SegmenterError: If the runtime is not installed, or the file no such
                network.
        """
        self._config = config
        self._with_colour = with_colour
        self._network: Any = _interpreter(model)
        self._input = self._network.get_input_details()[0]
        self._output = self._network.get_output_details()[0]
        taken, given = tuple(self._input["shape"]), tuple(self._output["shape"])
        if len(taken) != 4 or taken[3] != 3 or given != (*taken[:3], 1):
            raise SegmenterError(
                f"{model}: found a network from {taken} to {given}, "
                "allowed from (1, h, w, 3) to (1, h, w, 1)"
            )
        self._size = int(taken[1]), int(taken[2])

    def segment(self, picture: Picture) -> BoolArray:
        """Returns the pixels (H, W) of a person, with skin's colour if that counts."""
        shape = picture.camera.shape
        region = region_of(picture)
        if region is None:
            return np.zeros(shape, dtype=np.bool_)
        colour = picture.colour[..., :3]
        cropped = region.crop(colour, *self._size).astype(np.float32) / 255.0
        self._network.set_tensor(self._input["index"], cropped[None])
        self._network.invoke()
        probable = self._network.get_tensor(self._output["index"])[0, ..., 0]
        person = region.paste(probable, shape) > PROBABLE
        return person & skin_mask(colour, self._config) if self._with_colour else person


def _interpreter(model: Path) -> Any:
    try:
        from ai_edge_litert.interpreter import Interpreter
    except ModuleNotFoundError as error:
        raise SegmenterError(
            "the neural segmenter needs ai-edge-litert: "
            "pip install 'bath-drake[neural]'"
        ) from error
    if not model.is_file():
        raise SegmenterError(f"{model}: missing; expected a .tflite file")
    try:
        network = Interpreter(str(model), num_threads=1)
        network.allocate_tensors()
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())[:120]
        raise SegmenterError(f"{model}: no TensorFlow Lite model: {reason}") from error
    return network
