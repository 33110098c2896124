"""Where image pairs come from, all behind one protocol."""
