"""Verification of the gauge against a bar of known size, with a certificate that can be audited."""
