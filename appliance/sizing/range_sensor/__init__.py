"""A laser that measures the range to the bar at one point, beside the two cameras."""
