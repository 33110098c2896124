"""Names of the bits in the words of faults and reasons, for documents and for people who look at a gauge."""

from appliance.diagnostics.fault_table import FAULTS
from plc.codes import Bits, NamedBit
from vision.reasons import INGOT_REASONS, REASONS


def named_bits() -> Bits:
    """Bits of `reason_word`, `ingot_reason_word` and `fault_word`; those of faults with their remedy."""
    return {
        "reason_word": [NamedBit(row.flag.bit_length() - 1, row.name, row.text) for row in REASONS],
        "ingot_reason_word": [NamedBit(row.flag.bit_length() - 1, row.name, row.text) for row in INGOT_REASONS],
        "fault_word": [
            NamedBit(row.bit, row.name, f"{row.text}; {row.remedy}") for row in sorted(FAULTS, key=lambda row: row.bit)
        ],
    }
