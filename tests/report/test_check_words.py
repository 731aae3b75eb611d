"""Checks are told in words, their units in brackets."""

from dataclasses import fields

import pytest

from bath_drake.report.tables import words
from bath_drake.scenario import Limits


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("skin_speed_m_per_s", "skin speed [m/s]"),
        ("wound_wetted_cm2", "wound wetted [cm²]"),
        ("force_mean_error", "force: mean error [N]"),
        ("frechet_executed", "Fréchet executed"),
    ],
)
def test_a_key_is_told_with_its_unit(name, told):
    assert words(name) == told


def test_no_limit_is_told_with_half_a_unit():
    for field in fields(Limits):
        assert " per " not in words(field.name)
        assert "_" not in words(field.name)
