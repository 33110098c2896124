"""Limits that every sizing method keeps: of the bar, of its limbs (the edges of the bar) and of overexposure."""

DIAMETER_MM = (40.0, 500.0)  # chosen: a diameter outside this range is `implausible` and is not served
OFF_ROLLERS_SHARE, OFF_ROLLERS_MM = 0.02, 12.0  # chosen: a bar hops up to 2 % of its diameter + 12 mm off the rollers
COVERED_SHARE = 0.5  # chosen: a bar that shows in less of the measuring region is `bar_too_short`
LIMB_SIDES = (-1, +1)  # of the limb at smaller x, of the limb at larger x
LEAST_POINTS = 12  # chosen: fewer edge points than these are no limb
FIRST_BLUR_PX = 1.5  # chosen: standard deviation of an edge's blur until it is estimated from the edge itself
WEAK_CONTRAST = 2.0  # chosen: below this ratio of the bar's light to its background's the reading is `low_contrast`
CLIPPED_FEW_SHARE = 0.05  # chosen: a colour channel with fewer overexposed points on a limb is used as unclipped
CLIPPED_MOST_SHARE = 0.5  # chosen: beyond this share of overexposed points a limb is `edges_clipped`, not measured
