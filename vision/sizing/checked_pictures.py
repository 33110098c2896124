"""Pictures of a pair, checked against the rig that shall measure them."""

from vision.calibration.rig import Rig
from vision.sent_picture import Codes, SentPicture


def checked_pair(rig: Rig, left: SentPicture | Codes, right: SentPicture | Codes) -> tuple[SentPicture, SentPicture]:
    """Both pictures with their coding.

    Parameters
    ----------
    rig : Rig
    left, right : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)

    Returns
    -------
    tuple of two SentPicture

    Raises
    ------
    ValueError
        A picture is not of 8 or 16 bit, not grey or three-channel, or not of the size that the rig was calibrated for.
    """
    first = _checked("left", left, rig.left.image_size)
    return first, _checked("right", right, rig.right.image_size)


def _checked(name: str, image: SentPicture | Codes, calibrated: tuple[int, int]) -> SentPicture:
    try:
        picture = SentPicture.of(image)
    except ValueError as error:
        raise ValueError(f"{name}: {str(error).removeprefix('image: ')}") from error
    if picture.size != calibrated:
        was, now = (f"{columns} x {rows}" for columns, rows in (calibrated, picture.size))
        raise ValueError(f"{name}: the picture is {now}, the rig was calibrated for {was}")
    return picture
