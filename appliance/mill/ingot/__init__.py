"""The simulated ingot line: ingots that a crane sets on rollers, seen from their ends by one camera."""
