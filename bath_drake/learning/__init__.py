"""From canonical strokes to a skill (pure)."""
