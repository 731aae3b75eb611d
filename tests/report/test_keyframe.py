import numpy as np
import pytest

from bath_drake.report.keyframe import Keyframe
from bath_drake.report.run_data import load_run


@pytest.fixture(scope="module")
def frame(run_folder) -> Keyframe:
    return load_run(run_folder).keyframes[1]


def test_a_draped_point_keeps_its_canonical_place(frame):
    p_N = np.random.default_rng(3).uniform(-0.4, 0.4, (40, 2))
    _, p_W = frame.on_skin(p_N)
    # Projection onto the plane is linear, so interpolation does not move it.
    np.testing.assert_allclose(
        frame.canonical_map.canonical_from_world(p_W), p_N, atol=1e-9
    )


def test_a_draped_point_is_where_the_camera_sees_it(frame):
    p_N = np.random.default_rng(4).uniform(-0.4, 0.4, (40, 2))
    p_I, p_W = frame.on_skin(p_N)
    X_WC = frame.log.X_WC
    seen = frame.camera.project((p_W - X_WC[:3, 3]) @ X_WC[:3, :3])
    # Between pixels both are interpolated, but perspective is not linear.
    np.testing.assert_allclose(p_I, seen, atol=0.02)


def test_points_off_the_back_have_no_place(frame):
    p_I, p_W = frame.on_skin(np.array([[5.0, 0.0], [0.0, -7.0]]))
    assert np.isnan(p_I).all()
    assert np.isnan(p_W).all()


def test_normals_face_the_camera(frame):
    known = np.linalg.norm(frame.normals_W, axis=2) > 0.5
    assert known[frame.mask].mean() > 0.9
    to_camera = frame.log.X_WC[:3, 3] - frame.points_W[known]
    assert ((frame.normals_W[known] * to_camera).sum(axis=1) > 0.0).all()
