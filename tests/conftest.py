"""Settings shared by all tests."""

from hypothesis import settings

# The first example of a property may wait for a compiler, and machines are busy: no
# deadline. The same examples every time: a failure in one run is one in the next.
settings.register_profile("bath_drake", deadline=None, derandomize=True)
settings.load_profile("bath_drake")
