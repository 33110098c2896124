"""Checkerboards as the simulated cameras see them."""
