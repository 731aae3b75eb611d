"""Limits and decisions that keep the loop safe (pure)."""
