"""The simulated ingot line."""
