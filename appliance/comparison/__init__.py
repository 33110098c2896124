"""Readings of a recording held against its truth."""
