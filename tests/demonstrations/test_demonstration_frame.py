import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bath_drake.demonstrations.canonical import CanonicalDemonstration, CanonicalFrame
from bath_drake.demonstrations.processing import planar_frame, plane_frame

COORDINATES = st.floats(-2.0, 2.0)
POINTS_N = arrays(np.float64, (7, 2), elements=COORDINATES)


@st.composite
def frames(draw):
    kind = draw(st.sampled_from(["body_box", "path_plane", "planar"]))
    dimension = 2 if kind == "planar" else 3
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    axes = np.linalg.qr(rng.normal(size=(dimension, dimension)))[0][:2]
    origin, scales = rng.normal(size=dimension), rng.uniform(0.05, 2.0, 2)
    return CanonicalFrame(kind, origin, axes, scales)


@settings(deadline=None)
@given(frames(), POINTS_N)
def test_a_canonical_point_goes_out_and_comes_back(frame, points):
    back = frame.to_canonical(frame.to_demonstration(points))
    # Coordinates of a few metres divided by scales of 0.05: 100 ulps of 100.
    np.testing.assert_allclose(back, points, atol=1e-12)


@settings(deadline=None)
@given(frames(), POINTS_N, st.floats(-1.0, 1.0))
def test_what_is_off_the_plane_is_projected_orthogonally(frame, points, height):
    out = frame.to_demonstration(points)
    normal = np.zeros(frame.dimension)
    if frame.dimension == 3:
        normal = np.cross(*frame.axes)
    lifted = out + height * normal
    np.testing.assert_allclose(frame.to_canonical(lifted), points, atol=1e-12)


def test_a_body_box_maps_its_corners_to_the_unit_square():
    frame = CanonicalFrame(
        "body_box",
        np.array([0.1, 0.2, 0.3]),
        np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        np.array([0.2, 0.25]),
    )
    corner = np.array([0.1, 0.4, 0.55])
    np.testing.assert_allclose(frame.to_canonical(corner), [1.0, 1.0], rtol=1e-15)


@pytest.mark.parametrize(
    ("kind", "origin", "axes", "scales", "message"),
    [
        ("box", np.zeros(2), np.eye(2), np.ones(2), "kind must be one of"),
        ("planar", np.zeros(3), np.eye(2), np.ones(2), r"origin .* shape \(3,\)"),
        ("planar", np.zeros(2), np.eye(3)[:2], np.ones(2), "axes .* shape"),
        ("body_box", np.zeros(3), np.eye(2), np.ones(2), "axes .* shape"),
        ("planar", np.zeros(2), np.eye(2), np.ones(1), "scales .* shape"),
        (
            "planar",
            np.array([0, np.nan]),
            np.eye(2),
            np.ones(2),
            "origin must be finite",
        ),
        ("planar", np.zeros(2), np.ones((2, 2)), np.ones(2), "orthonormal"),
        (
            "planar",
            np.zeros(2),
            np.eye(2),
            np.array([1.0, 0.0]),
            "scales must be positive",
        ),
    ],
)
def test_a_frame_that_is_none_is_refused(kind, origin, axes, scales, message):
    with pytest.raises(ValueError, match=message):
        CanonicalFrame(kind, origin, axes, scales)


def test_a_frame_keeps_its_own_arrays_and_compares_by_value():
    origin = np.zeros(2)
    frame = CanonicalFrame("planar", origin, np.eye(2), np.ones(2))
    origin[0] = 5.0
    assert frame == CanonicalFrame("planar", np.zeros(2), np.eye(2), np.ones(2))
    assert frame != CanonicalFrame("planar", np.ones(2), np.eye(2), np.ones(2))
    with pytest.raises(ValueError, match="read-only"):
        frame.scales[0] = 2.0


# A path with two clearly different extents: the principal axes of a round one
# are anybody's choice.
@st.composite
def paths(draw):
    s = np.linspace(0.0, 1.0, 50)
    a, b, c = (
        draw(st.floats(low, high)) for low, high in [(0.5, 1), (0.1, 0.2), (1, 3)]
    )
    return np.stack([a * s, b * np.sin(2 * np.pi * c * s), 0.0 * s], axis=-1)


@settings(deadline=None)
@given(paths(), st.integers(0, 2**32 - 1))
def test_a_path_in_space_spans_eight_tenths_of_its_plane_centred(path, seed):
    rng = np.random.default_rng(seed)
    turned = path @ np.linalg.qr(rng.normal(size=(3, 3)))[0].T + rng.normal(size=3)
    frame = plane_frame(turned)
    mapped = frame.to_canonical(turned)
    low, high = mapped.min(axis=0), mapped.max(axis=0)
    np.testing.assert_allclose(low + high, 0.0, atol=1e-12)
    assert np.max(high - low) == pytest.approx(1.6, abs=1e-12)
    assert frame.scales[0] == frame.scales[1]
    # A planar path lies in its best plane: nothing is lost on the way.
    np.testing.assert_allclose(frame.to_demonstration(mapped), turned, atol=1e-12)


@settings(deadline=None)
@given(paths(), st.integers(0, 2**32 - 1))
def test_the_plane_of_a_path_does_not_depend_on_its_direction(path, seed):
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    there, back = plane_frame(path @ turn.T), plane_frame((path @ turn.T)[::-1])
    # The sums over the points are taken in another order: a few ulps.
    np.testing.assert_allclose(there.axes, back.axes, atol=1e-9)
    np.testing.assert_allclose(there.origin, back.origin, atol=1e-12)


@settings(deadline=None)
@given(paths())
def test_a_planar_path_is_scaled_and_centred_but_not_turned(path):
    frame = planar_frame(path[:, :2])
    np.testing.assert_array_equal(frame.axes, np.eye(2))
    mapped = frame.to_canonical(path[:, :2])
    np.testing.assert_allclose(mapped.min(axis=0) + mapped.max(axis=0), 0.0, atol=1e-12)
    assert np.max(np.ptp(mapped, axis=0)) == pytest.approx(1.6, abs=1e-12)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"times": np.arange(4.0)}, r"\(T,\) and \(T, 2\)"),
        ({"points": np.zeros((3, 3))}, r"\(T,\) and \(T, 2\)"),
        ({"points": np.full((3, 2), np.nan)}, "points .* must be finite"),
        ({"raw": np.zeros(3)}, r"raw \(n, 2\)"),
        ({"goal_offset": np.zeros(3)}, "goal_offset has shape"),
    ],
)
def test_a_demonstration_of_wrong_shape_is_refused(changed, message):
    arrays = {
        "times": np.arange(3.0),
        "points": np.zeros((3, 2)),
        "raw": np.zeros((5, 2)),
    }
    with pytest.raises(ValueError, match=message):
        CanonicalDemonstration(name="a", sha256="", **(arrays | changed))
