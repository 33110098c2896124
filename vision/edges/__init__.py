"""Where edges are, to a fraction of a pixel."""
