"""All segmenters keep one protocol; networks are checked before they are used."""

import builtins
import re

import numpy as np
import pytest

from bath_drake.diagrams.perception import make_segmenter
from bath_drake.errors import SegmenterError
from bath_drake.perception.config import PerceptionConfig
from bath_drake.perception.crop import boxed_pixels
from bath_drake.perception.neural_segmenter import NeuralSegmenter
from bath_drake.perception.onnx_segmenter import OnnxSegmenter
from bath_drake.perception.region import Region, region_around
from bath_drake.perception.segmentation import skin_mask
from bath_drake.perception.segmenter import ClassicSegmenter, Picture
from bath_drake.resources import models_folder
from bath_drake.scenario import Scenario

SHIPPED = models_folder() / "segmenters" / "selfie_segmentation.tflite"


def picture_of(frame):
    low, high = frame.config.box_low_W, frame.config.box_high_W
    R_WC = np.ascontiguousarray(frame.R_WC)
    boxed = boxed_pixels(frame.depth, frame.camera, R_WC, frame.p_WC, low, high)
    return Picture(frame.colour, frame.depth, frame.camera, boxed)


@pytest.fixture
def frame(draw_frame):
    return draw_frame()


def test_the_classic_one_is_the_colour_filter_in_the_box(frame):
    picture = picture_of(frame)
    mask = ClassicSegmenter(frame.config).segment(picture)
    expected = skin_mask(frame.colour, frame.config) & picture.boxed
    np.testing.assert_array_equal(mask, expected)


def test_a_region_goes_there_and_back():
    mask = np.zeros((90, 120), dtype=bool)
    mask[30:60, 50:70] = True
    region = region_around(mask)
    assert region.side == pytest.approx(1.25 * 30)
    smooth = np.add.outer(np.arange(90.0), 0.5 * np.arange(120.0))[..., None]
    there = region.crop(smooth, 64, 64)
    back = region.paste(there[..., 0], mask.shape)
    # Bilinear both ways: a plane stays a plane, but for what a byte's fraction costs.
    assert np.abs(back - smooth[..., 0])[mask].max() < 0.1
    assert region_around(np.zeros((9, 9), dtype=bool)) is None


def test_a_region_may_reach_over_the_edge():
    region = Region(-10.0, -10.0, 40.0)
    inside = region.paste(np.ones((20, 20)), (25, 25))
    assert (inside[:25, :25] > 0.9).all()
    assert region.crop(np.ones((25, 25, 3)), 20, 20).shape == (20, 20, 3)


# --- the neural one


@pytest.mark.render
@pytest.mark.parametrize("with_colour", [True, False])
def test_the_network_finds_the_person_and_not_the_room(render_person, with_colour):
    pytest.importorskip("ai_edge_litert")
    frame = render_person("f_avg")
    segmenter = NeuralSegmenter(SHIPPED, frame.config, with_colour=with_colour)
    mask = segmenter.segment(picture_of(frame))
    # The back's last pixels are the person's outline, of which the network is unsure.
    assert (mask & frame.back).sum() / frame.back.sum() > 0.95
    # Of a picture of 200,000 pixels the person has 20,000.
    assert mask.sum() < 30000
    if with_colour:
        assert not (mask & ~skin_mask(frame.colour, frame.config)).any()


def test_without_its_runtime_the_neural_one_says_what_to_install(frame, monkeypatch):
    real = builtins.__import__

    def missing(name, *args, **kwargs):
        if name.startswith(("ai_edge_litert", "onnxruntime")):
            raise ModuleNotFoundError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(SegmenterError, match=r"pip install 'bath-drake\[neural\]'"):
        NeuralSegmenter(SHIPPED, frame.config)
    with pytest.raises(SegmenterError, match=r"pip install 'bath-drake\[onnx\]'"):
        OnnxSegmenter(SHIPPED, frame.config)


@pytest.mark.parametrize("content", [b"", b"no network", b"\x1c\x00\x00\x00TFL3" * 9])
def test_a_file_that_is_no_network_is_refused(tmp_path, frame, content):
    pytest.importorskip("ai_edge_litert")
    path = tmp_path / "a.tflite"
    path.write_bytes(content)
    with pytest.raises(SegmenterError, match=r"a\.tflite: no TensorFlow Lite model"):
        NeuralSegmenter(path, frame.config)
    with pytest.raises(SegmenterError, match="missing"):
        NeuralSegmenter(tmp_path / "b.tflite", frame.config)


# --- one's own


def write_red_network(path, *, first=True, channels=3, size=32, logits=False, kind="x"):
    """A network whose mask is the red channel, as ONNX."""
    onnx = pytest.importorskip("onnx")
    from onnx import TensorProto, helper

    shape = [1, channels, size, size] if first else [1, size, size, channels]
    axis = 1 if first else 3
    taken = helper.make_tensor_value_info("picture", TensorProto.FLOAT, shape)
    out_shape = list(shape)
    out_shape[axis] = 1
    given = helper.make_tensor_value_info("mask", TensorProto.FLOAT, out_shape)
    ints = {
        "starts": [channels - 1 if kind == "depth" else 0],
        "ends": [channels if kind == "depth" else 1],
        "axes": [axis],
    }
    constants = [
        helper.make_tensor(name, TensorProto.INT64, [1], values)
        for name, values in ints.items()
    ]
    nodes = [helper.make_node("Slice", ["picture", *ints], ["red"])]
    if logits:  # 0.5 is at zero, steep enough to leave 0 to 1
        constants += [
            helper.make_tensor("half", TensorProto.FLOAT, [1], [0.5]),
            helper.make_tensor("steep", TensorProto.FLOAT, [1], [100.0]),
        ]
        nodes += [
            helper.make_node("Sub", ["red", "half"], ["shifted"]),
            helper.make_node("Mul", ["shifted", "steep"], ["mask"]),
        ]
    else:
        nodes.append(helper.make_node("Identity", ["red"], ["mask"]))
    graph = helper.make_graph(nodes, "red", [taken], [given], constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)])
    model.ir_version = 8
    onnx.save(model, str(path))


@pytest.mark.parametrize("first", [True, False])
@pytest.mark.parametrize("logits", [True, False])
@pytest.mark.parametrize("channels", [3, 4])
def test_ones_own_network_gives_its_mask(tmp_path, frame, first, logits, channels):
    pytest.importorskip("onnxruntime")
    path = tmp_path / "red.onnx"
    write_red_network(path, first=first, logits=logits, channels=channels, size=256)
    mask = OnnxSegmenter(path, frame.config).segment(picture_of(frame))
    # Skin's red is 200 of 255, the trunks' 40; the wall's 200 is beside the square.
    inner = np.zeros_like(mask)
    inner[150:260, 215:290] = True
    assert mask[inner & frame.back].all()
    trunks = (frame.colour == (40, 50, 110)).all(axis=2)
    assert mask[trunks].mean() < 0.1  # but for the rim, scaled down and up again


def test_the_fourth_channel_is_depth_in_metres(tmp_path, frame):
    pytest.importorskip("onnxruntime")
    path = tmp_path / "depth.onnx"
    write_red_network(path, channels=4, size=64, kind="depth", logits=True)
    frame.depth[200:210] = np.nan  # unknown is zero, not a number that spreads
    mask = OnnxSegmenter(path, frame.config).segment(picture_of(frame))
    assert mask[150:190, 230:280].all()


def test_of_a_person_the_colour_tells_what_is_skin(tmp_path, frame):
    pytest.importorskip("onnxruntime")
    path = tmp_path / "red.onnx"
    write_red_network(path)
    whole = OnnxSegmenter(path, frame.config).segment(picture_of(frame))
    skin = OnnxSegmenter(path, frame.config, mask="person").segment(picture_of(frame))
    np.testing.assert_array_equal(skin, whole & skin_mask(frame.colour, frame.config))
    with pytest.raises(SegmenterError, match="mask: found 'hair', allowed: skin"):
        OnnxSegmenter(path, frame.config, mask="hair")


def test_a_network_of_other_inputs_is_refused_by_file_and_shape(tmp_path, frame):
    pytest.importorskip("onnxruntime")
    path = tmp_path / "grey.onnx"
    write_red_network(path, channels=1)
    with pytest.raises(
        SegmenterError, match=r"grey.onnx: found input \[1, 1, 32, 32\]"
    ):
        OnnxSegmenter(path, frame.config)
    path.write_bytes(b"no network")
    with pytest.raises(SegmenterError, match=r"grey\.onnx: no ONNX model"):
        OnnxSegmenter(path, frame.config)
    with pytest.raises(SegmenterError, match="missing"):
        OnnxSegmenter(tmp_path / "none.onnx", frame.config)


def write_network(path, nodes, taken, given, constants=()):
    """Any network, as ONNX: names and shapes of floats go in and come out."""
    onnx = pytest.importorskip("onnx")
    from onnx import TensorProto, helper

    def floats(values):
        return [
            helper.make_tensor_value_info(name, TensorProto.FLOAT, shape)
            for name, shape in values.items()
        ]

    made = [
        helper.make_node(kind, ins, outs, **more) for kind, ins, outs, more in nodes
    ]
    graph = helper.make_graph(made, "net", floats(taken), floats(given), constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)])
    model.ir_version = 8
    onnx.save(model, str(path))


MEAN = ("ReduceMean", ["x"], ["y"], {"axes": [1], "keepdims": 1})


@pytest.mark.parametrize("taken", [[2, 3, 32, 32], [1, 3, 0, 0], [3, 32, 32]])
def test_a_network_of_another_shape_is_refused_when_it_is_loaded(
    tmp_path, frame, taken
):
    pytest.importorskip("onnxruntime")
    path = tmp_path / "odd.onnx"
    write_network(path, [MEAN], {"x": taken}, {"y": [taken[0], 1, *taken[2:]]})
    found = re.escape(f"odd.onnx: found input {taken} tensor(float)")
    with pytest.raises(SegmenterError, match=found):
        OnnxSegmenter(path, frame.config)


def test_a_network_without_any_input_is_refused(tmp_path, frame):
    pytest.importorskip("onnxruntime")
    onnx = pytest.importorskip("onnx")
    path = tmp_path / "constant.onnx"
    value = onnx.helper.make_tensor(
        "c", onnx.TensorProto.FLOAT, [1, 1, 2, 2], [0.0] * 4
    )
    constant = ("Constant", [], ["y"], {"value": value})
    write_network(path, [constant], {}, {"y": [1, 1, 2, 2]})
    with pytest.raises(SegmenterError, match=r"constant\.onnx: found input none"):
        OnnxSegmenter(path, frame.config)


@pytest.mark.parametrize("batch", [1, "n"])
def test_open_sizes_are_filled_in(tmp_path, frame, batch):
    pytest.importorskip("onnxruntime")
    path = tmp_path / "open.onnx"
    taken, given = [batch, 3, "h", "w"], [batch, 1, "h", "w"]
    write_network(path, [MEAN], {"x": taken}, {"y": given})
    mask = OnnxSegmenter(path, frame.config).segment(picture_of(frame))
    assert mask.shape == frame.back.shape


def test_a_network_that_fails_on_a_picture_is_named(tmp_path, frame):
    pytest.importorskip("onnxruntime")
    onnx = pytest.importorskip("onnx")
    path = tmp_path / "fails.onnx"
    # Of a fixed size within, though its input is said to be open.
    size = onnx.helper.make_tensor("s", onnx.TensorProto.INT64, [4], [1, 1, 64, 64])
    nodes = [
        ("ReduceMean", ["x"], ["m"], {"axes": [1], "keepdims": 1}),
        ("Reshape", ["m", "s"], ["y"], {}),
    ]
    write_network(path, nodes, {"x": [1, 3, "h", "w"]}, {"y": [1, 1, 64, 64]}, [size])
    segmenter = OnnxSegmenter(path, frame.config)
    with pytest.raises(SegmenterError, match=r"fails\.onnx: does not run on input"):
        segmenter.segment(picture_of(frame))


@pytest.mark.parametrize("name", ["classic", "neural", "neural_any_light"])
def test_a_scenario_chooses_by_name(name):
    if name != "classic":
        pytest.importorskip("ai_edge_litert")
    segmenter = make_segmenter(Scenario(perception=PerceptionConfig(segmenter=name)))
    kind = ClassicSegmenter if name == "classic" else NeuralSegmenter
    assert isinstance(segmenter, kind)
