"""The edge network of `appliance.training.edge_network`, run by OpenCV's DNN module."""

from pathlib import Path

import cv2
import numpy as np

from appliance.training.edge_network import CELL_PX, REACH_PX, network_input

BORDER_PX = REACH_PX + CELL_PX


class EdgeNetwork:
    """Edge strength of whole pictures, 0 to 1, smoothed by [1 2 1] / 4 as the forest's."""

    def __init__(self, model: Path) -> None:
        self._net = cv2.dnn.readNetFromONNX(np.fromfile(model, np.uint8))

    def strength(self, image):
        """Strength of a picture, float32 grey or RGB, shape (rows, columns)."""
        rows, columns = image.shape[:2]
        around = (BORDER_PX, BORDER_PX + rows % CELL_PX, BORDER_PX, BORDER_PX + columns % CELL_PX)
        seen = cv2.copyMakeBorder(image, *around, cv2.BORDER_REFLECT)
        colour = seen if seen.ndim == 3 else np.repeat(seen[..., None], 3, axis=2)
        self._net.setInput(np.ascontiguousarray(network_input(colour).transpose(2, 0, 1)[None]))
        found = self._net.forward()[0, 0, BORDER_PX : BORDER_PX + rows, BORDER_PX : BORDER_PX + columns]
        kernel = np.array([0.25, 0.5, 0.25])
        return cv2.sepFilter2D(found, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_REFLECT_101)
