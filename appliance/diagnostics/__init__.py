"""Faults of the gauge and the alarms that follow from them."""
