"""The experiments of the dissertation, made again: `hotgauge reproduce`."""
