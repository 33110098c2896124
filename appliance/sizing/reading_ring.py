"""The ring of the last readings, for PLCs that poll slowly."""

from collections.abc import Mapping

from plc.rings import READING_FIELDS, SLOTS
from plc.rows import Value


class ReadingRing:
    """The last readings as they were served."""

    def __init__(self) -> None:
        self._index = 0
        self._slots: dict[str, Value] = {}

    def add(self, values: Mapping[str, Value]) -> None:
        """Overwrite the oldest reading of the ring with the newest, given as register values by name."""
        slot = f"reading_{self._index % SLOTS}_"
        self._slots |= {slot + field: values.get(field) for field in READING_FIELDS}
        self._index += 1

    def values(self) -> dict[str, Value]:
        """Values of the registers, by name."""
        return {"reading_ring_index": self._index} | self._slots
