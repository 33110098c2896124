"""Cameras, lenses, homographies, straight lines, the turned region."""
