"""One Drake LeafSystem a file; the mathematics is in the pure packages."""
