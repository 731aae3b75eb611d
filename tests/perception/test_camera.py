import numpy as np
import pytest

from bath_drake.perception.camera import PinholeCamera


@pytest.fixture
def camera():
    return PinholeCamera()


def test_projection_undoes_deprojection(camera):
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.5, 4.5, camera.shape)
    pixels = camera.project(camera.deproject(depth))
    rows, columns = np.mgrid[: camera.height, : camera.width]
    centres = np.stack([columns + 0.5, rows + 0.5], axis=-1)
    # Rounding of one product and one quotient at 500 pixels.
    np.testing.assert_allclose(pixels, centres, atol=1e-10)


def test_the_axis_meets_the_principal_point(camera):
    np.testing.assert_array_equal(
        camera.project(np.array([0.0, 0.0, 1.0])), [camera.cx, camera.cy]
    )


def test_points_not_in_front_have_no_pixel(camera):
    behind = np.array([[0.1, 0.2, -1.0], [0.1, 0.2, 0.0]])
    assert np.isnan(camera.project(behind)).all()


def test_intrinsics_and_project_agree(camera):
    p_C = np.array([0.2, -0.1, 1.3])
    homogeneous = camera.intrinsics @ p_C
    expected = homogeneous[:2] / homogeneous[2]
    np.testing.assert_allclose(camera.project(p_C), expected, rtol=1e-15)


def test_pixels_that_measured_nothing_stay_so(camera):
    depth = np.full(camera.shape, np.inf)
    assert not np.isfinite(camera.deproject(depth)[..., 2]).any()


def test_an_image_of_another_size_is_refused(camera):
    with pytest.raises(ValueError, match=r"shape \(424, 512\)"):
        camera.deproject(np.ones((10, 10)))


@pytest.mark.parametrize(
    "wrong", [{"width": 0}, {"fx": -1.0}, {"fy": np.nan}, {"cx": np.inf}]
)
def test_impossible_cameras_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        PinholeCamera(**wrong)


@pytest.mark.render
def test_the_floor_seen_by_the_renderer_is_level(render_person):
    frame = render_person("f_thin")
    p_C = frame.camera.deproject(frame.depth)[frame.labels == 1]
    heights = (frame.p_WC + p_C @ frame.R_WC.T)[:, 2]
    # The floor is at zero. 0.1 mm: a half-pixel shift would make it millimetres.
    assert len(heights) > 10_000
    assert np.abs(heights).max() < 1e-4
