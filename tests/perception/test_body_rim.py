"""The body's rim is on the back, and as broad as its waist allows."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bath_drake.patient.people import shipped_people
from bath_drake.perception.body_rim import (
    BROADEST,
    LENGTH,
    ON_BACK,
    POWER,
    body_rim,
    share_within,
)
from bath_drake.perception.map_follower import frame_map


def back(waist, count=60000, seed=0):
    """Points of a back as broad as 1 at its ends, and as `waist` at y = -0.2."""
    p_N = np.random.default_rng(seed).uniform(-1.05, 1.05, (count, 2))
    broad = 1.0 - (1.0 - waist) * np.exp(-(((p_N[:, 1] + 0.2) / 0.35) ** 2))
    return p_N[np.abs(p_N[:, 0]) <= broad]


@given(waist=st.floats(0.6, 0.98))
@settings(max_examples=20, deadline=None)
def test_it_is_as_broad_as_the_waist(waist):
    rim = body_rim(back(waist))
    # Of its area 1.5 % may stick out, all of it at the waist.
    assert waist - 0.04 <= rim.semi_axes[0] <= min(waist + 0.16, BROADEST)
    assert (rim.semi_axes[1], rim.power) == (LENGTH, POWER)


def test_a_hole_in_the_back_is_of_the_back():
    p_N = back(0.9)
    holed = p_N[np.hypot(*p_N.T) > 0.2]
    assert body_rim(holed) == body_rim(p_N)


def test_what_is_hardly_a_back_has_none():
    p_N = back(0.9)
    assert body_rim(p_N[np.abs(p_N[:, 0]) < 0.4]) is None
    assert body_rim(np.zeros((0, 2))) is None


def test_the_share_within_is_that_of_the_surface():
    rim = body_rim(back(0.9))
    p_N = np.array([[0.0, 0.0], [0.99, 0.99]])
    assert share_within(rim, p_N, np.array([3.0, 1.0])) == 0.75


@pytest.mark.render
@pytest.mark.parametrize("person", shipped_people())
def test_most_of_every_shipped_back_is_within(render_person, person):
    observation = render_person(person).observe()
    p_N = frame_map(observation).canonical_from_world(observation.points_W)
    rim = body_rim(p_N)
    assert share_within(rim, p_N, observation.point_areas) > 0.8
    # Every shipped stroke, 0.7 to either side and half that high, is well within.
    corners = np.array([[0.7, 0.35], [-0.7, 0.35], [0.7, -0.35], [-0.7, -0.35]])
    assert rim.beta(corners).min() > 0.1
    inside = np.random.default_rng(0).uniform(-1, 1, (20000, 2))
    inside = inside[rim.beta(inside) > 0.0]
    # On the back: a point seen within two cells of it.
    near = np.array([np.abs(p_N[::5] - q).max(axis=1).min() for q in inside[:2000]])
    assert (near < 0.08).mean() > ON_BACK
