"""Chains of navigation fields: strokes that no single field can hold."""
