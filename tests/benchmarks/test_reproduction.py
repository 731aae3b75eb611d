import numpy as np
import pytest

from bath_drake.benchmarks.methods import (
    blended_mean,
    mean_demonstration,
    straight_line,
)
from bath_drake.benchmarks.reproduction import (
    Learned,
    Shape,
    crosses_itself,
    evaluate,
)


def arc(height, place=(0.0, 0.0), count=80):
    share = np.linspace(0.0, 1.0, count)
    points = np.stack([3.0 * share, height * np.sin(np.pi * share)], axis=-1)
    return 2.0 * share + 5.0, points + place


@pytest.fixture
def shape():
    return Shape.of("arc", [arc(0.9), arc(1.0, (4.0, 1.0)), arc(1.4, count=120)])


def test_canonical_units_end_at_the_origin_and_are_one_long(shape):
    paths = np.array([d.path for d in shape.demonstrations])
    assert paths.shape == (3, 200, 2)
    assert (paths[:, -1] == 0.0).all()
    joint = np.concatenate([d.points for d in shape.demonstrations])
    # One factor for both axes: rounding alone.
    assert np.ptp(joint, axis=0) == pytest.approx([1.0, 1.4 / 3.0], rel=1e-3)
    steps = np.linalg.norm(np.diff(paths, axis=1), axis=2)
    # Chords of equal arcs differ by the polyline's corners only.
    assert np.ptp(steps, axis=1).max() < 1e-3 * steps.mean()
    assert shape.demonstrations[0].times[0] == 0.0


def test_units_do_not_hang_on_the_demonstrations_left_out(shape):
    rest = shape.without(1)
    assert rest.name == shape.name
    assert rest.demonstrations == (shape.demonstrations[0], shape.demonstrations[2])


def test_what_repeats_the_demonstrations_has_distance_zero(shape):
    def oracle(given):
        def roll_out(start):
            near = [np.linalg.norm(d.path[0] - start) for d in given.demonstrations]
            return given.demonstrations[int(np.argmin(near))].path

        return Learned(roll_out, proved=True, obstacles=3.0)

    score = evaluate("oracle", oracle, shape)
    # Resampling what has equal steps moves points by rounding.
    assert score.frechet < 1e-4
    assert score.goal == score.proved == 1.0
    assert score.obstacles == 3.0


def test_held_out_means_that_the_method_never_sees_the_demonstration(shape):
    seen = []

    def method(given):
        seen.append(given.demonstrations)
        return Learned(lambda start: start[None])

    score = evaluate("blind", method, shape, held_out=True)
    for demonstration, given in zip(shape.demonstrations, seen, strict=True):
        assert len(given) == 2
        assert demonstration not in given
    assert score.goal == 0.0
    assert np.isnan(score.to_mean)
    # A path of one point is as far as the demonstration's furthest point.
    starts = [d.path - d.path[0] for d in shape.demonstrations]
    far = [np.linalg.norm(p, axis=1).max() for p in starts]
    assert score.frechet == pytest.approx(np.mean(far))
    assert score.worst == pytest.approx(max(far))


def test_a_roll_out_that_diverges_scores_badly_but_finitely(shape):
    def method(given):
        return Learned(lambda start: np.array([start, [1e9, 0.0], [np.nan, 0.0]]))

    score = evaluate("wild", method, shape)
    assert 5.0 < score.frechet < 15.0
    assert score.goal == 0.0


def test_a_roll_out_that_is_never_finite_stays_at_the_start(shape):
    score = evaluate("none", lambda given: Learned(lambda q: q[None] * np.nan), shape)
    assert np.isfinite(score.frechet)


@pytest.mark.parametrize("method", [straight_line, blended_mean])
def test_simple_methods_begin_at_the_start_and_end_at_the_goal(shape, method):
    path = method(shape).roll_out(np.array([-0.8, 0.3]))
    np.testing.assert_allclose(path[0], [-0.8, 0.3], rtol=0.0, atol=1e-15)
    assert (path[-1] == 0.0).all()


def test_the_mean_is_the_mean_wherever_the_start_is(shape):
    path = mean_demonstration(shape).roll_out(np.array([-0.8, 0.3]))
    np.testing.assert_array_equal(path, shape.mean)
    score = evaluate("mean", mean_demonstration, shape)
    assert score.to_mean == pytest.approx(0.0, abs=1e-12)


def test_a_loop_crosses_itself_and_an_arc_does_not():
    angle = np.linspace(-np.pi, np.pi, 200)
    loop = np.stack([angle - 2.0 * np.sin(angle), -2.0 * np.cos(angle)], axis=-1)
    assert crosses_itself(loop)
    assert not crosses_itself(arc(2.0)[1])
    # The knot of a resting hand is none.
    path = arc(2.0, count=200)[1]
    path[3:6] = path[[5, 3, 4]]
    assert not crosses_itself(path)
