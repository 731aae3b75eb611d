import json
import shutil

import cv2
import numpy as np
import pytest

from bath_drake.demonstrations.rgbd.folder import open_rgbd
from bath_drake.demonstrations.rgbd.writer import RgbdWriter
from bath_drake.errors import DemonstrationError
from bath_drake.perception.camera import PinholeCamera

CAMERA = PinholeCamera(24, 16, 20.0, 21.0, 12.25, 8.0)
COUNT = 4
POSE = np.array([[1.0, 0, 0, 0.1], [0, 0, 1, 0.2], [0, -1, 0, 1.5], [0, 0, 0, 1]])


def images(k):
    colour = np.full((*CAMERA.shape, 3), (200, 30, 10 * k), dtype=np.uint8)
    depth = np.full(CAMERA.shape, 1.0 + 0.1 * k, dtype=np.float32)
    depth[0, 0] = np.inf
    return colour, depth


@pytest.fixture
def folder(tmp_path):
    """A recording of four frames, as the simulated camera writes it."""
    writer = RgbdWriter(tmp_path / "bath", CAMERA, POSE)
    for k in range(COUNT):
        writer.write(0.1 * k, *images(k))
    return writer.folder


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def rewrite_intrinsics(folder, **changes):
    numbers = json.loads((folder / "intrinsics.json").read_text())
    numbers |= changes
    kept = {key: value for key, value in numbers.items() if value is not None}
    (folder / "intrinsics.json").write_text(json.dumps(kept))


def turned_into_tum(folder, offset=0.004):
    """The folder with TUM's two lists in place of timestamps.csv."""
    (folder / "color").rename(folder / "rgb")
    (folder / "timestamps.csv").unlink()
    for kind, shift in (("rgb", 0.0), ("depth", offset)):
        rows = [f"{5 + 0.1 * k + shift:.6f} {kind}/{k:06d}.png" for k in range(COUNT)]
        text = "# a comment\n" + "\n".join(rows) + "\n"
        (folder / f"{kind}.txt").write_text(text)
    rewrite_intrinsics(folder, depth_scale=1000)


def test_what_the_simulated_camera_writes_is_read_back(folder):
    recording = open_rgbd(folder)
    assert vars(recording.camera) == vars(CAMERA)
    np.testing.assert_array_equal(recording.X_WC, POSE)
    frames = list(recording)
    assert [frame.t for frame in frames] == [0.0, 0.1, 0.2, 0.3]
    for k, frame in enumerate(frames):
        colour, depth = images(k)
        np.testing.assert_array_equal(frame.colour, colour)
        assert frame.depth[0, 0] == 0.0
        # Whole millimetres, which these depths are but for rounding.
        np.testing.assert_allclose(frame.depth[1:], depth[1:], atol=1e-6)


@pytest.mark.parametrize("name", ["colour", "rgb", "image"])
def test_other_names_of_the_colour_folder_do(folder, name):
    (folder / "color").rename(folder / name)
    assert len(list(open_rgbd(folder))) == COUNT


def test_jpeg_colours_do(folder):
    for path in (folder / "color").glob("*.png"):
        cv2.imwrite(str(path.with_suffix(".jpg")), cv2.imread(str(path)))
        path.unlink()
    colour = open_rgbd(folder).frame(0).colour
    # What JPEG's quantisation changes in an even picture.
    np.testing.assert_allclose(colour, images(0)[0], atol=4)


@pytest.mark.parametrize(
    "numbers",
    [
        {"intrinsic_matrix": [20.0, 0, 0, 0, 21.0, 0, 11.75, 7.5, 1]},
        {"K": [[20.0, 0, 11.75], [0, 21.0, 7.5], [0, 0, 1]]},
        {"K": [20.0, 0, 11.75, 0, 21.0, 7.5, 0, 0, 1]},
        {"camera_matrix": {"data": [20.0, 0, 11.75, 0, 21.0, 7.5, 0, 0, 1]}},
        {"fx": 20, "fy": 21, "ppx": 11.75, "ppy": 7.5, "coeffs": [0, 0, 0, 0, 0]},
    ],
)
def test_intrinsics_are_read_as_common_programs_write_them(folder, numbers):
    bare = dict.fromkeys(("fx", "fy", "cx", "cy", "X_WC"))
    rewrite_intrinsics(folder, **(bare | numbers))
    recording = open_rgbd(folder)
    assert vars(recording.camera) == vars(CAMERA)
    assert recording.X_WC is None


@pytest.mark.parametrize(("scale", "metres"), [(5000, 0.2), (0.001, 1.0), (None, 1.0)])
def test_the_depth_scale_is_steps_a_metre_or_metres_a_step(folder, scale, metres):
    rewrite_intrinsics(folder, depth_scale=scale)
    assert open_rgbd(folder).frame(0).depth[5, 5] == pytest.approx(metres)


@pytest.mark.parametrize(
    "table",
    [
        "index,timestamp\n0,0.0\n1,0.1\n2,0.2\n3,0.3\n",
        "time_ms,frame\n0,000000\n100,000001\n200,000002\n300,000003\n",
        "colour,depth,t\n"
        + "".join(f"color/{k:06d}.png,depth/{k:06d}.png,{k / 10}\n" for k in range(4)),
    ],
)
def test_other_tables_of_times_do(folder, table):
    (folder / "timestamps.csv").write_text(table)
    times = [frame.t for frame in open_rgbd(folder)]
    np.testing.assert_allclose(times, [0.0, 0.1, 0.2, 0.3], atol=1e-12)


def test_tum_lists_are_paired_by_the_nearest_time(folder):
    turned_into_tum(folder)
    frames = list(open_rgbd(folder))
    np.testing.assert_allclose([frame.t for frame in frames], 5 + 0.1 * np.arange(4))
    assert frames[2].depth[5, 5] == pytest.approx(1.2)


def test_tum_images_too_far_apart_belong_to_no_frame(folder):
    turned_into_tum(folder)
    edit(folder / "depth.txt", "5.204", "5.230")
    assert len(open_rgbd(folder)) == COUNT - 1


def test_tum_without_intrinsics_is_told_what_to_write(folder):
    turned_into_tum(folder)
    (folder / "intrinsics.json").unlink()
    with pytest.raises(DemonstrationError, match=r'"fx".*"depth_scale": 5000'):
        open_rgbd(folder)


def test_tum_without_a_depth_scale_is_not_guessed(folder):
    turned_into_tum(folder)
    rewrite_intrinsics(folder, depth_scale=None)
    with pytest.raises(DemonstrationError, match="depth_scale: is missing"):
        open_rgbd(folder)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("000002,0.2", "000002,0.1", "line 4: time 0.1 s does not increase"),
        ("000002,0.2", "000002,0.05", "line 4: time 0.05 s does not increase"),
        ("000002,0.2", "000002,nan", "line 4: found 'nan"),
        ("000002,0.2", "000002", "line 4: found 1 values, expected 2"),
        ("000002,0.2", "000009,0.2", "line 4: no colour image of frame '000009'"),
        ("000002,0.2", "../../x.png,0.2", "line 4: .*inside the folder"),
        ("000002,0.2", "/etc/x.png,0.2", "line 4: .*inside the folder"),
        ("000001,0.100000\n000002,0.200000\n", "", "names 2 of the 4 colour images"),
        ("frame,t_s", "this,that", "line 1: .*header such as frame,t_s"),
        ("frame,t_s", "\x00frame,t_s", "line 1: .*header such as frame,t_s"),
    ],
)
def test_bad_rows_are_named(folder, old, new, message):
    edit(folder / "timestamps.csv", old, new)
    with pytest.raises(DemonstrationError, match=rf"timestamps.csv: {message}"):
        open_rgbd(folder)


@pytest.mark.parametrize("missing", ["color", "depth", "timestamps.csv"])
def test_what_is_missing_is_named(folder, missing):
    path = folder / missing
    shutil.rmtree(path) if path.is_dir() else path.unlink()
    with pytest.raises(DemonstrationError, match=missing):
        open_rgbd(folder)


def test_a_missing_depth_image_is_named_with_its_row(folder):
    (folder / "depth" / "000001.png").unlink()
    with pytest.raises(DemonstrationError, match="line 3: no depth image of frame"):
        open_rgbd(folder)


def test_one_image_that_a_recorder_broke_off_at_is_no_error(folder):
    edit(folder / "timestamps.csv", "000003,0.300000\n", "")
    assert len(open_rgbd(folder)) == COUNT - 1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"fx": None}, "fx: is missing"),
        ({"fx": -3.0}, "fx, fy: found -3"),
        ({"cx": 900.0}, "cx, cy: found 900"),
        ({"width": 10**6, "height": 10**6}, "width, height: found 1000000"),
        ({"width": "24"}, "width: found '24'"),
        ({"depth_scale": 0}, "depth_scale: found 0"),
        ({"K": [1, 2, 3]}, "K: found 3 numbers"),
        ({"K": [20.0, 0.5, 12, 0, 21, 8, 0, 0, 1]}, "K: the pixels are skew"),
        ({"distortion": [0.1, 0, 0, 0, 0]}, "distortion: the images are distorted"),
        ({"X_WC": np.ones((4, 4)).tolist()}, "X_WC: expected a rotation"),
    ],
)
def test_bad_intrinsics_are_named(folder, changes, message):
    rewrite_intrinsics(folder, **changes)
    with pytest.raises(DemonstrationError, match=rf"intrinsics.json: {message}"):
        open_rgbd(folder)


@pytest.mark.parametrize("text", ["", "{", "[1]", '{"fx": NaN}', "[" * 100_000, "\xff"])
def test_intrinsics_that_are_no_mapping_are_refused(folder, text):
    (folder / "intrinsics.json").write_text(text, encoding="latin-1")
    with pytest.raises(DemonstrationError, match=r"intrinsics\.json: "):
        open_rgbd(folder)


@pytest.mark.parametrize("kind", ["color", "depth"])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.95, 0.999])
def test_an_image_cut_off_is_refused(folder, kind, share):
    path = folder / kind / "000001.png"
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    recording = open_rgbd(folder)
    recording.frame(0)
    with pytest.raises(DemonstrationError, match=rf"{kind}/000001\.png: "):
        recording.frame(1)


def test_a_flipped_bit_is_noticed(folder):
    path = folder / "depth" / "000001.png"
    data = bytearray(path.read_bytes())
    data[60] ^= 4
    path.write_bytes(bytes(data))
    with pytest.raises(DemonstrationError, match=r"depth/000001\.png: damaged"):
        open_rgbd(folder).frame(1)


@pytest.mark.parametrize(
    ("image", "message"),
    [
        (np.zeros(CAMERA.shape, np.uint8), "found 8-bit greyscale"),
        (np.zeros((*CAMERA.shape, 3), np.uint16), "found 16-bit colour"),
        (np.zeros((17, 24), np.uint16), "found 24 x 17 pixels, expected 24 x 16"),
        (np.zeros((3000, 3000), np.uint16), "found 3000 x 3000 pixels"),
    ],
)
def test_depth_that_is_no_depth_of_this_camera_is_refused(folder, image, message):
    cv2.imwrite(str(folder / "depth" / "000001.png"), image)
    with pytest.raises(DemonstrationError, match=rf"depth/000001\.png: {message}"):
        open_rgbd(folder).frame(1)


def test_no_folder_is_refused(tmp_path):
    for path in (tmp_path / "none", "a\0b"):
        with pytest.raises(DemonstrationError, match="is not a folder"):
            open_rgbd(path)
