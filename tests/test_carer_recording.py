"""A filmed carer: what the folder's images show is what its truth says."""

import json

import cv2
import numpy as np
import pytest
from made_up_skill import composed_skill

from bath_drake import cli
from bath_drake.carer_recording import SEEN, record_carer
from bath_drake.demonstrations.rgbd.writer import RgbdWriter
from bath_drake.diagrams import build_reproduction
from bath_drake.diagrams.recording import build_recording
from bath_drake.errors import ScenarioError
from bath_drake.scenario import load_scenario

FRAMES = 7


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """The folder of a short recording in which the hand hides the marker at last."""
    folder = tmp_path_factory.mktemp("filmed")
    scenario = load_scenario("demonstration")
    scenario.perception.camera_rate = 5.0
    scenario.duration = (FRAMES - 1) / 5.0
    # A quarter of the period is at the last frame but one: the hand is above then.
    scenario.scene.carer.swing, scenario.scene.carer.swing_period = 2.2, 4.0
    camera = scenario.scene.camera.pinhole()
    record_carer(RgbdWriter(folder, camera, np.eye(4)), scenario)
    return folder


@pytest.fixture(scope="module")
def truth(filmed):
    with np.load(filmed / "truth.npz", allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}


def images(folder, frame):
    colour = cv2.imread(str(folder / f"color/{frame:06d}.png"))[..., ::-1]
    depth = cv2.imread(str(folder / f"depth/{frame:06d}.png"), cv2.IMREAD_UNCHANGED)
    return colour.astype(int), depth


def marker_place(folder, truth, frame):
    """The marker's centre in C, m, and its pixel (column, row), as the files say."""
    numbers = json.loads((folder / "intrinsics.json").read_text())
    X_CW = np.linalg.inv(truth["X_WC"])
    p_C = X_CW[:3, :3] @ truth["p_W"][frame] + X_CW[:3, 3]
    column = numbers["fx"] * p_C[0] / p_C[2] + numbers["cx"]
    row = numbers["fy"] * p_C[1] / p_C[2] + numbers["cy"]
    return p_C, np.round([column, row]).astype(int)


def green(colour):
    return colour[..., 1] - np.maximum(colour[..., 0], colour[..., 2]) > 60


@pytest.mark.render
def test_the_folder_is_laid_out_as_agreed(filmed):
    rows = (filmed / "timestamps.csv").read_text().splitlines()
    assert rows[0] == "frame,t_s"
    stems = [row.split(",")[0] for row in rows[1:]]
    times = [float(row.split(",")[1]) for row in rows[1:]]
    assert stems == [f"{k:06d}" for k in range(FRAMES)]
    np.testing.assert_allclose(times, np.arange(FRAMES) / 5.0, atol=1e-6)
    for kind in ("color", "depth"):
        assert sorted(p.stem for p in (filmed / kind).iterdir()) == stems
    colour, depth = images(filmed, 0)
    assert colour.shape == (424, 512, 3)
    assert depth.dtype == np.uint16
    assert depth.shape == (424, 512)


@pytest.mark.render
def test_the_marker_is_green_where_the_truth_sees_it(filmed, truth):
    visible = truth["marker_visible"]
    assert visible[0] > 0.9
    assert visible.min() < SEEN  # else half of this test were empty
    for frame in range(FRAMES):
        colour, _ = images(filmed, frame)
        _, (column, row) = marker_place(filmed, truth, frame)
        if visible[frame] > 0.9:
            assert green(colour)[row, column]
        around = np.hypot(*np.ogrid[-row : 424 - row, -column : 512 - column]) < 8
        # Nothing else in the room is as green as that.
        assert not green(colour)[~around].any()


@pytest.mark.render
def test_the_markers_depth_is_that_of_its_front(filmed, truth):
    for frame in np.flatnonzero(truth["marker_visible"] > 0.9):
        _, depth = images(filmed, frame)
        p_C, (column, row) = marker_place(filmed, truth, frame)
        front = p_C[2] - truth["marker_radius"] * p_C[2] / np.linalg.norm(p_C)
        seen = depth[row - 1 : row + 2, column - 1 : column + 2] / 1000.0
        # Noise of 1.4 mm, and half a pixel beside the ball's nearest point.
        assert abs(np.median(seen) - front) < 0.004


@pytest.mark.render
def test_the_truth_goes_together(truth):
    frames = {len(truth[name]) for name in ("t", "p_N", "p_W", "X_WM", "phase")}
    assert frames == {FRAMES}
    scenario = load_scenario("demonstration")
    film = build_recording(scenario)
    for t, p_N, p_W, X_WM in zip(
        *(truth[name] for name in ("t", "p_N", "p_W", "X_WM")), strict=True
    ):
        p_M = np.linalg.inv(X_WM) @ np.append(p_W, 1.0)
        distance, nearest, _ = film.skin.nearest(p_M[None, :3])
        # The ball touches the skin; its direction is a smoothed normal.
        assert distance[0] == pytest.approx(truth["marker_radius"], abs=0.001)
        seen = film.skin.canonical_map.canonical_from_world(nearest[0])
        assert np.linalg.norm(seen - p_N) < 0.02
        np.testing.assert_allclose(film.stroke.at(np.array([t]))[0], p_N, atol=1e-3)


@pytest.mark.render
def test_the_command_films_and_says_what_it_wrote(tmp_path, capsys):
    words = "simulate demonstration --person f_thin --seconds 0.1 --record".split()
    assert cli.main([*words, str(tmp_path / "film")]) == 0
    out = capsys.readouterr().out
    assert f"recorded: {tmp_path / 'film'} (2 frames, 0.1 s" in out
    assert "marker:   to be seen in 2 of 2 frames" in out
    with np.load(tmp_path / "film" / "truth.npz", allow_pickle=False) as archive:
        assert archive["person"] == "thin woman"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "give --record FOLDER"),
        (("--record", "film", "--out", "run"), "--out has no meaning"),
        (("--record", "film", "--skill", "s.yaml"), "--skill has no meaning"),
        (("--record", "/dev/null"), "not a folder to record into"),
        (("--record", "film", "--person", "nobody"), "no such folder"),
    ],
)
def test_what_cannot_be_filmed_is_told_on_one_line(
    tmp_path, monkeypatch, capsys, words, message
):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["simulate", "demonstration", *words]) == cli.BAD_INPUT
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_stroke_off_the_back_leaves_no_folder_behind(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wild.yaml").write_text(
        "scene: {carer: {waypoints: [[0, 0], [1, -1]]}}\n"
    )
    assert cli.main(["simulate", "wild.yaml", "--record", "film"]) == cli.BAD_INPUT
    assert "leaves the back" in capsys.readouterr().err
    assert not (tmp_path / "film").exists()


def test_there_is_no_robot_beside_a_carer_and_no_film_without_one():
    with pytest.raises(ValueError, match="no robot"):
        build_reproduction(load_scenario("demonstration"), composed_skill())
    with pytest.raises(ScenarioError, match=r"scene\.carer: is missing"):
        build_recording(load_scenario("reproduction"))
