"""The checkerboard: on paper, and before both cameras."""
