"""Navigation functions: obstacles, potential, flow and its critical points (pure)."""
