"""Other people's recordings become demonstrations: a module a format (pure)."""
