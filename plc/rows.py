"""What one row of the register map is, and the rules that every version of the map keeps."""

import itertools
import math
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

Table = Literal["input", "holding", "discrete", "coil"]
Type = Literal["u16", "i16", "u32", "i32", "u64", "f32", "bool"]
Value = float | int | bool | None
WordOrder = Literal["big", "little"]
Block = Literal["measurement", "reading_ring", "ingot_ring", "bars"]

BLOCK_WORDS_MAX = 125  # what one Modbus request can read
_BLOCK_STARTS: dict[Block, int] = {"measurement": 0, "reading_ring": 300, "ingot_ring": 420, "bars": 540}
STRUCT_CODES: dict[Type, str] = {"u16": "H", "i16": "h", "u32": "I", "i32": "i", "u64": "Q", "f32": "f"}
NO_VALUE: dict[Type, float | int] = {
    "u16": 0xFFFF,
    "i16": -0x8000,
    "u32": 0xFFFFFFFF,
    "u64": 0xFFFFFFFFFFFFFFFF,
    "f32": math.nan,
}
_FLOAT32_MAX = (2 - 2**-23) * 2.0**127


@dataclass(frozen=True, kw_only=True)  # no slots: what follows from a row is worked out once, not for every image
class Register:
    """One row of the map: a value in words, or one bit.

    Attributes
    ----------
    name : str
        Name in every document and program.
    tables : tuple of {"input", "holding", "discrete", "coil"}
        Tables in which it stands, at the same address.
    address : int
        First word or bit, 0-based, as on the wire.
    type : {"u16", "i16", "u32", "i32", "u64", "f32", "bool"}
    text : str
        Meaning, for the PLC programmer.
    unit : str
        Unit of the value; empty for counts and states.
    scale : float
        value = scale x the number in the words.
    invalid : float, int or None
        The number in the words that means "no value"; None for counters, states and what the PLC writes.
    access : {"r", "rw"}
    lower, upper : float or None
        Bounds of a writable value, in its unit; 0 means "not set" and is always accepted.
    shows : str
        Row whose value this one repeats, as `diameter_u16` shows `diameter`; empty for a value of its own.
    constant : float, int or None
        What the row always reads.
    block : {"measurement", "reading_ring", "ingot_ring", "bars"} or None
        Words that are published and can be read together; None for bits and for what the PLC writes.
    """

    name: str
    tables: tuple[Table, ...]
    address: int
    type: Type
    text: str
    unit: str = ""
    scale: float = 1
    invalid: float | int | None = None
    access: Literal["r", "rw"] = "r"
    lower: float | None = None
    upper: float | None = None
    shows: str = ""
    constant: float | int | None = None
    block: Block | None = None

    @cached_property
    def words(self) -> int:
        """Words on the wire; 1 for a bit."""
        return 1 if self.type == "bool" else struct.calcsize(">" + STRUCT_CODES[self.type]) // 2

    @property
    def end(self) -> int:
        """First address behind the row."""
        return self.address + self.words

    @property
    def spare(self) -> bool:
        """Whether it is reserved for growth and reads 0."""
        return self.name.startswith(("spare_", "alarm_spare_"))

    @cached_property
    def raw_range(self) -> tuple[int, int]:
        """Smallest and largest number that the words of an integer can hold."""
        bits = 16 * self.words
        return (-1 << bits - 1, (1 << bits - 1) - 1) if self.type[0] == "i" else (0, (1 << bits) - 1)

    @property
    def raw_bounds(self) -> tuple[int, int]:
        """Smallest and largest number that the PLC may write, 0 apart."""
        if self.lower is None or self.upper is None:
            return self.raw_range
        return round(self.lower / self.scale), round(self.upper / self.scale)

    def accepts(self, raw: int) -> bool:
        """Whether the PLC may write this number: 0 or a number within the bounds."""
        lowest, highest = self.raw_bounds
        return raw == 0 or lowest <= raw <= highest

    def to_raw(self, value: Value) -> float | int:
        """Turn a value into the number in the words; rounds half to even.

        No value (None, NaN, infinite, too large for the type) gives `invalid`. Rows without `invalid` read 0
        for no value, and counters wrap.

        Parameters
        ----------
        value : float, int, bool or None
            In the row's unit.

        Returns
        -------
        float or int
        """
        if value is None or not -_FLOAT32_MAX <= value <= _FLOAT32_MAX:  # NaN fails every comparison
            return 0 if self.invalid is None else self.invalid
        if self.type == "f32":
            return value
        raw = round(value) if self.scale == 1 else round(value / self.scale)
        lowest, highest = self.raw_range
        if self.invalid is None:
            return raw & highest
        return raw if lowest <= raw <= highest else self.invalid

    def to_value(self, raw: float) -> float | int | None:
        """Turn the number in the words into a value in the row's unit; None for no value."""
        if raw == self.invalid or math.isnan(raw):
            return None
        return raw if self.scale == 1 else round(raw * self.scale, 6)


def spare(address: int, block: Block) -> Register:
    """Word of a block that is kept for growth of the map."""
    return Register(
        name=f"spare_{address}",
        tables=("input", "holding"),
        address=address,
        type="u16",
        text="reserved for growth of the map, reads 0",
        constant=0,
        block=block,
    )


def select(registers: Iterable[Register], table: Table, access: str, block: Block | None = None) -> list[Register]:
    """Rows of one table with one kind of access and in one block, by address."""
    rows = (row for row in registers if table in row.tables and (row.access, row.block) == (access, block))
    return sorted(rows, key=lambda row: row.address)


def span(rows: Sequence[Register]) -> range:
    """Addresses from the first to the last of rows that are sorted by address."""
    return range(rows[0].address, rows[-1].end)


def check(rows: Iterable[Register]) -> None:
    """Check the rules that every version of the map keeps.

    Parameters
    ----------
    rows : iterable of Register

    Raises
    ------
    ValueError
        A row has an impossible type, address, access or bounds, or repeats a row that does not exist; a value
        does not stand at a multiple of its length; two rows of a table share a name or an address; a block is
        not the same in both tables, has a hole, does not start at its place or is too long; `sequence` is not
        the first word of the measurement block and `sequence_check` not its last; a ring does not begin with
        its index; set points, alarms, commands or discrete inputs have a hole or do not stand at their place.
    """
    rows = tuple(rows)
    names = {row.name for row in rows}
    for row in rows:
        _check_row(row)
        _require(not row.shows or row.shows in names, f"the source of {row.name}")
    for table in ("input", "holding", "discrete", "coil"):
        _check_table([row for row in rows if table in row.tables], table)
    for block, start in _BLOCK_STARTS.items():
        _check_block(block, start, select(rows, "input", "r", block), select(rows, "holding", "r", block))
    _check_ends(select(rows, "input", "r", "measurement"))
    _check_run(select(rows, "holding", "rw"), "set points", start=200)
    _check_run(select(rows, "coil", "r"), "alarms", start=0)
    _check_run(select(rows, "coil", "rw"), "commands", start=32)
    _check_run(select(rows, "discrete", "r"), "discrete inputs", start=0)


def _require(holds: bool, what: str) -> None:
    if not holds:
        raise ValueError(f"rows: {what} breaks the rules of the register map")


def _check_row(row: Register) -> None:
    possible = {"discrete", "coil"} if row.type == "bool" else {"input", "holding"}
    _require(bool(row.tables) and set(row.tables) <= possible, f"the type of {row.name} in its tables")
    _require(row.address >= 0 and row.end <= 0x10000, f"the address of {row.name}")
    # structures of PLC compilers put a value at a multiple of its own length
    _require(row.address % row.words == 0, f"the alignment of {row.name}")
    _require(row.access == "r" or row.tables in {("holding",), ("coil",)}, f"write access to {row.name}")
    published = row.access == "r" and row.type != "bool"
    _require((row.block is not None) == published, f"the block of {row.name}")
    if row.lower is not None or row.upper is not None:
        _check_bounds(row)


def _check_bounds(row: Register) -> None:
    _require(row.lower is not None and row.upper is not None, f"a missing bound of {row.name}")
    smallest, largest = row.raw_range
    lowest, highest = row.raw_bounds
    _require(row.access == "rw" and smallest <= lowest <= highest <= largest, f"the bounds of {row.name}")


def _check_table(rows: Iterable[Register], table: str) -> None:
    ordered = sorted(rows, key=lambda row: row.address)
    names = [row.name for row in ordered]
    _require(len(names) == len(set(names)), f"a repeated name in table {table}")
    for before, after in itertools.pairwise(ordered):
        _require(before.end <= after.address, f"the overlap of {before.name} and {after.name}")


def _check_run(rows: Sequence[Register], what: str, *, start: int) -> None:
    _require(bool(rows) and rows[0].address == start, f"the start of {what}")
    for before, after in itertools.pairwise(rows):
        _require(before.end == after.address, f"the hole before {after.name}")


def _check_block(block: Block, start: int, rows: Sequence[Register], mirror: Sequence[Register]) -> None:
    what = f"the {block} block"
    _require(rows == mirror, f"a word of {what} that is not the same in input and holding registers")
    _check_run(rows, what, start=start)
    _require(len(span(rows)) <= BLOCK_WORDS_MAX, f"the length of {what}")
    _require(not block.endswith("ring") or rows[0].name == f"{block}_index", f"the first word of {what}")


def _check_ends(measurements: Sequence[Register]) -> None:
    _require(measurements[0].name == "sequence", "the first word of the measurement block")
    last = measurements[-1]
    _require(last.name == "sequence_check" and last.shows == "sequence", "the last word of the measurement block")
