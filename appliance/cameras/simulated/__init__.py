"""The simulated mill, ingot line and thermal line in place of cameras."""
