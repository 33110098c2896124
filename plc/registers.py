"""The register map: one typed table from which server, client, documents and tests are derived.

Every measurement stands in one block of words, at the same addresses in input and in holding registers, and so
do the rings of the last readings and ingots. Set points and command coils belong to the PLC and are never part
of a published image. The map only grows: an address or a bit never changes its meaning, and new values take
the place of spare words.

Examples
--------
A set point as the PLC writes it, in hundredths of a millimetre:

>>> target = next(row for row in REGISTERS if row.name == "target_diameter")
>>> target.address, target.to_raw(100.5), target.to_value(10050)
(200, 10050, 100.5)
"""

from plc.bars import bars
from plc.codes import Decision, DeviceState, Orientation, Validity
from plc.rings import INGOT_SLOT, READING_SLOT, ring
from plc.rows import NO_VALUE, Block, Register, Table, Type, select, span, spare

MAP_VERSION = 5
WORDS_END = 625  # of input and holding registers: whole requests of 125 words, as tools of plants read them
SHELVE_FIRST = 34  # coil that shelves alarm 0
BITS_END = 64  # of coils and discrete inputs: whole groups of 16 or 32

BLOCKS: tuple[Block, ...] = ("measurement", "reading_ring", "ingot_ring", "bars")
_BLOCK: tuple[Table, ...] = ("input", "holding")


def _state(address: int, name: str, text: str, type_: Type = "u16", *, shows: str = "") -> Register:
    return Register(name=name, tables=_BLOCK, address=address, type=type_, text=text, shows=shows, block="measurement")


def _constant(address: int, name: str, type_: Type, constant: float, text: str) -> Register:
    return Register(
        name=name, tables=_BLOCK, address=address, type=type_, constant=constant, text=text, block="measurement"
    )


def _measured(address: int, name: str, unit: str, text: str, type_: Type = "f32") -> Register:
    return Register(
        name=name,
        tables=_BLOCK,
        address=address,
        type=type_,
        unit=unit,
        invalid=NO_VALUE[type_],
        text=text,
        block="measurement",
    )


def _integer(address: int, shows: str, unit: str, type_: Type = "u16") -> Register:
    return Register(
        name=f"{shows}_{type_}",
        tables=_BLOCK,
        address=address,
        type=type_,
        unit=unit,
        scale=0.01,
        invalid=NO_VALUE[type_],
        shows=shows,
        text=f"{shows} as an integer",
        block="measurement",
    )


def _alarm(bit: int, name: str, text: str) -> Register:
    return Register(name=name, tables=("coil", "discrete"), address=bit, type="bool", shows="alarm_word", text=text)


def _status(address: int, name: str, text: str) -> Register:
    return Register(name=name, tables=("discrete",), address=address, type="bool", text=text)


def _command(address: int, name: str, text: str) -> Register:
    return Register(name=name, tables=("coil",), address=address, type="bool", access="rw", text=text)


def _set_point(
    address: int, name: str, unit: str, bounds: tuple[float, float] | None, text: str, *, type_: Type = "u16"
) -> Register:
    lower, upper = bounds or (None, None)
    return Register(
        name=name,
        tables=("holding",),
        address=address,
        type=type_,
        unit=unit,
        scale=0.01 if unit == "mm" else 1,
        lower=lower,
        upper=upper,
        access="rw",
        text=text,
    )


_ALARMS = (
    _alarm(0, "alarm_wrong_orientation", "an ingot lies with its top towards the line"),
    _alarm(1, "alarm_out_of_tolerance", "the bar is out of tolerance"),
    _alarm(2, "alarm_low_trust", "the diameter cannot be trusted"),
    _alarm(3, "alarm_camera", "a camera is lost or cannot be believed"),
    _alarm(4, "alarm_stale", "the newest reading is too old"),
    _alarm(5, "alarm_calibration", "the calibration is missing or due"),
    _alarm(6, "alarm_plc_silent", "plc_heartbeat stands still"),
    _alarm(7, "alarm_internal", "the gauge itself has failed"),
)

_STATUS = (
    _status(16, "measurement_valid", "validity is not 0"),
    _status(17, "bar_present", "a hot bar is in the measuring region"),
    _status(18, "ingot_present", "an ingot's end is in sight"),
    _status(19, "running", "the gauge is measuring"),
    _status(20, "simulated", "pictures come from the simulated mill or a recording"),
)

REGISTERS: tuple[Register, ...] = (
    _state(0, "sequence", "+1 with each new reading or change of validity; first word of the block"),
    _constant(1, "map_version", "u16", MAP_VERSION, "version of this map"),
    _state(2, "heartbeat", "+1 every 100 ms; if it stands still the gauge is dead and all values are old"),
    _state(
        3,
        "device_state",
        f"NE 107: {DeviceState.words()}",
    ),
    _state(
        4,
        "status_word",
        "bit " + ", ".join(f"{bit} {row.name}" for bit, row in enumerate(_STATUS)),
    ),
    _state(5, "validity", f"of the bar's values: {Validity.words()} (reason_word)"),
    _state(6, "reason_word", "reason flags of the newest reading, one bit each", "u32"),
    _state(8, "alarm_word", "bit n is alarm coil n"),
    _measured(9, "measurement_age", "ms", "age of the exposure when the block was written", "u16"),
    _state(10, "frames_dropped", "image pairs discarded since the start because a newer one was ready", "u32"),
    _measured(12, "timestamp", "ms", "moment of exposure, since 1970-01-01 00:00 UTC", "u64"),
    _measured(16, "diameter", "mm", "diameter of the bar, hot"),
    _measured(18, "expanded_uncertainty", "mm", "expanded uncertainty (k = 2) of diameter"),
    _measured(20, "diameter_cold", "mm", "diameter at 20 °C; needs steel_temperature and expansion_grade"),
    _measured(22, "expanded_uncertainty_cold", "mm", "expanded uncertainty (k = 2) of diameter_cold"),
    _measured(24, "diameter_virtual_board", "mm", "diameter by the second route (virtual board), hot"),
    _measured(26, "weighted_deviation", "mm", "weighted deviation Sigma of the frame; small is good"),
    _measured(28, "trust", "%", "how far diameter can be trusted, 0 to 100"),
    _measured(30, "deviation", "mm", "diameter minus target_diameter, cold if a grade is set, else hot"),
    _measured(32, "correction", "mm", "advised change of the stand's gap; positive opens"),
    _measured(
        34,
        "alignment_quality",
        "%",
        "overlap of the two views' outlines, 100 at a match; below 99, negative says that the board lies too low",
    ),
    _measured(36, "plane_height", "mm", "height of the virtual board over the conveyor plane"),
    _measured(38, "bar_min", "mm", "smallest diameter of the bar so far"),
    _measured(40, "bar_mean", "mm", "mean diameter of the bar so far"),
    _measured(42, "bar_max", "mm", "largest diameter of the bar so far"),
    _measured(44, "ssim_top", "", "similarity of the ingot's end to the top reference, -1 to 1"),
    _measured(46, "ssim_bottom", "", "similarity of the ingot's end to the bottom reference, -1 to 1"),
    _measured(48, "ingot_confidence", "%", "confidence of ingot_orientation, 0 to 100"),
    _measured(50, "ingot_age", "ms", "age of the ingot station's newest exposure", "u32"),
    _measured(52, "cycle_time", "ms", "time from one reading to the next"),
    _state(54, "decision", f"against the tolerance: {Decision.words()}"),
    _measured(55, "windows_kept", "", "windows along the bar that agree with diameter", "u16"),
    _measured(56, "windows_total", "", "windows along the bar", "u16"),
    _state(57, "bar_sequence", "+1 with each new bar"),
    _state(58, "ingot_orientation", f"end facing the line: {Orientation.words()}"),
    _state(59, "ingot_sequence", "+1 with each new ingot"),
    _state(60, "ingot_validity", f"of the ingot's values: {Validity.words()}"),
    _state(61, "ingot_reason_word", "reason flags of the newest picture of the ingot line, one bit each"),
    _constant(62, "test_float", "f32", 123.456, "always 123.456: read wrongly, the word order is wrong"),
    _constant(64, "test_u32", "u32", 0x12345678, "always 305419896 (16#12345678), for finding the word order"),
    _integer(66, "diameter", "mm"),
    _integer(67, "expanded_uncertainty", "mm"),
    _integer(68, "diameter_cold", "mm"),
    _integer(69, "expanded_uncertainty_cold", "mm"),
    _integer(70, "diameter_virtual_board", "mm"),
    _integer(71, "weighted_deviation", "mm"),
    _integer(72, "trust", "%"),
    _integer(73, "deviation", "mm", "i16"),
    _integer(74, "correction", "mm", "i16"),
    _integer(75, "bar_min", "mm"),
    _integer(76, "bar_mean", "mm"),
    _integer(77, "bar_max", "mm"),
    _integer(78, "ingot_confidence", "%"),
    spare(79, "measurement"),
    _state(
        80, "fault_word", "one bit for each fault of the fault table, set until a latching one is acknowledged", "u32"
    ),
    _state(
        82, "clients_refused", "clients turned away since the start: too many, no certificate, no descriptors", "u32"
    ),
    _state(84, "alarms_shelved", "bit n: alarm coil n is shelved and not shown"),
    _measured(85, "bar_frames", "", "frames that bar_diameter is of, at most 50", "u16"),
    _measured(86, "bar_diameter", "mm", "diameter of the passing bar from its last frames, hot"),
    _measured(88, "bar_expanded_uncertainty", "mm", "expanded uncertainty (k = 2) of bar_diameter"),
    _measured(90, "bar_ovality", "mm", "greatest minus least width of the bar, once it has turned by half a turn"),
    _measured(92, "bar_ovality_expanded_uncertainty", "mm", "expanded uncertainty (k = 2) of bar_ovality"),
    _measured(94, "camber", "mm", "sagitta of the bar's axis over 1 m; positive: its ends lie at larger x"),
    _measured(96, "camber_expanded_uncertainty", "mm", "expanded uncertainty (k = 2) of camber"),
    _measured(98, "hop_height", "mm", "height of the bar over the rollers, by its axis and its diameter"),
    _measured(100, "bar_mean_expanded_uncertainty", "mm", "expanded uncertainty (k = 2) of bar_mean"),
    _integer(102, "bar_diameter", "mm"),
    _integer(103, "bar_expanded_uncertainty", "mm"),
    *(spare(address, "measurement") for address in range(104, 119)),
    _state(119, "sequence_check", "sequence again; last word of the block", shows="sequence"),
    _set_point(200, "target_diameter", "mm", (10, 655.34), "wanted diameter; cold if a grade is set, else hot"),
    _set_point(201, "tolerance_plus", "mm", (0.01, 50), "allowed above the target"),
    _set_point(202, "tolerance_minus", "mm", (0.01, 50), "allowed below the target, as a positive number"),
    _set_point(203, "steel_temperature", "°C", (100, 1400), "mean temperature of the section", type_="i16"),
    _set_point(204, "product_id", "", None, "the mill's number of the product, its words writable alone", type_="u32"),
    _set_point(206, "expansion_grade", "", (1, 99), "steel grade, a row of the expansion table"),
    _set_point(207, "plc_heartbeat", "", None, "any number that keeps changing while the PLC runs"),
    *_ALARMS,
    *(_alarm(bit, f"alarm_spare_{bit}", "reserved for growth of the map, reads 0") for bit in range(8, 16)),
    *_STATUS,
    _command(32, "acknowledge", "0 -> 1 acknowledges all alarms"),
    _command(33, "hold", "1 holds the gauge: not for control, validity off, alarms suppressed"),
    *(
        _command(SHELVE_FIRST + row.address, f"shelve_{row.name.removeprefix('alarm_')}", f"0 -> 1 shelves {row.name}")
        for row in _ALARMS
    ),
    _command(42, "keep_pictures", "0 -> 1 writes the last seconds of pictures, if the stations keep any"),
    *ring(300, "reading_ring", "reading", READING_SLOT),
    *ring(420, "ingot_ring", "ingot", INGOT_SLOT),
    *bars(540),
)

MEASUREMENTS, READING_RING, INGOT_RING, BARS = (span(select(REGISTERS, "input", "r", block)) for block in BLOCKS)
SET_POINTS = span(select(REGISTERS, "holding", "rw"))
ALARMS = span(select(REGISTERS, "coil", "r"))
COMMANDS = span(select(REGISTERS, "coil", "rw"))
DISCRETES = span(select(REGISTERS, "discrete", "r"))
