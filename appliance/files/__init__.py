"""How files are written; the standard library only."""
