"""Sizing with two calibrated cameras."""
