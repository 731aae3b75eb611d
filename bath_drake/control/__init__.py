"""From a canonical velocity to a smooth nozzle motion: the arithmetic (pure)."""
