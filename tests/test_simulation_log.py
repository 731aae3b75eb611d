import dataclasses
from dataclasses import fields

import numpy as np
import pytest

from bath_drake.errors import RunFolderError
from bath_drake.safety.reasons import Reason
from bath_drake.simulation_log import SimulationLog


@pytest.fixture
def log():
    arrays = {f.name: np.arange(6.0).reshape(3, 2) for f in fields(SimulationLog)}
    return SimulationLog(**{**arrays, "outcome": "GOAL_REACHED"})


def test_a_log_reads_back_bit_by_bit(log, tmp_path):
    path = tmp_path / "log.npz"
    log.save(path)
    back = SimulationLog.load(path)
    assert back.outcome == log.outcome
    for field in fields(log):
        if field.name != "outcome":
            expected = getattr(log, field.name)
            np.testing.assert_array_equal(getattr(back, field.name), expected)


def test_the_real_time_factor_leaves_out_the_first_stretch(log):
    # Rows (simulated, wall): (0, 1), (2, 3), (4, 5).
    assert log.real_time_factor == (4.0 - 2.0) / (5.0 - 3.0)
    short = dataclasses.replace(log, wall_time=np.array([[0.0, 0.0], [1.0, 4.0]]))
    assert short.real_time_factor == 0.25


@pytest.mark.parametrize("content", [b"", b"junk", b"PK\x03\x04junk"])
def test_a_damaged_log_is_refused_by_its_name(tmp_path, content):
    path = tmp_path / "log.npz"
    path.write_bytes(content)
    with pytest.raises(RunFolderError, match=r"log\.npz"):
        SimulationLog.load(path)


def test_a_log_that_lacks_a_series_says_which(tmp_path):
    path = tmp_path / "log.npz"
    np.savez(path, time=np.zeros(3))
    with pytest.raises(RunFolderError, match="canonical_position"):
        SimulationLog.load(path)


def test_a_log_from_when_there_were_fewer_reasons_to_hold_is_read(log, tmp_path):
    path = tmp_path / "log.npz"
    dataclasses.replace(log, guard_counts=np.array([0.0, 1.0, 2.0])).save(path)
    counts = SimulationLog.load(path).guard_counts
    assert len(counts) == len(Reason)
    np.testing.assert_array_equal(counts[:3], [0.0, 1.0, 2.0])
    assert not counts[3:].any()
