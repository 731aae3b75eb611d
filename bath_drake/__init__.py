"""Washing motions learned from a carer with navigation functions, on Drake.

Research software: not certified, and not for use on people without the
supervision and the safeguards that such use demands.
"""

__version__ = "0.1.0"
