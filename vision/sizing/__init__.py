"""The diameter of a bar from a pair of images."""
