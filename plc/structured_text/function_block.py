"""The function block that reads a gauge: polls, watches, and converts only what may be used."""

from typing import NamedTuple

from plc.registers import ALARMS, MEASUREMENTS, REGISTERS
from plc.rows import select
from plc.structured_text.dialect import Part, Variable

NAME = "HOTGAUGE"
NO_NUMBER = "16#7F80"  # exponent of what is infinite or not a number

_ADDRESS = {row.name: row.address for row in select(REGISTERS, "input", "r", "measurement")}
_TEST_HIGH, _TEST_LOW = "16#1234", "16#5678"


class Quantity(NamedTuple):
    """A float of the block: its register, and the output that says whether there is one; empty if validity says it."""

    name: str
    flag: str


QUANTITIES = (
    Quantity("diameter", ""),
    Quantity("expanded_uncertainty", ""),
    Quantity("trust", ""),
    Quantity("diameter_cold", "has_cold"),
    Quantity("deviation", "has_deviation"),
    Quantity("correction", "has_correction"),
)

REAL_OF_WORDS = Part(
    "HOTGAUGE_REAL",
    "REAL",
    "a number (IEEE 754, 32 bits) from its two words; 0 for what is no number, which is to be asked before",
    [Variable("high", "WORD"), Variable("low", "WORD")],
    [],
    [],
    [Variable("exponent", "INT"), Variable("digits", "UDINT"), Variable("size", "REAL")],
    [
        "exponent := WORD_TO_INT(SHR(high AND 16#7F80, 7));",
        "digits := WORD_TO_UDINT(high AND 16#007F) * 65536 + WORD_TO_UDINT(low);",
        "IF exponent = 0 OR exponent = 255 THEN",
        "    HOTGAUGE_REAL := 0.0;",
        "ELSE",
        "    size := UDINT_TO_REAL(digits + 8388608) / 8388608.0;",
        "    WHILE exponent > 127 DO",
        "        size := size * 2.0;",
        "        exponent := exponent - 1;",
        "    END_WHILE;",
        "    WHILE exponent < 127 DO",
        "        size := size / 2.0;",
        "        exponent := exponent + 1;",
        "    END_WHILE;",
        "    IF (high AND 16#8000) <> 16#0000 THEN",
        "        size := -size;",
        "    END_IF;",
        "    HOTGAUGE_REAL := size;",
        "END_IF;",
    ],
)


def _alarm_outputs() -> list[Variable]:
    rows = [row for row in select(REGISTERS, "coil", "r") if not row.spare]
    return [Variable(row.name, "BOOL", text=row.text) for row in rows]


INPUTS = (
    Variable("enable", "BOOL", "TRUE", "FALSE stops polling; nothing is usable then"),
    Variable("answered", "BOOL", text="of the Modbus block: words are new; TRUE for one cycle"),
    Variable("failed", "BOOL", text="of the Modbus block: there was no answer; TRUE for one cycle"),
    Variable("word_swap", "BOOL", text="least significant word first, as plc.word_order = little sets it"),
    Variable("allow_simulated", "BOOL", text="accept values of the simulated mill or of a recording: for trials only"),
    Variable("age_max", "UINT", "1000", "oldest reading that is usable, ms"),
    Variable("poll_time", "TIME", "T#100MS", "from one request to the next"),
    Variable("silence_time", "TIME", "T#1S", "without a change of heartbeat, after which the gauge counts as dead"),
)

IN_OUTS = (
    Variable("words", f"ARRAY[0..{len(MEASUREMENTS) - 1}] OF WORD", text="the measurement block as it was read"),
)

OUTPUTS = (
    Variable("request", "BOOL", text="to the Modbus block: read input registers 0 to 119 now, at its rising edge"),
    Variable("alive", "BOOL", text="the heartbeat moves"),
    Variable("whole", "BOOL", text="all words are of one moment"),
    Variable("order_wrong", "BOOL", text="the test value reads wrongly: change word_swap"),
    Variable("simulated", "BOOL", text="values are of the simulated mill or of a recording"),
    Variable("usable", "BOOL", text="the values below may be used; FALSE: they are 0 and say nothing"),
    *(Variable(one.name, "REAL") for one in QUANTITIES),
    *(Variable(one.flag, "BOOL", text=f"whether there is {one.name}") for one in QUANTITIES if one.flag),
    Variable("decision", "UINT", text="0 none, 1 in, 2 out, 3 undecided"),
    Variable("device_state", "UINT", "4", "NE 107; 4 (failure) also when the gauge is dead"),
    Variable("alarm_dead", "BOOL", text="the gauge is dead or the network is down"),
    Variable("alarm_no_value", "BOOL", text="the gauge lives and has no usable value"),
    *_alarm_outputs(),
)

INNER = (
    Variable("pause", "TON"),
    Variable("silence", "TON"),
    Variable("waiting", "BOOL"),
    Variable("known", "BOOL", text="a heartbeat has been read"),
    Variable("moved", "BOOL"),
    Variable("seen", "BOOL", text="the heartbeat has moved"),
    Variable("beat", "WORD"),
    Variable("first", "INT", text="place of the most significant of two words"),
)


def _body() -> list[str]:
    return [*_polling(), *_watching(), *_judging(), *_values(), *_alarms()]


def _polling() -> list[str]:
    return [
        "(* poll: the timer starts anew each time that it has ended; one request at a time *)",
        "IF answered OR failed OR NOT enable THEN",
        "    waiting := FALSE;",
        "    request := FALSE;",
        "END_IF;",
        "pause(IN := enable AND NOT pause.Q, PT := poll_time);",
        "IF pause.Q AND NOT waiting THEN",
        "    waiting := TRUE;",
        "    request := TRUE;",
        "END_IF;",
    ]


def _watching() -> list[str]:
    beat = f"words[{_ADDRESS['heartbeat']}]"
    return [
        "(* heartbeat: when the gauge dies, the last values stay in the words, only this stands still *)",
        f"moved := answered AND known AND {beat} <> beat;",
        "IF answered THEN",
        f"    beat := {beat};",
        "    known := TRUE;",
        "END_IF;",
        "IF moved THEN",
        "    seen := TRUE;",
        "END_IF;",
        "silence(IN := NOT moved, PT := silence_time);",
        "IF silence.Q OR NOT enable THEN",
        "    seen := FALSE;",
        "END_IF;",
        "alive := seen;",
    ]


def _judging() -> list[str]:
    test, status = _ADDRESS["test_u32"], f"words[{_ADDRESS['status_word']}]"
    swapped = f"words[{test} + first] <> {_TEST_HIGH} OR words[{test + 1} - first] <> {_TEST_LOW}"
    return [
        "first := 0;",
        "IF word_swap THEN",
        "    first := 1;",
        "END_IF;",
        f"whole := words[0] = words[{MEASUREMENTS[-1]}];",
        f"order_wrong := known AND ({swapped});",
        f"simulated := ({status} AND 16#0010) <> 16#0000;",
        f"usable := alive AND whole AND NOT order_wrong AND words[{_ADDRESS['validity']}] <> 16#0000",
        "    AND (allow_simulated OR NOT simulated)",
        f"    AND WORD_TO_UINT(words[{_ADDRESS['measurement_age']}]) <= age_max;",
    ]


def _values() -> list[str]:
    lines = ["(* values: only what may be used is converted, so that no NaN gets into the arithmetic *)"]
    for one in QUANTITIES:
        lines += [f"{one.name} := 0.0;", *([f"{one.flag} := FALSE;"] if one.flag else [])]
    lines += ["decision := 0;", "IF usable THEN"]
    for one in QUANTITIES:
        lines += [f"    {line}" for line in _conversion(one)]
    return [*lines, f"    decision := WORD_TO_UINT(words[{_ADDRESS['decision']}]);", "END_IF;"]


def _conversion(one: Quantity) -> list[str]:
    high, low = f"words[{_ADDRESS[one.name]} + first]", f"words[{_ADDRESS[one.name] + 1} - first]"
    lines = [f"{one.name} := HOTGAUGE_REAL(high := {high}, low := {low});"]
    if one.flag:
        lines.append(f"{one.flag} := ({high} AND {NO_NUMBER}) <> {NO_NUMBER};")
    return lines


def _alarms() -> list[str]:
    word = f"words[{_ADDRESS['alarm_word']}]"
    rows = [row for row in select(REGISTERS, "coil", "r") if not row.spare]
    return [
        "(* alarms: those of a dead gauge say nothing, except that it is dead *)",
        "alarm_dead := NOT alive;",
        "alarm_no_value := alive AND NOT usable;",
        "device_state := 4;",
        "IF alive THEN",
        f"    device_state := WORD_TO_UINT(words[{_ADDRESS['device_state']}]);",
        "END_IF;",
        *(f"{row.name} := alive AND ({word} AND 16#{1 << row.address - ALARMS.start:04X}) <> 16#0000;" for row in rows),
    ]


BLOCK = Part(
    NAME,
    "",
    "reads one gauge: call it in every cycle, beside the Modbus block that fills words",
    INPUTS,
    IN_OUTS,
    OUTPUTS,
    INNER,
    _body(),
)
