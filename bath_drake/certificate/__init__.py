"""Proofs by interval arithmetic that a field has no trap (pure)."""
