"""Network and USB cameras."""
