"""A short recording of the ingot line for the whole appliance: parts of the path-traced sequences in a row."""

import shutil


def write_recording(folder, source, *parts):
    """Copy frames, in order, into one recording; a part is a sequence and its frames."""
    folder.mkdir(parents=True)
    pictures = [source / sequence / f"{frame:06d}.jpg" for sequence, frames in parts for frame in frames]
    for number, picture in enumerate(pictures):
        shutil.copyfile(picture, folder / f"{number:06d}.jpg")
    return folder


EMPTY = ("seq01", [0, 1, 2, 3, 0, 1, 2, 3])
BOTTOM = ("seq01", [5, 7, 8, *range(9, 72, 3), 73, 74, 75, 76, 77, 78, 0, 1])
TOP = ("seq03", [3, 6, 9, 10, *range(11, 34), 34, 35, 36, 37, 38, 39, 40, 41])
