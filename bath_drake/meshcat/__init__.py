"""The run in Meshcat."""
