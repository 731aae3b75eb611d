import json
from pathlib import Path

import numpy as np
import pytest

from bath_drake.errors import RunFolderError
from bath_drake.run_folder import make_run_folder, verdict_lines, write_metrics

METRICS = {
    "verdict": "fail",
    "checks": {
        "reached_goal": {"value": True, "limit": True, "pass": True},
        "frechet_executed": {"value": 0.09123456, "limit": 0.08, "pass": False},
        "surface_error_mean_mm": {"value": None, "limit": 5.0, "pass": False},
    },
    "real_time_factor": 0.5,
}


def read_strictly(path):
    def refuse(constant):
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def test_metrics_are_strict_json_that_reads_back(tmp_path):
    path = tmp_path / "metrics.json"
    write_metrics(path, METRICS)
    assert read_strictly(path) == METRICS
    assert path.read_text().endswith("}\n")


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf")])
def test_a_number_that_json_does_not_know_is_refused_with_nothing_written(
    tmp_path, number
):
    path = tmp_path / "metrics.json"
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_metrics(path, {"a": {"b": [number]}})
    assert list(tmp_path.iterdir()) == []


def test_what_was_there_stays_when_writing_fails(tmp_path):
    path = tmp_path / "metrics.json"
    write_metrics(path, METRICS)
    with pytest.raises(TypeError):
        write_metrics(path, {"array": np.zeros(2)})
    assert read_strictly(path) == METRICS
    assert [p.name for p in tmp_path.iterdir()] == ["metrics.json"]


def test_the_verdict_is_told_check_by_check():
    lines = verdict_lines(METRICS)
    for name, check in METRICS["checks"].items():
        (line,) = [line for line in lines if name in line]
        assert line.startswith("pass" if check["pass"] else "FAIL")
    assert "0.09123" in "\n".join(lines)
    assert lines[-1] == "verdict: fail"


def test_a_folder_is_made_with_its_parents_and_left_clean(tmp_path):
    folder = tmp_path / "a" / "b"
    make_run_folder(folder)
    (folder / "kept.txt").write_text("x")
    make_run_folder(folder)
    assert [p.name for p in folder.iterdir()] == ["kept.txt"]


def test_a_file_is_no_folder(tmp_path):
    path = tmp_path / "file"
    path.write_text("x")
    for folder in (path, path / "below"):
        with pytest.raises(RunFolderError, match="not a folder to write to"):
            make_run_folder(folder)


def test_a_folder_that_cannot_be_written_to_is_refused(tmp_path, monkeypatch):
    # Not by its mode: root, as in many containers, may write anywhere.
    def refuse(path):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "touch", refuse)
    with pytest.raises(RunFolderError, match=r"not a folder .* \(Permission denied\)"):
        make_run_folder(tmp_path)
