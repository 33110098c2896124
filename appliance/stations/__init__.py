"""The measuring processes."""
