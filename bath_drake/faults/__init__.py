"""Faults to test the guard with: what breaks, when, and what is expected then."""
