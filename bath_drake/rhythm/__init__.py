"""Circles and scrubbing on top of a stroke: the cycle, its room, their sum."""
