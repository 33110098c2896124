"""Scenes of the sizing line: bars, their surface and surroundings, what disturbs them."""
