"""The simulated mill, with known truth; it shares no code with the gauge that it tests."""
