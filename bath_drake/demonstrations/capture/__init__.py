"""A washing demonstration out of an RGB-D recording of a marker on a back."""
