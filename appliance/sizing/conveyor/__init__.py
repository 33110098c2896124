"""Sizing with one camera that nobody calibrated, between two barriers."""
