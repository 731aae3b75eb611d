"""Footprints of jet and sponge on known surfaces."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bath_drake.washing.footprint import JetCone, SpongeDisc

PITCH = 5e-4
STEPS = np.arange(-0.06, 0.06, PITCH) + PITCH / 2.0
# A plane z = 0 of small squares, and a nozzle over it that looks down.
PLANE = np.stack([*np.meshgrid(STEPS, STEPS), np.zeros((len(STEPS),) * 2)], axis=-1)
PLANE = PLANE.reshape(-1, 3)
UP = np.tile([0.0, 0.0, 1.0], (len(PLANE), 1))
DOWN = np.array([0.0, 0.0, -1.0])
TIP = np.array([0.0, 0.0, 0.06])
JET = JetCone(half_angle=0.45, reach=0.15)
SPONGE = SpongeDisc(radius=0.03)


def area(tool, tip=TIP, axis=DOWN):
    return PITCH**2 * np.count_nonzero(tool.covers(PLANE, UP, tip, axis))


@pytest.mark.parametrize("height", [0.03, 0.06, 0.09])
def test_a_jet_square_to_a_plane_wets_the_cones_disc(height):
    expected = np.pi * (height * np.tan(JET.half_angle)) ** 2
    # The rim cuts squares: half a square of its length at most.
    error = np.pi * 2.0 * JET.radius(height) * PITCH
    assert area(JET, np.array([0.0, 0.0, height])) == pytest.approx(expected, abs=error)
    assert np.pi * JET.radius(height) ** 2 == pytest.approx(expected)


def test_a_tilted_jet_wets_the_cones_ellipse():
    # A plane at distance h along the axis, tilted by t, cuts a cone of half angle a in
    # an ellipse of semi-axes h sin 2a cos t / (2 (cos^2 t - sin^2 a)) and
    # h sin a cos t / sqrt(cos^2 t - sin^2 a).
    t, a, height = 0.4, 0.3, 0.05
    axis = np.array([np.sin(t), 0.0, -np.cos(t)])
    cut = np.cos(t) ** 2 - np.sin(a) ** 2
    long = height * np.sin(2.0 * a) * np.cos(t) / (2.0 * cut)
    short = height * np.sin(a) * np.cos(t) / np.sqrt(cut)
    found = area(JetCone(half_angle=a, reach=1.0), -height * axis, axis)
    assert found == pytest.approx(np.pi * long * short, rel=0.01)


def test_beyond_its_reach_a_jet_wets_nothing():
    assert area(JET, np.array([0.0, 0.0, 0.16])) == 0.0
    assert JET.radius(0.16) == 0.0
    short = JetCone(half_angle=0.45, reach=0.061)
    # What the sphere of its reach leaves of the cone.
    radius = np.sqrt(0.061**2 - 0.06**2)
    assert short.radius(0.06) == pytest.approx(radius)
    assert area(short) == pytest.approx(np.pi * radius**2, rel=0.02)


def test_skin_behind_the_nozzle_or_turned_away_stays_dry():
    assert not JET.covers(PLANE, UP, TIP, -DOWN).any()
    assert not JET.covers(PLANE, -UP, TIP, DOWN).any()


def test_a_sponge_covers_its_disc_while_it_touches():
    here = np.array([0.0, 0.0, 0.004])
    # As for the jet: half a square along the rim.
    error = np.pi * 2.0 * SPONGE.radius * PITCH
    expected = pytest.approx(np.pi * SPONGE.radius**2, abs=error)
    assert area(SPONGE, here) == expected
    assert area(SpongeDisc(radius=0.03, length=0.06)) == expected
    assert area(SPONGE, np.array([0.0, 0.0, 0.02])) == 0.0
    assert not SPONGE.covers(np.empty((0, 3)), np.empty((0, 3)), here, DOWN).any()


@pytest.mark.parametrize("tool", [JET, SPONGE], ids=["jet", "sponge"])
def test_a_larger_tool_covers_all_that_a_smaller_one_does_and_more(tool):
    tip = TIP if tool is JET else np.zeros(3)
    if tool is JET:
        larger = JetCone(half_angle=0.5, reach=0.15)
    else:
        larger = SpongeDisc(radius=0.035)
    small = tool.covers(PLANE, UP, tip, DOWN)
    large = larger.covers(PLANE, UP, tip, DOWN)
    assert (large | ~small).all()
    assert large.sum() > small.sum()


@pytest.mark.parametrize("tool", [JET, SPONGE], ids=["jet", "sponge"])
def test_a_footprint_goes_along_with_a_rigid_motion(tool):
    tip = TIP if tool is JET else np.array([0.0, 0.0, 0.003])
    axis = np.array([0.2, -0.1, -1.0]) / np.linalg.norm([0.2, -0.1, -1.0])
    here = tool.covers(PLANE, UP, tip, axis)
    R = Rotation.from_euler("xyz", [0.3, -1.1, 2.0]).as_matrix()
    p = np.array([0.4, -0.2, 1.3])
    there = tool.covers(PLANE @ R.T + p, UP @ R.T, R @ tip + p, R @ axis)
    # Rounding may move a place across the rim.
    assert np.count_nonzero(here != there) <= 2
    assert here.any()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: JetCone(half_angle=1.6, reach=1.0), "half_angle must be in"),
        (lambda: JetCone(half_angle=0.3, reach=0.0), "reach must be positive"),
        (lambda: SpongeDisc(radius=float("nan")), "radius must be positive"),
        (lambda: SpongeDisc(radius=0.1, contact=0.0), "contact must be positive"),
        (lambda: SpongeDisc(radius=0.1, length=-1.0), "length must be finite"),
    ],
)
def test_a_tool_that_cannot_be_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
