"""Settings shared by all tests."""

import numpy as np
import pytest
from hypothesis import settings
from stale_caches import drop_stale_caches

# The first example of a property may wait for a compiler, and machines are busy: no
# deadline. The same examples every time: a failure in one run is one in the next.
settings.register_profile("bath_drake", deadline=None, derandomize=True)
settings.load_profile("bath_drake")


def pytest_sessionstart():
    drop_stale_caches()


@pytest.fixture
def rng():
    return np.random.default_rng(2025)
