"""Sizing with one uncalibrated camera between two barriers of known distance."""
