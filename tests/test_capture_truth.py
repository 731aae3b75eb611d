"""Captured strokes against the truth of the films they come from."""

import pytest

from bath_drake.benchmarks.capture import PEOPLE, Film, films, judge, record
from bath_drake.carer.config import RubbingConfig
from bath_drake.demonstrations.rgbd.folder import open_rgbd

WAYPOINTS = [[-0.6, 0.5], [0.1, 0.6], [0.55, 0.1], [-0.2, 0.0], [-0.5, -0.45]]


def short_film(person, circles):
    """A stroke of four seconds, at few frames a second: they cost the time."""
    rubbing = RubbingConfig(amplitude=0.1, frequency=0.7) if circles else None
    carer = {
        "demonstration": None,
        "waypoints": WAYPOINTS,
        "seconds": 4.0,
        "pause": 0.4,
        "rubbing": rubbing,
    }
    return Film("short", person, carer, 7.5, seed=len(person))


@pytest.mark.slow
@pytest.mark.render
@pytest.mark.parametrize(
    ("person", "circles"),
    [
        ("f_thin", False),
        ("m_heavy", True),
        pytest.param("f_avg", False, marks=pytest.mark.exhaustive),
        pytest.param("m_avg", True, marks=pytest.mark.exhaustive),
    ],
)
def test_the_captured_stroke_is_the_true_one(tmp_path, person, circles):
    film = short_film(person, circles)
    truth = record(tmp_path / "film", film)
    found = judge(open_rgbd(tmp_path / "film"), film.said, truth)
    # Asked is 0.03; all are below 0.025. Most of the distance is where a shoulder is
    # thought to end.
    assert found.over_side <= 0.03
    assert found.open_gaps == 0


def test_every_person_is_filmed_with_and_without_circles():
    made = films()
    assert len({(film.stroke, film.person, film.seed) for film in made}) > 15
    for person in PEOPLE:
        strokes = {film.stroke for film in made if film.person == person}
        assert strokes >= {"way-points", "circles", "random", "random, circles"}
