"""Diameter from one camera between two barriers."""
