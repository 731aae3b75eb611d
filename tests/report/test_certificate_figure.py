"""The picture says what the certificate says."""

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from bath_drake.certificate.certify import certify
from bath_drake.certificate.result import Box, Certificate, Doubt, Enclosure, Trap
from bath_drake.field.navigation import NavigationField, psi
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.report.certificate_figure import draw_certificate


def world(*rows, kappa=10.0):
    return NavigationField(
        workspace=Workspace(np.zeros(2), np.full(2, 5.0)),
        goal=np.array([3.0, 0.0]),
        kappa=kappa,
        obstacles=ObstacleSet(np.array(rows).reshape(-1, 5)),
    )


DISC = world([0.0, 0.0, 1.0, 1.0, 0.0])
WALL = world([-0.5, 0.0, 0.2, 1.6, 0.0])


def legend(figure):
    return [text.get_text() for text in figure.axes[0].get_legend().get_texts()]


def frames(figure):
    return [
        patch
        for patch in figure.axes[0].patches
        if isinstance(patch, Rectangle) and not patch.get_fill()
    ]


def test_a_proved_world_shows_its_saddle_and_one_basin():
    figure = draw_certificate(DISC, certify(DISC), np.array([-4.0, 1.0]))
    names = legend(figure)
    assert {"workspace", "obstacle", "saddle", "goal"} <= set(names)
    assert {"start", "way of the start"} <= set(names)
    assert "starts that end at the goal: 100 %" in names
    assert not any("trap" in name for name in names)
    assert figure.get_suptitle().startswith("PROVED: ")
    assert frames(figure) == []


def test_restricted_areas_are_told_from_learned_obstacles():
    both = world([0.0, 0.0, 1.0, 1.0, 0.0], [-2.0, 2.5, 0.5, 0.5, 0.0])
    figure = draw_certificate(both, certify(both), sensed=1)
    names = legend(figure)
    assert names.count("obstacle") == names.count("restricted area") == 1
    assert "restricted area" not in legend(draw_certificate(both, certify(both)))


def test_a_refuted_world_shows_its_trap_the_box_and_the_basin():
    certificate = certify(WALL)
    figure = draw_certificate(WALL, certificate)
    names = legend(figure)
    assert figure.get_suptitle().startswith("REFUTED: ")
    assert "minimum: a trap" in names
    (share,) = [n for n in names if n.startswith("starts that end in a trap")]
    # Counted once by brute force on a finer grid: 41 %.
    assert float(share.split(":")[1].rstrip("% ")) == pytest.approx(41.0, abs=1.0)
    (frame,) = frames(figure)
    # The box itself could not be seen: a frame is drawn around it.
    assert frame.get_width() == pytest.approx(0.35)
    x = frame.get_x() + frame.get_width() / 2.0
    assert x == pytest.approx(certificate.traps[0].x, abs=1e-6)


def test_what_stalls_at_a_saddle_is_not_called_trapped():
    # On the axis of symmetry the flow leads onto the saddle: a set of measure zero,
    # but in a flat workspace some of the grid's starts come so near that they stall.
    flat = NavigationField(
        Workspace(np.zeros(2), np.array([5.0, 0.5])),
        np.array([3.0, 0.0]),
        10.0,
        ObstacleSet(np.array([[0.0, 0.0, 0.1, 0.1, 0.0]])),
    )
    names = legend(draw_certificate(flat, certify(flat)))
    assert not any("trap" in name for name in names)


def test_an_undecided_world_shows_where():
    box = Box(-1.0, -0.5, 0.5, 1.5)
    point = Enclosure(-0.8, 1.0, "degenerate", (0.0, 1.0), None)
    doubt = Doubt(box, "degeneracy", "another kappa")
    certificate = Certificate("undecided", "stuck", (point,), doubts=(doubt,))
    figure = draw_certificate(DISC, certificate)
    assert "degenerate" in legend(figure)
    assert "undecided, box 1 wide" in legend(figure)
    (frame,) = frames(figure)
    assert (frame.get_width(), frame.get_height()) == (0.5, 1.0)


def test_the_way_into_a_trap_and_the_certified_region_are_drawn():
    start = (-3.0, 0.5)
    trap = Trap(Box(-0.98, -0.97, -0.01, 0.01), -0.97537, 0.0, "goal", start)
    level = float(psi([1.0, 1.0], WALL))
    certificate = Certificate("refuted", "a trap", traps=(trap,), region=level)
    figure = draw_certificate(WALL, certificate)
    assert {"a way into it", "rim of what was certified"} <= set(legend(figure))
    (way,) = [
        line for line in figure.axes[0].lines if line.get_label() == "a way into it"
    ]
    points = np.column_stack(way.get_data())
    np.testing.assert_allclose(points[0], start)
    # The roll-out stops where no step lowers phi any more.
    np.testing.assert_allclose(points[-1], (-0.97537, 0.0), atol=1e-3)


@pytest.mark.parametrize(
    "field",
    [
        world([3.0, 0.0, 1.0, 1.0, 0.0]),
        world([0.0, 0.0, 9.0, 9.0, 0.0]),
        world(),
        world().with_goal(np.array([9.0, 0.0])),
        world([0.0, 0.0, 1e200, 1e-200, 0.0]),
    ],
    ids=["goal covered", "all covered", "empty", "goal outside", "extreme"],
)
def test_a_world_that_is_no_world_has_a_picture_too(field):
    # Warnings are errors here: a picture of nothing must not divide by nothing.
    figure = draw_certificate(field, certify(field), np.array([-2.0, 1.0]))
    assert "goal" in legend(figure)
