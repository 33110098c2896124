"""Fusion of two aligned views by Fourier transform, wavelets, a pyramid or pixel by pixel; its figures of merit."""
