"""Checkerboards, cameras, rigs and the world frame."""
