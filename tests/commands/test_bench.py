import json
import sys

import pytest

from bath_drake import __version__, cli
from bath_drake.benchmarks.figures import Figure, Report
from bath_drake.benchmarks.registry import BENCHMARKS, Benchmark


class FakeBenchmark:
    """Measures nothing, at once."""

    def __init__(self, value):
        self.value = value
        self.asked = []

    def __call__(self, settings, progress):
        self.asked.append(settings)
        progress("pretending", 0.5)
        return [Figure("time", self.value, "s", 1.0), Figure("count", 3)]


@pytest.fixture
def fake(monkeypatch):
    fake = FakeBenchmark(0.5)
    uses = frozenset({"data", "held_out", "peers", "hours"})
    monkeypatch.setitem(BENCHMARKS, "soak", Benchmark(fake, uses))
    return fake


def bench(capsys, *words):
    code = cli.main(["bench", *map(str, words)])
    return code, *capsys.readouterr()


@pytest.mark.parametrize(("value", "code"), [(0.5, 0), (2.0, 1)])
def test_the_exit_code_says_whether_all_targets_are_met(capsys, fake, value, code):
    fake.value = value
    found, out, err = bench(capsys, "soak")
    assert found == code
    assert out.splitlines()[0].split() == ["figure", "value", "unit", "target"]
    assert f"{code ^ 1} of 1 targets met" in out
    # In a pipe there is no bar.
    assert err == ""


def test_the_json_file_holds_figures_machine_and_versions(capsys, fake, tmp_path):
    path = tmp_path / "soak.json"
    assert bench(capsys, "soak", "--json", path)[0] == 0
    found = json.loads(path.read_text(encoding="utf-8"))
    assert found["benchmark"] == "soak"
    assert set(found["figures"]) == {"time", "count"}
    for figure in found["figures"].values():
        assert {"value", "target", "unit", "pass"} <= set(figure)
    assert set(found["machine"]) == {"cpu", "cores", "platform", "load"}
    assert found["machine"]["cores"] >= 1
    assert found["machine"]["cpu"]
    assert found["versions"]["bath_drake"] == __version__
    assert {"python", "numpy", "numba", "drake"} <= set(found["versions"])
    assert found["seconds"] >= 0.0
    assert list(tmp_path.iterdir()) == [path]


def test_what_is_asked_for_reaches_the_benchmark(capsys, fake, tmp_path):
    words = ("--data", tmp_path, "--held-out", "--peers", "--hours", "1.5e-3")
    assert bench(capsys, "soak", *words)[0] == 0
    (settings,) = fake.asked
    assert settings.data == tmp_path
    assert settings.held_out
    assert settings.peers
    assert settings.hours == 1.5e-3
    assert settings.shapes == ()
    assert not settings.quick


def test_shapes_are_names_with_commas_between(capsys, fake, monkeypatch):
    uses = frozenset({"shapes", "quick"})
    monkeypatch.setitem(BENCHMARKS, "soak", Benchmark(fake, uses))
    assert bench(capsys, "soak", "--shapes", "w, sine", "--quick")[0] == 0
    (settings,) = fake.asked
    assert settings.shapes == ("w", "sine")
    assert settings.quick


def test_rows_are_printed_above_the_figures(capsys, fake, monkeypatch, tmp_path):
    rows = [{"shape": "w", "frechet": 0.25, "crosses": True}]
    rows += [{"shape": "sine", "frechet": float("nan"), "crosses": False}]
    report = Report([Figure("time", 0.5, "s", 1.0)], rows)
    monkeypatch.setitem(BENCHMARKS, "soak", Benchmark(lambda *_: report))
    code, out, _ = bench(capsys, "soak", "--json", tmp_path / "soak.json")
    assert code == 0
    lines = out.splitlines()
    assert lines[:4] == [
        "shape  frechet  crosses",
        "w         0.25      yes",
        "sine                 no",
        "",
    ]
    assert lines[4].startswith("figure")
    found = json.loads((tmp_path / "soak.json").read_text(encoding="utf-8"))
    assert found["rows"] == [rows[0], {**rows[1], "frechet": None}]


def test_a_terminal_sees_a_bar(capsys, fake, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    _, out, err = bench(capsys, "soak")
    assert "pretending" in err
    assert "pretending" not in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("speed",), "speed: no such benchmark; available: field"),
        (("wash",), "wash: no such benchmark"),
        (("field", "--peers"), "field: --peers is none of its options"),
        (("soak", "--json", "no/such/folder/x.json"), "no/such/folder"),
        (("soak", "--hours", "-1"), "--hours: found -1.0, allowed"),
        (("soak", "--hours", "nan"), "--hours: found nan, allowed"),
        (("soak", "--data", "no_such"), "--data: found 'no_such'"),
    ],
)
def test_bad_input_is_one_line_and_nothing_runs(
    capsys, fake, tmp_path, monkeypatch, words, message
):
    monkeypatch.chdir(tmp_path)
    code, out, err = bench(capsys, *words)
    assert code == cli.BAD_INPUT
    assert out == ""
    assert err.startswith("bath-drake bench: ")
    assert message in err
    assert err.count("\n") == 1
    assert fake.asked == []
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_written_when_the_benchmark_fails(capsys, monkeypatch, tmp_path):
    def fails(settings, progress):
        raise RuntimeError("broken")

    monkeypatch.setitem(BENCHMARKS, "soak", Benchmark(fails))
    with pytest.raises(RuntimeError, match="broken"):
        bench(capsys, "soak", "--json", tmp_path / "soak.json")
    assert list(tmp_path.iterdir()) == []
