"""Each pixel shows the nearest surface along its ray, at its depth, lit as it lies."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from bath_drake.perception.camera import PinholeCamera
from bath_drake.rendering.rasteriser import NOTHING, Light, Rasteriser
from bath_drake.rendering.solids import Shape, box, ellipsoid, faceted
from bath_drake.rendering.surfaces import Surface

CAMERA = PinholeCamera(60, 40, 50.0, 48.0, 29.3, 20.6)
NEAR, FAR = 0.1, 20.0
GREY = np.array([0.5, 0.5, 0.5])
STRAIGHT = Light((0.0, 0.0, 1.0), 2.0, of_camera=True)


def rasteriser(*, still=(), moving=(), lights=(STRAIGHT,), X_WC=None):
    return Rasteriser(
        camera=CAMERA,
        X_WC=np.eye(4) if X_WC is None else X_WC,
        clipping=(NEAR, FAR),
        lights=lights,
        background=np.array([0.2, 0.4, 0.6]),
        still=still,
        moving=moving,
    )


def triangles(corners):
    corners = np.asarray(corners, dtype=np.float64)
    return faceted(corners.reshape(-1, 3), np.arange(len(corners) * 3).reshape(-1, 3))


def still_poses(count):
    return np.tile(np.eye(4)[:3], (count, 1, 1))


def cast(corners):
    """Depth and index of the nearest triangle by solving for each ray, one by one."""
    depth = np.full(CAMERA.shape, np.inf)
    index = np.full(CAMERA.shape, -1)
    margin = np.full(CAMERA.shape, np.inf)
    for k, (a, b, c) in enumerate(corners):
        matrix = np.array([a, b, c]).T
        if abs(np.linalg.det(matrix)) < 1e-9:
            continue
        # r = shares of the corners over the depth.
        shares = CAMERA.rays @ np.linalg.inv(matrix).T
        inverse = shares.sum(axis=-1)
        with np.errstate(divide="ignore"):
            z = 1.0 / inverse
        inside = (shares >= 0.0).all(axis=-1) & (z > NEAR) & (z < FAR)
        margin = np.minimum(margin, np.abs(shares).min(axis=-1))
        nearer = inside & (z < depth)
        depth[nearer], index[nearer] = z[nearer], k
    return depth, index, margin


@settings(deadline=None, max_examples=60)
@given(
    hnp.arrays(
        np.float64,
        (6, 3, 3),
        elements=st.floats(-4.0, 6.0, allow_subnormal=False).map(lambda x: round(x, 3)),
    )
)
def test_each_pixel_shows_what_its_ray_meets_first(corners):
    # Some of them reach behind the camera.
    expected, index, margin = cast(corners)
    surfaces = [Surface(triangles([c]), GREY, 10 + k) for k, c in enumerate(corners)]
    picture = rasteriser(moving=surfaces).picture(still_poses(6))
    # On an outline a pixel is either one's.
    clear = margin > 1e-7
    found = picture.depth[clear]
    seen = np.isfinite(expected[clear])
    assert (np.isfinite(found) == seen).all()
    # Single precision.
    np.testing.assert_allclose(found[seen], expected[clear][seen], rtol=2e-7)
    label = np.where(index < 0, NOTHING, 10 + index)
    apart = np.ones_like(clear)
    for k in range(6):
        for other in range(k):
            # Where two lie in one place, either may be shown.
            apart &= ~((corners[k] == corners[other]).all())
    assert (picture.label[clear & apart] == label[clear & apart]).all()


def test_the_floor_goes_on_below_and_behind_the_camera():
    y = 1.5
    floor = [
        [[-25, y, -25], [25, y, -25], [25, y, 25]],
        [[-25, y, -25], [25, y, 25], [-25, y, 25]],
    ]
    for kind in ("still", "moving"):
        drawn = rasteriser(**{kind: [Surface(triangles(floor), GREY, 7)]})
        picture = drawn.picture(still_poses(1 if kind == "moving" else 0))
        depth = y / np.maximum(CAMERA.rays[..., 1], 1e-9)
        seen = depth < FAR
        np.testing.assert_allclose(picture.depth[seen], depth[seen], rtol=2e-7)
        assert (picture.label == np.where(seen, 7, NOTHING)).all()


def test_what_stands_still_is_drawn_as_what_moves_to_its_place():
    rng = np.random.default_rng(1)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    p = np.array([0.1, -0.1, 2.0])
    # Edges shorter than what stands still is cut to: lit at the same vertices.
    ball = ellipsoid([0, 0, 0], [0.3, 0.2, 0.4], around=32, rings=17)
    block = box([0.1, 0.1, 0.1])
    placed = Shape(ball.vertices @ turn.T + p, ball.normals @ turn.T, ball.triangles)
    seen = rasteriser(
        still=[Surface(placed, GREY, 1), Surface(block, GREY, 2)]
    ).picture(still_poses(0))
    X_WG = still_poses(2)
    X_WG[0] = np.column_stack([turn, p])
    moved = rasteriser(
        moving=[Surface(ball, GREY, 1), Surface(block, GREY, 2)]
    ).picture(X_WG)
    np.testing.assert_array_equal(moved.label, seen.label)
    np.testing.assert_allclose(moved.depth, seen.depth, rtol=1e-6)
    # Light is worked out at more vertices of what stands still.
    assert np.abs(moved.colour.astype(int) - seen.colour).max() <= 1


def test_a_picture_does_not_remember_the_one_before():
    ball = Surface(ellipsoid([0, 0, 0], [0.3, 0.3, 0.3]), GREY, 1)
    drawn, here, there = rasteriser(moving=[ball]), still_poses(1), still_poses(1)
    here[0, :, 3], there[0, :, 3] = [-0.3, 0.0, 2.0], [0.3, 0.1, 1.5]
    first = drawn.picture(here)
    drawn.picture(there)
    again = drawn.picture(here)
    for name in ("colour", "depth", "label"):
        np.testing.assert_array_equal(getattr(again, name), getattr(first, name))


def test_a_bent_surface_is_drawn_with_its_vertices_of_now():
    ball = ellipsoid([0.0, 0.0, 2.0], [0.4, 0.4, 0.4])
    drawn = rasteriser(moving=[Surface(ball, GREY, 1)])
    points = ball.vertices + np.array([0.1, 0.0, 0.5])
    bent = drawn.picture(still_poses(1), {0: points})
    X_WG = still_poses(1)
    X_WG[0, :, 3] = [0.1, 0.0, 0.5]
    moved = drawn.picture(X_WG)
    np.testing.assert_array_equal(bent.label, moved.label)
    np.testing.assert_allclose(bent.depth, moved.depth, rtol=1e-6)
    with pytest.raises(ValueError, match="surface 0: found vertices"):
        drawn.picture(still_poses(1), {0: points[1:]})


def test_one_that_is_one_sided_is_seen_from_before_alone():
    before = [[[-1, -1, 2], [-1, 1, 2], [1, 0, 2]]]
    behind = [[[-1, -1, 2], [1, 0, 2], [-1, 1, 2]]]
    for corners, seen in ((before, True), (behind, False)):
        for one_sided in (False, True):
            surface = Surface(triangles(corners), GREY, 3, one_sided=one_sided)
            picture = rasteriser(moving=[surface]).picture(still_poses(1))
            assert (picture.label == 3).any() == (seen or not one_sided)


@pytest.mark.parametrize("tilt", [0.0, 0.5, 1.0, 1.3])
def test_a_rough_surface_is_as_bright_as_the_cosine_of_its_tilt(tilt):
    wide = 30.0
    across = np.array([np.cos(tilt), 0.0, np.sin(tilt)])
    corners = [
        [0, 0, 5.0] + wide * (i * across + j * np.array([0.0, 1.0, 0.0])) / 50.0
        for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    square = faceted(np.array(corners), np.array([[0, 2, 1], [0, 3, 2]]))
    picture = rasteriser(
        still=[Surface(square, np.ones(3), 1, roughness=1.0)],
        lights=[Light((0.0, 0.0, 1.0), 1.0, of_camera=True)],
    ).picture(still_poses(0))
    seen = picture.label == 1
    light = (picture.colour[seen, 0].mean() / 255.0) ** 2.2
    # Lambert's share, but for the little that is reflected at the surface.
    assert light == pytest.approx(np.cos(tilt) / np.pi, abs=0.02)


def test_a_surface_of_no_light_is_black_and_the_rest_is_background():
    ball = Surface(ellipsoid([0.0, 0.0, 2.0], [0.3, 0.3, 0.3]), GREY, 1)
    picture = rasteriser(still=[ball], lights=[]).picture(still_poses(0))
    seen = picture.label == 1
    assert (picture.colour[seen] == [0, 0, 0, 255]).all()
    assert (picture.colour[~seen] == [51, 102, 153, 255]).all()
    assert np.isinf(picture.depth[~seen]).all()


BALL = ellipsoid([0.0, 0.0, 2.0], [0.3, 0.3, 0.3])


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"rgb": np.array([0.5, 0.5, 1.5])}, "rgb"),
        ({"roughness": 0.0}, "roughness"),
        ({"vertices": BALL.vertices[1:], "normals": BALL.normals[1:]}, "triangles"),
        ({"normals": BALL.normals[1:]}, "normals"),
        ({"vertices": BALL.vertices * np.nan}, "finite"),
    ],
)
def test_an_unsound_surface_is_refused(changed, told):
    sound = {"vertices": BALL.vertices, "normals": BALL.normals, "rgb": GREY}
    values = sound | {"roughness": 0.5} | changed
    with pytest.raises(ValueError, match=told):
        Surface(
            Shape(values["vertices"], values["normals"], BALL.triangles),
            values["rgb"],
            1,
            values["roughness"],
        )


def test_a_camera_that_sees_nothing_is_refused():
    with pytest.raises(ValueError, match="clipping"):
        Rasteriser(
            camera=CAMERA,
            X_WC=np.eye(4),
            clipping=(1.0, 0.5),
            lights=[],
            background=GREY,
        )
