"""Settings shared by all tests."""

import os

import numpy as np
import pytest
from hypothesis import settings
from stale_caches import drop_stale_caches

# The first example of a property may wait for a compiler, and machines are busy: no
# deadline. The same examples every time: a failure in one run is one in the next.
# BATH_DRAKE_EXAMPLES=100 and more looks further than every run can.
settings.register_profile(
    "bath_drake",
    deadline=None,
    derandomize=True,
    max_examples=int(os.environ.get("BATH_DRAKE_EXAMPLES", "40")),
)
settings.load_profile("bath_drake")


def pytest_sessionstart(session):
    # Once for all processes, before the first of them is started.
    if not hasattr(session.config, "workerinput"):
        drop_stale_caches()


# What takes longest begins first: at the end no core waits for another's long file.
LONGEST = [
    "test_simulation.py",
    "test_fault_matrix.py",
    "test_touch_loop.py",
    "test_fast_loop.py",
    "test_soak.py",
    "test_learner.py",
    "test_tutorials.py",
    "test_report_page.py",
]


def pytest_collection_modifyitems(items):
    def place(item):
        name = item.path.name
        return LONGEST.index(name) if name in LONGEST else len(LONGEST)

    items.sort(key=place)


@pytest.fixture
def unsaved_figures(monkeypatch):
    """A report's figures are drawn, but not saved: half of what a report takes."""
    monkeypatch.setattr(
        "bath_drake.report.style.as_data_uri", lambda figure, raster: "data:image/png,"
    )


@pytest.fixture
def rng():
    return np.random.default_rng(2025)
