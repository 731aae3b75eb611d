import subprocess
import sys

import pytest

from bath_drake import __version__, cli


def run(capsys, *words):
    try:
        code = cli.main(words)
    except SystemExit as stop:
        code = stop.code
    return code, *capsys.readouterr()


def test_help_lists_every_verb(capsys):
    code, out, _ = run(capsys, "--help")
    assert code == 0
    for verb in cli.VERBS:
        assert verb in out


def test_the_version_is_that_of_the_package(capsys):
    assert run(capsys, "--version")[:2] == (0, f"{__version__}\n")


@pytest.mark.parametrize("verb", sorted(cli.VERBS))
def test_every_verb_explains_itself(capsys, verb):
    code, out, _ = run(capsys, verb, "--help")
    assert code == 0
    assert "usage: bath-drake" in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "VERB"),
        (("wash",), "wash"),
        (("doctor", "--colour"), "--colour"),
        (("simulate", "no_such"), "no such scenario"),
        (("simulate", "reproduction", "--person", "nobody"), "no such folder"),
        (("simulate", "reproduction", "--seconds", "-1"), "--seconds"),
        (("simulate", "reproduction", "--skill", "none.yaml"), "none.yaml"),
        (("simulate", "reproduction", "--record", "/dev/null"), "not a folder"),
        (("report", "/no/such/run"), "/no/such/run"),
        (("diagram", "no_such"), "no such scenario"),
        (("capture", "no_such", "-o", "demo.csv"), "no_such"),
        (("learn", "no_such.csv", "-o", "s.yaml"), "no_such.csv"),
        (("certify", "no_such.yaml"), "no_such.yaml"),
        (("bench", "speed"), "speed: no such benchmark"),
        (("bench", "field", "--hours", "1"), "--hours"),
        (("reproduce", "no_such.yaml", "--start", "-9.3e-05", "0.2"), "no_such.yaml"),
    ],
)
def test_bad_input_is_one_line_on_standard_error_and_code_2(
    capsys, tmp_path, monkeypatch, words, message
):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, *words)
    assert code == cli.BAD_INPUT
    assert out == ""
    assert err.count("\n") == 1
    assert message in err
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


def test_it_runs_as_a_module():
    command = [sys.executable, "-m", "bath_drake", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == __version__
