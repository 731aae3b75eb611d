"""Hypothesis settings for tests whose first example waits for a compiler."""

from hypothesis import settings

settings.register_profile("compiled", deadline=None, derandomize=True)
settings.load_profile("compiled")
