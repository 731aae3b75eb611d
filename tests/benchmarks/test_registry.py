from dataclasses import fields
from pathlib import Path

import pytest

from bath_drake.benchmarks import registry
from bath_drake.benchmarks.figures import Settings
from bath_drake.benchmarks.registry import BENCHMARKS, NAMES, Benchmark, find
from bath_drake.errors import BathDrakeError

GIVEN = [
    (Settings(data=Path("data")), "--data"),
    (Settings(held_out=True), "--held-out"),
    (Settings(peers=True), "--peers"),
    (Settings(hours=2.0), "--hours"),
    (Settings(shapes=("w",)), "--shapes"),
    (Settings(quick=True), "--quick"),
]


def test_every_benchmark_has_one_of_the_fixed_names():
    assert set(BENCHMARKS) <= set(NAMES)
    assert {"field", "strokes", "lasa"} <= set(BENCHMARKS)


def test_every_benchmark_uses_settings_that_exist():
    known = {field.name for field in fields(Settings)}
    for benchmark in BENCHMARKS.values():
        assert benchmark.uses <= known


def test_a_benchmark_is_found_by_name():
    assert find("field", Settings()) is BENCHMARKS["field"]


def test_every_name_the_command_line_has_is_a_benchmark():
    assert set(NAMES) == set(BENCHMARKS)


def test_other_names_are_refused():
    with pytest.raises(BathDrakeError, match="wash: no such benchmark; available"):
        find("wash", Settings())


@pytest.mark.parametrize(("settings", "option"), GIVEN)
def test_an_option_that_a_benchmark_does_not_use_is_refused(settings, option):
    with pytest.raises(BathDrakeError) as caught:
        find("field", settings)
    assert str(caught.value) == (
        f"field: {option} is none of its options, allowed: --json"
    )


def test_an_option_that_a_benchmark_uses_is_passed_on(monkeypatch):
    lasa = Benchmark(lambda settings, progress: [], frozenset({"data", "held_out"}))
    monkeypatch.setitem(BENCHMARKS, "lasa", lasa)
    assert find("lasa", Settings(data=Path("d"), held_out=True)) is lasa
    assert registry.users("held_out") == "used by strokes, lasa"
    with pytest.raises(BathDrakeError, match=r"--json, --data, --held-out$"):
        find("lasa", Settings(peers=True))
