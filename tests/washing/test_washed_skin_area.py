"""What was washed of a real back: places, seconds, coverage."""

import numpy as np
import pytest

from bath_drake.patient.motion import MotionConfig, trunk_bend
from bath_drake.patient.people import LABEL_BACK, load_person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin import TrueSkin
from bath_drake.washing.config import WashingConfig, washing_tool
from bath_drake.washing.footprint import JetCone, SpongeDisc
from bath_drake.washing.outcome import path_distance, wash_outcome
from bath_drake.washing.places import back_places
from bath_drake.washing.washed_places import LOOK_PERIOD_S, washed_seconds

STROKE = np.array([[-0.5, -0.2], [0.5, -0.2], [0.5, 0.3]])
WOUND_N = np.array([[0.0, -0.3], [0.2, -0.3], [0.2, -0.1], [0.0, -0.1]])
REST = MotionConfig()
BENDING = MotionConfig(flexion_amplitude=0.14, spine_twist_amplitude=0.2)
PITCH = 0.004


@pytest.fixture(scope="module")
def skin():
    return TrueSkin(load_person("f_avg"))


@pytest.fixture(scope="module")
def places(skin):
    return back_places(skin, PITCH)


def nozzle(skin, count=60, motion=REST, begin=0.0, standoff=0.06):
    """Times, tips and axes of a nozzle along the stroke, square to the skin."""
    share = np.linspace(0.0, 2.0, count)
    p_N = np.column_stack([np.interp(share, [0, 1, 2], STROKE[:, k]) for k in (0, 1)])
    points, met = skin.under(p_N)
    assert met.all()
    corners, weights = skin.bind(points)
    time = begin + LOOK_PERIOD_S * np.arange(count)
    tips, axes = np.empty((count, 3)), np.empty((count, 3))
    for k, t in enumerate(time):
        now = skin
        if motion.bends:
            bent = bending_skin(skin.person).points(trunk_bend(float(t), motion))
            now = TrueSkin(skin.person, bent)
        vertices = skin.person.vertices if now.bent is None else now.bent
        point = weights[k] @ vertices[corners[k]]
        (axis,) = -now.nearest(point[None])[2]
        tips[k], axes[k] = point - standoff * axis, axis
    return time, tips, axes


def judge(skin, places, seconds, wounds=(), spared=0.02, **target):
    half = skin.canonical_map.half_extents
    return wash_outcome(
        places,
        seconds,
        WashingConfig(**target),
        stroke=STROKE,
        half_extents=half,
        wounds=[outline * half for outline in wounds],
        spared=spared,
    )


def test_places_stand_for_the_whole_area_of_the_back_seen_from_behind(skin, places):
    person = skin.person
    corners = person.vertices[places.triangles]
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(facets, axis=1).sum()
    assert places.area == pytest.approx(area)
    assert places.areas.max() <= PITCH**2 * (1.0 + 1e-9)
    points, _ = places.at(person.vertices)
    distance, _, _ = skin.nearest(points)
    # Single precision of the nearest points.
    assert distance.max() < 1e-6
    # And the labelled box is on it.
    assert (person.labels[places.triangles] == LABEL_BACK).any(axis=1).all()
    target = judge(
        skin,
        places,
        np.zeros(len(places)),
        target_low=[-0.7, -0.6],
        target_high=[0.7, 0.6],
    )
    level = 1.4 * 1.2 * skin.canonical_map.half_extents.prod()
    assert level < target.figures()["target_cm2"] / 1e4 < 1.4 * level


def test_a_jet_along_its_stroke_washes_the_strokes_band(skin, places):
    jet = JetCone(half_angle=0.45, reach=0.15)
    seconds = washed_seconds(skin, places, REST, *nozzle(skin), jet)
    outcome = judge(skin, places, seconds)
    assert outcome.coverage == 1.0
    figures = outcome.figures()
    # Footprints of 29 mm to both sides along the stroke, round at its ends.
    half = skin.canonical_map.half_extents
    length = np.linalg.norm(np.diff(STROKE * half, axis=0), axis=1).sum()
    radius = jet.radius(0.06)
    swept = 2.0 * radius * length + np.pi * radius**2
    washed = figures["washed_cm2"] + figures["washed_besides_cm2"]
    # The back is not level: its hollows and flanks hold more skin and farther.
    assert washed / 1e4 == pytest.approx(swept, rel=0.12)
    # Seconds add up to the time of the run times the mean footprint.
    total = places.areas @ seconds / (LOOK_PERIOD_S * 60)
    assert total == pytest.approx(np.pi * radius**2, rel=0.12)


def test_coverage_grows_with_time_and_footprint_and_is_never_more_than_one(
    skin, places
):
    time, tips, axes = nozzle(skin)
    found = []
    for count in (0, 1, 15, 30, 60):
        seconds = washed_seconds(
            skin,
            places,
            REST,
            time[:count],
            tips[:count],
            axes[:count],
            JetCone(half_angle=0.3, reach=0.15),
        )
        found.append(judge(skin, places, seconds).coverage)
    assert found[0] == 0.0
    assert (np.diff(found) > 0.0).all()
    for angle in (0.2, 0.3, 0.45, 0.9):
        tool = JetCone(half_angle=angle, reach=0.3)
        seconds = washed_seconds(skin, places, REST, time, tips, axes, tool)
        found.append(judge(skin, places, seconds).coverage)
    assert (np.diff(found[5:]) >= 0.0).all()
    assert max(found) <= 1.0


@pytest.mark.slow
def test_a_bending_back_is_washed_where_its_skin_goes(skin, places):
    jet = JetCone(half_angle=0.45, reach=0.15)
    still = washed_seconds(skin, places, REST, *nozzle(skin), jet)
    moved = nozzle(skin, motion=BENDING, begin=4.0)
    bent = washed_seconds(skin, places, BENDING, *moved, jet)
    # The same nozzle over the same skin, which is bent: nearly the same places.
    both = places.areas[(still > 0.0) & (bent > 0.0)].sum()
    either = places.areas[(still > 0.0) | (bent > 0.0)].sum()
    assert both > 0.9 * either
    # Taken for rigid, the skin would be missed.
    astray = washed_seconds(skin, places, REST, *moved, jet)
    assert judge(skin, places, astray).coverage < judge(skin, places, bent).coverage


def test_what_the_skin_itself_hides_stays_dry(skin, places):
    """A nozzle in front of the person: its jet meets the chest, not the back."""
    middle = skin.canonical_map.p_WP
    outward = skin.canonical_map.normal_W
    tip = (middle - 0.8 * outward)[None]
    jet = JetCone(half_angle=0.3, reach=2.0)
    seconds = washed_seconds(skin, places, REST, np.zeros(1), tip, outward[None], jet)
    assert not seconds.any()


def test_a_wound_is_no_target_and_what_it_gets_is_told(skin, places):
    tool = JetCone(half_angle=0.45, reach=0.15)
    seconds = washed_seconds(skin, places, REST, *nozzle(skin), tool)
    plain, wounded = (judge(skin, places, seconds, w) for w in ((), (WOUND_N,)))
    assert not (wounded.target & wounded.wounded).any()
    assert wounded.target.sum() < plain.target.sum()
    around = path_distance(places.p_N, np.vstack([WOUND_N, WOUND_N[:1]]))
    # 20 mm are 0.08 or more of N.
    assert around[wounded.target].min() > 0.08
    figures = wounded.figures()
    # The stroke goes through the middle of the wound, which is as wide as the jet.
    assert 0.9 < figures["wound_wetted_cm2"] / figures["wound_cm2"] <= 1.0
    assert plain.figures()["wound_wetted_cm2"] == 0.0
    wider = judge(skin, places, seconds, (WOUND_N,), spared=0.04)
    assert wider.target.sum() < wounded.target.sum()


def test_a_sponge_washes_only_where_it_touches(skin, places):
    sponge = SpongeDisc(radius=0.03)
    off = washed_seconds(skin, places, REST, *nozzle(skin), sponge)
    assert not off.any()
    touching = nozzle(skin, standoff=0.0)
    on = washed_seconds(skin, places, REST, *touching, sponge)
    assert judge(skin, places, on).coverage == 1.0


def test_without_a_target_there_is_no_share(skin, places):
    whole = np.array([[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]])
    outcome = judge(skin, places, np.zeros(len(places)), (whole,))
    assert outcome.coverage is None
    assert outcome.figures()["seconds_per_place"] is None


def test_the_distance_from_a_path_is_that_of_its_nearest_piece():
    path = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    points = np.array([[0.5, 0.2], [1.3, 0.5], [-3.0, 4.0], [1.0, 0.4]])
    found = path_distance(points, path)
    np.testing.assert_allclose(found, [0.2, 0.3, 5.0, 0.0], atol=1e-12)


def test_a_configuration_gives_its_tool():
    jet = washing_tool(WashingConfig(half_angle=0.3, reach=0.2))
    assert jet == JetCone(half_angle=0.3, reach=0.2)
    sponge = washing_tool(WashingConfig(tool="sponge", sponge_length=0.1))
    assert sponge == SpongeDisc(radius=0.03, length=0.1)
