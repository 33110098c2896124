"""Limits that every sizing method keeps: of the bar, of its limbs and of overexposure."""

FIRST_BLUR_PX = 1.5  # taken until the edge's own is known
LEAST_POINTS = 12  # fewer are no limb
CLIPPED_FEW = 0.05  # share of a limb's points: below it a channel is as good as unclipped
WEAK_CONTRAST = 2.0  # light of the bar over that of its background
CLIPPED_MOST = 0.5  # share of a limb's points: beyond it there is nothing left to measure
DIAMETER_MM = (40.0, 500.0)
SIDES = (-1, +1)
OFF_ROLLERS_SHARE, OFF_ROLLERS_MM = 0.02, 12.0  # of the diameter, and beside it: how high a bar may bounce
