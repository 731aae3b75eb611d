"""The coverage map."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from bath_drake.patient.people import load_person
from bath_drake.patient.skin import TrueSkin
from bath_drake.report import style
from bath_drake.report.coverage_figure import draw_coverage
from bath_drake.washing.outcome import WashOutcome
from bath_drake.washing.places import back_places


@pytest.fixture(scope="module")
def half_washed():
    places = back_places(TrueSkin(load_person("f_thin")), 0.005)
    target = (np.abs(places.p_N) <= 0.6).all(axis=1)
    seconds = np.where(places.p_N[:, 0] < 0.0, 1.0, 0.0)
    return WashOutcome(places, seconds, target, np.zeros(len(places), dtype=bool))


def colour_at(figure, x, y):
    """What is drawn at a canonical point, (3,) of 0 to 255."""
    axes = figure.axes[0]
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())
    column, row = axes.transData.transform((x, y)).astype(int)
    return pixels[len(pixels) - 1 - row, column, :3]


def test_washed_and_missed_skin_have_colours_of_their_own(half_washed):
    path = np.array([[-0.4, -0.5], [-0.4, 0.5]])
    wound = np.array([[0.5, -0.5], [0.8, -0.5], [0.8, -0.2]])
    with style.figure_style():
        figure = draw_coverage(half_washed, path, [wound], "50 %", 0.95)
        FigureCanvasAgg(figure)
        missed = colour_at(figure, 0.3, 0.3)
        washed = colour_at(figure, -0.2, 0.3)
        neither = colour_at(figure, 0.3, 0.8)
    np.testing.assert_allclose(missed, 255 * np.array(style.rgb(style.RETREAT)), atol=2)
    assert washed[2] > washed[0] + 50  # blue
    assert np.ptp(neither.astype(int)) < 15  # plain skin, near to white
    assert "asked for 95 %" in figure.axes[0].get_title(loc="left")


def test_without_a_target_there_is_no_map(half_washed):
    nothing = np.zeros(len(half_washed.places), dtype=bool)
    outcome = WashOutcome(half_washed.places, half_washed.seconds, nothing, nothing)
    assert draw_coverage(outcome, np.zeros((0, 2)), [], "–") is None
