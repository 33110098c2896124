"""Measuring on images: arrays in, values out; no clock, no files of settings, no sockets."""
