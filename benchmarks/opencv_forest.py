"""OpenCV's structured edge detection as a timed child process: contrib's OpenCV cannot share an environment with ours.

Arguments: the model. Each line of standard input, `threads image.npy`, is answered by wall and CPU milliseconds of one
call of detectEdges; reading the image is not counted.
"""

import sys
import time

import cv2
import numpy as np


def main():
    detector = cv2.ximgproc.createStructuredEdgeDetection(sys.argv[1])
    print("ready", flush=True)
    for line in sys.stdin:
        threads, path = line.split(maxsplit=1)
        image = np.load(path.strip())
        cv2.setNumThreads(int(threads))
        wall, cpu = time.perf_counter(), time.process_time()
        detector.detectEdges(image)
        print(1000 * (time.perf_counter() - wall), 1000 * (time.process_time() - cpu), flush=True)


if __name__ == "__main__":
    main()
