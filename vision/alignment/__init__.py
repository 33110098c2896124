"""Alignment of the right view to the left one by virtual boards."""
