"""Where a nozzle washed: known places of a skin that bends meanwhile come back."""

import numpy as np
import pytest

from bath_drake.patient.motion import MotionConfig, trunk_bend
from bath_drake.patient.people import load_person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.washed_skin import (
    tracking_lag,
    triangles_around_back,
    washed_skin,
)

BENDING = MotionConfig(
    flexion_amplitude=0.14, spine_twist_amplitude=0.2, chest_amplitude=0.006
)
TIMES = np.array([0.0, 4.0, 9.3, 17.0])
# A nozzle as far off as one that washes, m.
STANDOFF = 0.06


@pytest.fixture(scope="module")
def skin():
    return TrueSkin(load_person("f_avg"))


@pytest.fixture(scope="module", params=[MotionConfig(), BENDING], ids=["rigid", "bent"])
def washed(request, skin):
    """A nozzle square over the same four places, whatever the skin does."""
    places, met = skin.under(
        np.array([[0.0, 0.0], [0.5, 0.4], [-0.6, 0.2], [0.2, -0.5]])
    )
    assert met.all()
    corners, weights = skin.bind(places)
    tips, normals = [], []
    for k, t in enumerate(TIMES):
        bend = trunk_bend(float(t), request.param)
        now = TrueSkin(skin.person, bending_skin(skin.person).points(bend))
        point = weights[k] @ now.bent[corners[k]]
        _, _, (normal,) = now.nearest(point[None])
        tips.append(point + STANDOFF * normal)
        normals.append(normal)
    tips, normals = np.array(tips), np.array(normals)
    found = washed_skin(skin, request.param, TIMES, tips, -normals)
    return found, places, normals


def test_the_jet_meets_the_same_skin_wherever_it_has_gone(washed):
    found, places, _ = washed
    assert found.met.all()
    # Rays and triangles are in single precision, metres from the origin.
    np.testing.assert_allclose(found.resting, places, atol=5e-5)


def test_distance_and_normal_are_those_of_the_skin_as_it_was(washed):
    found, _, normals = washed
    # Where the back is hollow the nearest skin is a little beside the jet's.
    np.testing.assert_allclose(found.distance, STANDOFF, atol=5e-4)
    cosine = (found.normals * normals).sum(axis=1)
    assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).max() < 3.0


@pytest.mark.parametrize("off", [STANDOFF, 0.3])
@pytest.mark.parametrize("turned", [1.0, -1.0], ids=["at the skin", "away"])
def test_of_the_skin_near_the_nozzle_comes_what_comes_of_all(
    skin, monkeypatch, off, turned
):
    places, _ = skin.under(np.array([[0.0, 0.0], [0.5, 0.4], [-0.6, 0.2], [0.2, -0.5]]))
    _, _, normals = skin.nearest(places)
    looked = skin, BENDING, TIMES, places + off * normals, -turned * normals
    near = washed_skin(*looked)
    # Nothing found is near enough to be believed then: all of the skin is looked at.
    monkeypatch.setattr("bath_drake.patient.washed_skin._AROUND_NOZZLE_M", 0.0)
    whole = washed_skin(*looked)
    assert np.array_equal(near.met, whole.met)
    # Single precision, and the same triangles in another order.
    for part in ("distance", "normals", "resting", "receded"):
        np.testing.assert_allclose(getattr(near, part), getattr(whole, part), atol=1e-6)


def test_the_triangles_around_the_back_are_some_of_the_persons(skin):
    around = triangles_around_back(skin.person)
    assert 960 < len(around) < len(skin.person.triangles) / 2


@pytest.mark.parametrize("motion", [MotionConfig(), BENDING], ids=["rigid", "bent"])
def test_skin_has_receded_from_where_the_nozzle_was(skin, motion):
    # The nozzle stays where it is in W while the person, M, comes 5 mm nearer along
    # the normal: in M it has gone 5 mm inwards.
    (place,), _ = skin.under(np.zeros((1, 2)))
    _, _, (normal,) = skin.nearest(place[None])
    times = np.array([0.0, 0.01])  # so little time that nobody bends
    tips = place + np.array([[STANDOFF], [STANDOFF]]) * normal
    before = tips - 0.005 * normal
    found = washed_skin(skin, motion, times, tips, -np.tile(normal, (2, 1)), before)
    assert found.receded[0] == 0.0
    # Rays and triangles are in single precision.
    assert found.receded[1] == pytest.approx(-0.005, abs=1e-4)


def test_a_nozzle_that_follows_late_is_found_out():
    time = np.arange(0.0, 20.0, 0.01)
    height = 0.008 * np.sin(2 * np.pi * 0.25 * time)  # a breath, outward
    lag = 0.04
    error = 0.008 * np.sin(2 * np.pi * 0.25 * (time - lag)) - height
    receded = -np.diff(height, prepend=height[0])
    # Differences of a sine over 10 ms, and the lag's own second order.
    assert tracking_lag(error, receded, time) == pytest.approx(lag, rel=0.02)


def test_still_skin_tells_no_lag():
    time = np.arange(0.0, 5.0, 0.01)
    assert tracking_lag(1e-3 * np.sin(time), np.zeros_like(time), time) is None
    assert tracking_lag(np.zeros(2), np.zeros(2), np.zeros(2)) is None
