"""The benchmark of washing tells the worst of everybody, and misses what is missing."""

import json

import numpy as np
import pytest

from bath_drake.benchmarks import washing

METRICS = {
    "verdict": "pass",
    "coverage": 0.99,
    "washing": {"target_cm2": 400.0, "wound_wetted_cm2": 0.0},
    "restricted_entries": 0,
    "time_to_goal_s": 20.0,
    "speed_m_per_s": {"mean": 0.05, "max": 0.08},
    "force": None,
    "touched_skin_mm": None,
}
FORCE = {
    "mean": 4.1,
    "mean_error": 0.2,
    "within_2_n": 1.0,
    "peak": 5.0,
    "contact_share": 1.0,
}
FELT = METRICS | {"force": FORCE, "touched_skin_mm": {"mean": 0.7, "max": 3.0}}


def rows(changed="wash_contact", **changes):
    """Two people, all well, but for what is changed of the second's contact."""
    found = []
    for person, more in (("f_avg", {}), ("m_avg", changes)):
        for name in (*washing.SCENARIOS, washing.SEEN):
            metrics = FELT if name.startswith("wash_contact") else METRICS
            metrics = metrics | more if name == changed else metrics
            found.append(washing.row_of(name, person, metrics))
    return found


def missed(found):
    return [figure.name for figure in washing.figures(found) if not figure.passed]


def test_all_well_misses_nothing():
    assert missed(rows()) == []


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"verdict": "fail"}, "wash_contact_passed"),
        ({"force": FORCE | {"mean_error": 0.6}}, "contact_force_error"),
        ({"force": FORCE | {"contact_share": 0.9}}, "contact_share"),
        ({"force": FORCE | {"peak": None}}, "contact_peak"),
        ({"touched_skin_mm": {"mean": None, "max": None}}, "contact_touched_skin"),
    ],
)
def test_the_worst_of_everybody_counts_and_so_does_what_is_missing(changes, name):
    assert missed(rows(**changes)) == [name]


def test_contact_through_the_camera_is_told_apart():
    found = rows(washing.SEEN, force=FORCE | {"contact_share": 0.6})
    assert missed(found) == ["seen_contact_share"]
    quick = [row for row in found if row["scenario"] != washing.SEEN]
    names = [figure.name for figure in washing.figures(quick)]
    assert missed(quick) == []
    assert not any("seen" in name for name in names)


def test_a_row_holds_plain_values():
    row = washing.row_of("pour", "f_avg", METRICS)
    assert np.isnan(row["force, N"])
    json.dumps(row)
