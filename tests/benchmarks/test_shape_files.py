import numpy as np
import pytest
from scipy.io import savemat

from bath_drake.benchmarks.shape_files import lasa_shapes, stroke_shapes
from bath_drake.errors import BathDrakeError
from bath_drake.resources import models_folder

STROKE_FOLDER = models_folder() / "demonstrations" / "strokes"


def demo(shift=0.0, **other):
    share = np.linspace(0.0, 1.0, 40)
    pos = np.stack([50.0 * share - 50.0, 10.0 * np.sin(3.0 * share) + shift])
    return {
        "pos": pos,
        "t": 2.0 * share[None],
        "vel": np.gradient(pos, axis=1),
        **other,
    }


def write(path, *demos):
    cells = np.empty((1, len(demos)), dtype=object)
    cells[0, :] = demos
    savemat(path, {"demos": cells, "dt": 0.05})


def test_lasa_files_are_read_in_the_order_of_their_names(tmp_path):
    write(tmp_path / "heee.mat", demo(), demo(1.0), demo(2.0))
    write(tmp_path / "Angle.mat", demo(), demo(1.0))
    shapes = lasa_shapes(tmp_path)
    assert [shape.name for shape in shapes] == ["Angle", "heee"]
    assert [len(shape.demonstrations) for shape in shapes] == [2, 3]
    first = shapes[0].demonstrations[0]
    assert first.points.shape == (40, 2)
    assert first.points[0, 0] == pytest.approx(-1.0)
    assert first.times[-1] == pytest.approx(2.0)
    (chosen,) = lasa_shapes(tmp_path, ["heee"])
    assert chosen.name == "heee"


def test_without_a_folder_the_message_says_what_is_needed():
    with pytest.raises(BathDrakeError, match=r"lasa: --data DIR is needed: .*ds-opt"):
        lasa_shapes(None)


def test_a_folder_without_such_files_is_refused(tmp_path):
    with pytest.raises(BathDrakeError, match=r"--data: no \.mat file in "):
        lasa_shapes(tmp_path)


def test_a_shape_that_is_not_there_is_refused(tmp_path):
    write(tmp_path / "Angle.mat", demo(), demo(1.0))
    with pytest.raises(BathDrakeError, match=r"found 'Line', allowed: Angle$"):
        lasa_shapes(tmp_path, ["Line"])


@pytest.mark.parametrize("content", [b"", b"no matlab file\n" * 20, b"\x00" * 300])
def test_what_is_no_matlab_file_is_refused(tmp_path, content):
    (tmp_path / "Angle.mat").write_bytes(content)
    with pytest.raises(BathDrakeError, match=r"Angle\.mat: no (MATLAB|variable)"):
        lasa_shapes(tmp_path)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"t": np.zeros((1, 3))}, r"demos\{2\}: pos has shape \(2, 40\) and t \(3,\)"),
        ({"pos": np.full((2, 40), np.nan)}, "a number is not finite"),
        ({"pos": np.ones((2, 40))}, "all points are one"),
        ({"t": -np.arange(40.0)[None]}, "t decreases"),
        ({"pos": "no numbers"}, "expected a struct with numbers"),
    ],
)
def test_a_demonstration_of_another_kind_is_refused(tmp_path, wrong, message):
    write(tmp_path / "Angle.mat", demo(), demo(**wrong))
    with pytest.raises(BathDrakeError, match=message):
        lasa_shapes(tmp_path)


def test_a_file_without_demonstrations_is_refused(tmp_path):
    savemat(tmp_path / "Angle.mat", {"other": 1.0})
    with pytest.raises(BathDrakeError, match="no variable demos"):
        lasa_shapes(tmp_path)
    savemat(tmp_path / "Angle.mat", {"demos": 1.0})
    with pytest.raises(BathDrakeError, match="expected a struct"):
        lasa_shapes(tmp_path)
    write(tmp_path / "Angle.mat", demo())
    with pytest.raises(BathDrakeError, match="1 demonstrations, at least 2"):
        lasa_shapes(tmp_path)


def test_strokes_are_chosen_by_name():
    (shape,) = stroke_shapes(STROKE_FOLDER, ["w"])
    assert shape.name == "w"
    with pytest.raises(BathDrakeError, match=r"--shapes: found 'v', allowed: arc_half"):
        stroke_shapes(STROKE_FOLDER, ["v"])
