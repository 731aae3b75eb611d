import dataclasses

import numpy as np
import pytest
from pydrake.common.value import Value

from bath_drake.perception.canonical import fit_canonical_map
from bath_drake.perception.segmentation import UP_W, BodyObservation
from bath_drake.systems.canonical_projector import CanonicalProjector, unknown_map


@pytest.fixture
def observation():
    rng = np.random.default_rng(5)
    points = rng.uniform(-1, 1, (2000, 3)) * [0.17, 0.02, 0.25] + [0.7, 0.0, 0.9]
    return dataclasses.replace(
        BodyObservation(),
        found=True,
        completed_points_W=points,
        completed_areas=rng.uniform(1e-5, 2e-5, 2000),
        p_WC=np.array([0.7, -1.3, 1.5]),
    )


def _map(observation):
    dut = CanonicalProjector()
    context = dut.CreateDefaultContext()
    dut.GetInputPort("body_observation").FixValue(context, Value(observation))
    return dut.GetOutputPort("canonical_map").Eval(context)


def test_the_map_is_that_of_the_pure_function(observation):
    expected = fit_canonical_map(
        observation.completed_points_W,
        UP_W,
        observation.p_WC,
        observation.completed_areas,
    )
    fitted = _map(observation)
    for name in ("R_WP", "p_WP", "half_extents"):
        np.testing.assert_array_equal(getattr(fitted, name), getattr(expected, name))


def test_a_lost_body_leaves_the_last_good_map(observation):
    lost = dataclasses.replace(observation, found=False, points_W=np.zeros((0, 3)))
    np.testing.assert_array_equal(_map(lost).p_WP, _map(observation).p_WP)


def test_before_any_body_the_map_is_the_unknown_one():
    np.testing.assert_array_equal(_map(BodyObservation()).R_WP, unknown_map().R_WP)


def test_another_value_is_refused_by_name():
    dut = CanonicalProjector()
    context = dut.CreateDefaultContext()
    dut.GetInputPort("body_observation").FixValue(context, Value(unknown_map()))
    with pytest.raises(TypeError, match="body_observation"):
        dut.GetOutputPort("canonical_map").Eval(context)
