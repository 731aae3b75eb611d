"""From a depth image to the canonical map and the surface (pure)."""
