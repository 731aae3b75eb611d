import math

import pytest

from bath_drake.benchmarks.perception import sensor
from bath_drake.perception.depth_sensor import CAMERA_MODELS


@pytest.fixture
def report(monkeypatch):
    monkeypatch.setattr(sensor, "FRAMES", 3)
    monkeypatch.setattr(sensor, "REPEATS", 1)
    monkeypatch.setattr(sensor, "DEPTHS", (1.2,))
    shares = []
    found = sensor.run(lambda what, share: shares.append(share))
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    return found


def test_every_model_is_timed_and_measured(report):
    names = {figure.name for figure in report.figures}
    for model in CAMERA_MODELS:
        assert f"sensor_depth_noise_{model}" in names
        assert f"sensor_sigma_{model}_ratio_off" in names
    assert "sensor_colour_noise" in names
    assert all(f.target is not None and math.isfinite(f.value) for f in report.figures)
    assert len(report.rows) == len(CAMERA_MODELS) * len(sensor.ANGLES_DEG)


def test_the_measured_deviation_is_that_of_the_rows_sensor(report):
    for row in report.rows:
        # 33,000 pixels; where 25 share a grain, 1,300 of them: known to 2 %.
        assert row["ratio"] == pytest.approx(1.0, abs=0.06)


def test_a_noise_that_is_not_its_formula_is_noticed(monkeypatch):
    monkeypatch.setattr(sensor, "FRAMES", 2)
    real = sensor.axial_deviation
    monkeypatch.setattr(sensor, "axial_deviation", lambda *a: 1.1 * real(*a))
    kinect = CAMERA_MODELS["kinect_v2"]
    row = sensor._row("kinect_v2", kinect.sensor, kinect.camera, 1.2, 0.0)
    assert row["ratio"] < 1.0 - sensor.RATIO
