"""Chains of fields: a stroke cut into stages, each learned by itself."""
