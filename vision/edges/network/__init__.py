"""Edges by a small convolutional network that was trained on rendered scenes alone."""
