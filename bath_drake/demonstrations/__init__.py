"""From a recording to a canonical stroke (pure)."""
