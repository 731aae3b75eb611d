from types import SimpleNamespace

import numpy as np
import pytest
from pydrake.geometry import Meshcat

from bath_drake.errors import RunFolderError
from bath_drake.meshcat.view import (
    ROOT,
    Overlay,
    draw_overlays,
    normal_lines,
    overlays_of_run,
    record_overlays,
    split_at_gaps,
    square,
    tubes,
    write_static_page,
)

LINE = np.column_stack([np.linspace(0, 1, 9), np.linspace(0, 1, 9) ** 2, np.zeros(9)])


@pytest.fixture(scope="module")
def meshcat():
    return Meshcat()


@pytest.fixture(scope="module")
def evaluation():
    return SimpleNamespace(
        washed_points_M=LINE, normals_M=np.tile([0.0, 0.0, 1.0], (len(LINE), 1))
    )


@pytest.fixture(scope="module")
def log():
    """A person who moves 1 m in 1 s; no key frames."""
    time = np.linspace(0.0, 1.0, 11)
    pose = np.zeros((11, 7))
    pose[:, 0], pose[:, 4] = 1.0, time
    nozzle = pose.copy()
    nozzle[:, 5] = 1.0
    return SimpleNamespace(
        time=time,
        phase=np.full(11, 2.0),
        stage=np.zeros(11),
        body_pose=pose,
        nozzle_pose=nozzle,
        keyframe_time=np.empty(0),
        X_WC=np.eye(4),
    )


def test_a_tube_keeps_its_radius_from_the_line():
    line = np.column_stack([np.linspace(0, 1, 5), np.zeros(5), np.zeros(5)])
    vertices, _ = tubes([line], 0.1)
    np.testing.assert_allclose(np.linalg.norm(vertices[:, 1:], axis=1), 0.1, rtol=1e-12)


def test_tubes_are_closed_and_face_outwards():
    vertices, triangles = tubes([LINE, LINE + 3.0], 0.05)
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    # In a closed surface each edge is passed once in each direction.
    assert sorted(map(tuple, edges)) == sorted(map(tuple, edges[:, ::-1]))
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    assert (np.cross(a, b) * c).sum() > 0.0  # six times the volume inside


def test_a_line_is_cut_where_points_are_missing():
    line = LINE.copy()
    line[[3, 5]] = np.nan
    pieces = split_at_gaps(line)
    assert [len(piece) for piece in pieces] == [3, 3]  # the lone point 4 is no line
    assert all(np.isfinite(piece).all() for piece in pieces)


def test_the_square_is_closed_and_lies_on_the_rim():
    outline = square(10)
    np.testing.assert_array_equal(outline[0], outline[-1])
    np.testing.assert_allclose(np.abs(outline).max(axis=1), 1.0)


def test_normals_stand_on_the_path(evaluation):
    lines = normal_lines(evaluation)
    assert len(lines) > 5
    for base, tip in lines:
        assert np.linalg.norm(LINE - base, axis=1).min() == 0.0
        np.testing.assert_allclose((tip - base) / np.linalg.norm(tip - base), [0, 0, 1])


def test_a_run_that_never_washed_has_no_path(log):
    nothing = SimpleNamespace(
        washed_points_M=np.empty((0, 3)), normals_M=np.empty((0, 3))
    )
    assert overlays_of_run(log, nothing, SimpleNamespace()) == []


def test_drawing_replaces_what_was_there(meshcat):
    draw_overlays(meshcat, [Overlay("old", (LINE,), "#ff0000", 0.01)])
    assert meshcat.HasPath(f"{ROOT}/old")
    draw_overlays(meshcat, [Overlay("new", (LINE,), "#ff0000", 0.01)])
    assert meshcat.HasPath(f"{ROOT}/new")
    assert not meshcat.HasPath(f"{ROOT}/old")


class _Recorder:
    """A Meshcat that notes the poses written into its recording."""

    def __init__(self, meshcat, frames_per_second):
        self._meshcat, self._rate = meshcat, frames_per_second
        self.poses = {}

    def __getattr__(self, name):
        return getattr(self._meshcat, name)

    def get_mutable_recording(self):
        return self

    def frame(self, time):
        return int(time * self._rate)

    def SetTransform(self, *arguments):  # the animation's has three arguments
        if len(arguments) == 3:
            frame, path, X_WM = arguments
            assert path == ROOT
            self.poses[frame / self._rate] = X_WM.translation()


def test_recorded_overlays_move_with_the_person(meshcat, log, evaluation):
    recorder = _Recorder(meshcat, 64.0)
    record_overlays(recorder, log, evaluation, SimpleNamespace())
    assert len(recorder.poses) >= 10  # a second, at 10 Hz or more
    for time, place in recorder.poses.items():
        # Frames round down by 1/64 s, poses to the nearest sample of every 0.1 s.
        assert place[0] == pytest.approx(time, abs=0.05 + 1.0 / 64.0 + 1e-9)


def test_the_page_loads_nothing(meshcat, log, evaluation, tmp_path):
    path = tmp_path / "meshcat.html"
    write_static_page(meshcat, path)
    text = path.read_text()
    assert 'src="http' not in text
    assert "MeshCat" in text or "meshcat" in text


def test_a_page_that_cannot_be_written_is_named(meshcat, tmp_path):
    with pytest.raises(RunFolderError, match="none"):
        write_static_page(meshcat, tmp_path / "none" / "meshcat.html")
