"""Commands that read or draw pictures: calibrate, measure, orient, fuse, verify, simulate, train-edges."""
