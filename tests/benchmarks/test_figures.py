import json

import pytest

from bath_drake.benchmarks.figures import (
    Figure,
    all_passed,
    row_table,
    table,
    to_mapping,
)

FAST = Figure("proof_median", 4.25, "ms", 6.0)
SLOW = Figure("proof_worst", 61.0, "ms", 50.0)
MANY = Figure("boxes", 1_000_000, "", 1_000_000, "at least")
RATIO = Figure("speedup", 12.345678, "x numpy")


@pytest.mark.parametrize(
    ("value", "bound", "passed"),
    [
        (5.0, "at most", True),
        (6.0, "at most", True),
        (6.1, "at most", False),
        (5.9, "at least", False),
        (6.0, "at least", True),
        (float("nan"), "at most", False),
        (float("nan"), "at least", False),
    ],
)
def test_a_target_is_met_up_to_and_with_its_bound(value, bound, passed):
    assert Figure("x", value, "s", 6.0, bound).passed is passed


def test_information_cannot_miss():
    assert RATIO.passed
    assert all_passed([FAST, MANY, RATIO])
    assert not all_passed([FAST, SLOW])


def test_the_table_is_aligned_and_ends_with_the_verdict():
    assert table([FAST, SLOW, MANY, RATIO]).splitlines() == [
        "figure            value unit     target",
        "proof_median       4.25 ms       at most 6           met",
        "proof_worst          61 ms       at most 50          MISSED",
        "boxes         1,000,000          at least 1,000,000  met",
        "speedup           12.35 x numpy",
        "2 of 3 targets met; missed: proof_worst",
    ]


def test_without_a_miss_the_verdict_is_short():
    assert table([FAST]).splitlines()[-1] == "1 of 1 targets met"


def test_the_mapping_holds_value_target_unit_and_pass():
    found = to_mapping([FAST, SLOW, RATIO])
    assert found["proof_median"] == {
        "value": 4.25,
        "target": 6.0,
        "unit": "ms",
        "bound": "at most",
        "pass": True,
    }
    assert found["proof_worst"]["pass"] is False
    assert found["speedup"]["target"] is None
    assert found["speedup"]["pass"] is True
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_what_is_not_a_number_is_null_in_json():
    found = to_mapping([Figure("x", float("nan"), "s", 1.0)])
    assert found["x"]["value"] is None
    assert found["x"]["pass"] is False


def test_two_figures_of_one_name_are_a_bug():
    with pytest.raises(ValueError, match="two figures are called proof_median"):
        to_mapping([FAST, FAST])


def test_rows_of_different_columns_are_one_table():
    rows = [{"row": "first", "seconds": 1.0}, {"row": "second", "mm": 2.5}]
    lines = [line.split() for line in row_table(rows).splitlines()]
    assert lines == [["row", "seconds", "mm"], ["first", "1"], ["second", "2.5"]]
