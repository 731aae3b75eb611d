"""Benchmarks of `bath-drake bench`: one module each, and what they share."""
