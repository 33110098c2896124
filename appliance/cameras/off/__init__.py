"""No camera: its station is off."""
