"""One picture out of two aligned views: by Fourier transform, wavelets, a pyramid or plainly, and how good it is."""
