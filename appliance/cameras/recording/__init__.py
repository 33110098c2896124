"""Recordings in place of cameras."""
