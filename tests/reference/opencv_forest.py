"""Runs in the environment that has OpenCV contrib: MODEL IMAGE OUTPUT ..., edge strength of each image."""

import sys

import cv2
import numpy as np


def main():
    detector = cv2.ximgproc.createStructuredEdgeDetection(sys.argv[1])
    for image, output in zip(sys.argv[2::2], sys.argv[3::2], strict=True):
        np.save(output, detector.detectEdges(np.load(image)))


if __name__ == "__main__":
    main()
