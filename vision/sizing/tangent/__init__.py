"""Route T: the diameter from tangent planes."""
