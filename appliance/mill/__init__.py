"""The simulated mill: scenes with known truth, drawn by geometry of its own."""
