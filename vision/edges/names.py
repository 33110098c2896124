"""Names of edge detectors and of Canny's kernels, for settings and commands that must load no image library."""

from typing import Literal, get_args

EdgeMethod = Literal["forest", "sobel", "prewitt", "roberts", "canny"]
CannyKernel = Literal["gaussian", "3x3", "5x5"]

EDGE_METHODS: tuple[EdgeMethod, ...] = get_args(EdgeMethod)
CANNY_KERNELS: tuple[CannyKernel, ...] = get_args(CannyKernel)
