"""One field for a whole stroke: a population over branches and counts."""
