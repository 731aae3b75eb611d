import numpy as np
import pytest

from bath_drake.field.obstacles import ObstacleSet
from bath_drake.patient.people import shipped_people
from bath_drake.perception.area_memory import merge_areas
from bath_drake.perception.canonical import fit_canonical_map
from bath_drake.perception.colour_noise import ColourNoiseConfig, noisy_colour
from bath_drake.perception.ellipses import enclosing_ellipse
from bath_drake.perception.restricted import find_restricted_areas
from bath_drake.perception.segmentation import UP_W

PEOPLE = shipped_people()
WOUND = (0.05, 0.05, 0.04, 0.03)


@pytest.fixture
def rng():
    return np.random.default_rng(4)


def _map(observation):
    return fit_canonical_map(
        observation.completed_points_W,
        UP_W,
        observation.p_WC,
        observation.completed_areas,
    )


def _find(frame, margin=0.02, previous=None):
    observation = frame.observe(previous=previous)
    return find_restricted_areas(observation, _map(observation), margin)


def _level(ellipse, points):
    x, y, a, b, t = ellipse
    c, s = np.cos(t), np.sin(t)
    u, v = ((points - [x, y]) @ np.array([[c, -s], [s, c]])).T
    return (u / a) ** 2 + (v / b) ** 2


@pytest.mark.parametrize("skin", [(245, 220, 205), (141, 85, 54), (60, 38, 28)])
def test_a_wound_is_enclosed_and_clear_skin_is_not(draw_frame, skin):
    assert len(_find(draw_frame(skin=skin))) == 0
    frame = draw_frame(skin=skin, wound=WOUND)
    areas = _find(frame, margin=0.02)
    assert len(areas) == 1
    observation = frame.observe()
    body = _map(observation)
    dark = (observation.colours == (25, 12, 12)).all(axis=1)
    assert (
        _level(areas.theta[0], body.canonical_from_world(observation.points_W[dark]))
        < 1.0
    ).all()
    # The wound and its margin, and a pixel and the outer approximation beside it.
    _, _, a, b, _ = body.ellipse_from_canonical(areas.theta[0])
    assert 0.06 <= a <= 0.072
    assert 0.05 <= b <= 0.062


def test_a_speck_is_no_wound(draw_frame):
    assert len(_find(draw_frame(wound=(0.0, 0.0, 0.006, 0.006)))) == 0


def test_two_wounds_are_two_areas(draw_frame):
    frame = draw_frame(wound=WOUND)
    other = draw_frame(wound=(-0.08, -0.1, 0.03, 0.03))
    dark = (other.colour == (25, 12, 12)).all(axis=-1)
    frame.colour[dark] = (25, 12, 12)
    assert len(_find(frame)) == 2


def test_gentle_shading_is_no_wound(draw_frame):
    frame = draw_frame()
    across = np.linspace(-1.0, 1.0, frame.colour.shape[1])
    light = 1.0 - 8.0 * across**2  # a third darker at the flanks
    shaded = frame.colour * np.clip(light, 0.3, 1.0)[None, :, None]
    frame.colour = np.where(frame.back[..., None], shaded, frame.colour).astype(
        np.uint8
    )
    assert len(_find(frame)) == 0


def test_an_empty_observation_has_no_areas(draw_frame):
    body = _map(draw_frame().observe())
    blank = draw_frame()
    blank.depth[:] = np.nan
    assert len(find_restricted_areas(blank.observe(), body, 0.02)) == 0


def test_a_negative_margin_is_refused(draw_frame):
    observation = draw_frame().observe()
    with pytest.raises(ValueError, match="margin_m"):
        find_restricted_areas(observation, _map(observation), -0.01)


def test_the_ellipse_holds_every_point_with_its_margin(rng):
    points = rng.normal(size=(200, 2)) * [0.03, 0.01]
    ellipse = enclosing_ellipse(points, 0.02)
    turn = rng.uniform(0, 2 * np.pi, (200, 1))
    ring = points + 0.02 * np.hstack([np.cos(turn), np.sin(turn)])
    # Single precision of the hull's corners.
    assert _level(ellipse, ring).max() < 1.0 + 1e-5


def test_the_ellipse_around_an_ellipse_is_that_ellipse():
    turn = np.linspace(0, 2 * np.pi, 400)
    points = np.column_stack([0.05 * np.cos(turn), 0.02 * np.sin(turn)])
    x, y, a, b, _ = enclosing_ellipse(points, 1e-6)
    # Khachiyan stops within 1 % of the least area.
    np.testing.assert_allclose([x, y], 0.0, atol=5e-4)
    np.testing.assert_allclose([a, b], [0.05, 0.02], rtol=0.02)


def test_an_area_once_seen_stays_when_hidden_and_when_half_hidden():
    full = ObstacleSet(np.array([[0.2, 0.1, 0.3, 0.2, 0.4]]))
    half = ObstacleSet(np.array([[0.25, 0.1, 0.15, 0.1, 0.4]]))
    assert merge_areas(full, ObstacleSet()) == full
    assert merge_areas(full, half) == full


def test_an_area_seen_larger_grows_to_hold_both():
    small = np.array([0.25, 0.1, 0.15, 0.1, 0.4])
    large = np.array([0.3, 0.15, 0.3, 0.2, 0.4])
    merged = merge_areas(ObstacleSet(small[None]), ObstacleSet(large[None]))
    assert len(merged) == 1
    turn = np.linspace(0, 2 * np.pi, 50)
    for x, y, a, b, t in (small, large):
        c, s = np.cos(t), np.sin(t)
        outline = np.column_stack([a * np.cos(turn), b * np.sin(turn)])
        outline = [x, y] + outline @ np.array([[c, s], [-s, c]])
        # The outlines are polygons of 64 corners: they cut 0.1 % of the radius.
        assert _level(merged.theta[0], outline).max() < 1.01


def test_an_area_elsewhere_is_added():
    one = ObstacleSet(np.array([[0.5, 0.5, 0.1, 0.1, 0.0]]))
    two = ObstacleSet(np.array([[-0.5, -0.5, 0.1, 0.1, 0.0]]))
    assert len(merge_areas(one, two)) == 2


def test_noise_does_not_make_an_area_creep(rng):
    seen = np.array([0.2, 0.1, 0.3, 0.2, 0.4])
    known = ObstacleSet(seen[None])
    for _ in range(300):
        jitter = seen + np.append(rng.normal(scale=2e-3, size=4), 0.0)
        known = merge_areas(known, ObstacleSet(jitter[None]))
    assert len(known) == 1
    # A tolerance of 5 % takes jitter of 1 %.
    np.testing.assert_allclose(known.theta[0, 2:4], seen[2:4], rtol=0.06)


@pytest.mark.render
@pytest.mark.parametrize("person", PEOPLE)
def test_rendered_people_have_the_wounds_they_have(render_person, person):
    clear = render_person(person)
    assert len(_find(clear)) == 0
    frame = render_person(person, wound=(0.05, 0.6, 0.06))
    assert len(_find(frame)) == 1
    hidden = render_person(person, arm=(0.05, 0.5))
    assert len(_find(hidden, previous=clear.observe())) == 0


@pytest.mark.parametrize("skin", [(245, 220, 205), (200, 150, 120), (90, 60, 45)])
@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("red", (1.05, 0.6, 0.6)),
        ("mildly red", (1.0, 0.82, 0.82)),
        ("bruise", (0.75, 0.75, 1.0)),
        ("yellow", (1.0, 0.95, 0.7)),
        ("pale", (1.0, 1.2, 1.35)),
    ],
)
def test_an_area_of_another_colour_is_found_on_skin_of_every_tone(
    draw_frame, skin, name, change
):
    frame = draw_frame(skin=skin, wound=WOUND)
    wound = (frame.colour == (25, 12, 12)).all(axis=-1)
    frame.colour[wound] = np.clip(np.array(skin) * change, 0, 255).astype(np.uint8)
    areas = _find(frame)
    assert len(areas) == 1
    _, _, a, b, _ = _map(frame.observe()).ellipse_from_canonical(areas.theta[0])
    # As of the dark one: its own size, the margin and a pixel or two beside it.
    assert 0.058 <= a <= 0.076
    assert 0.048 <= b <= 0.066


@pytest.mark.parametrize("light", [1.0, 0.5])
@pytest.mark.parametrize("tone", [(1.0, 1.0, 1.0), (1.08, 1.0, 0.9), (0.92, 1.0, 1.1)])
def test_light_of_another_brightness_or_tone_makes_no_area(draw_frame, light, tone):
    frame = draw_frame()
    lit = frame.colour * (light * np.array(tone))
    frame.colour = np.clip(lit, 0, 255).astype(np.uint8)
    assert len(_find(frame)) == 0


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("skin", [(245, 220, 205), (60, 38, 28)])
def test_a_cameras_noise_makes_no_area(draw_frame, skin, seed):
    frame = draw_frame(skin=skin)
    frame.colour = noisy_colour(
        frame.colour, ColourNoiseConfig(exposure=0.6), seed=seed, frame=0, t=5.0 * seed
    )
    assert len(_find(frame)) == 0
