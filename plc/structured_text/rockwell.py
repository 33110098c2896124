"""The logic of an add-on instruction for Studio 5000, whose structured text has no functions, types or declarations.

Words are INT there, which is signed, and a float of two words is copied with COP, which takes the least significant
word first. Timers are of the type FBD_TIMER and have their times in milliseconds. Studio 5000 has not been at hand: the
text follows Rockwell's manual 1756-PM007 and has not been compiled.
"""

from plc.codes import Bits
from plc.registers import ALARMS, MEASUREMENTS, REGISTERS
from plc.rows import select
from plc.structured_text.dialect import Variable
from plc.structured_text.function_block import IN_OUTS, INNER, INPUTS, NO_NUMBER, OUTPUTS, QUANTITIES
from plc.structured_text.types import constants

_ADDRESS = {row.name: row.address for row in select(REGISTERS, "input", "r", "measurement")}
_TYPES = {"UINT": "DINT", "TIME": "DINT", "WORD": "INT", "TON": "FBD_TIMER"}
_INITIAL = {"T#100MS": "100", "T#1S": "1000", "TRUE": "1"}


def to_rockwell(heading: str, bits: Bits) -> str:
    """Tags, constants and logic.

    Parameters
    ----------
    heading : str
    bits : mapping of str to sequence of NamedBit
        By register.
    """
    sections = (("Input", INPUTS), ("InOut", IN_OUTS), ("Output", OUTPUTS), ("Local", INNER))
    tags = [_tag(kind, one) for kind, variables in sections for one in variables]
    tags.append(f"//   {'Local':<7} {'pair':<26} INT[2]")
    named = [f"//   {name} = {number}: {text}" for name, number, text in constants(bits)]
    head = [f"// {heading}", "// Tags of the add-on instruction HOTGAUGE, with their types and defaults:", *tags]
    return "\n".join([*head, "// Bits and codes:", *named, "// Logic:", *_logic(), ""])


def _tag(kind: str, one: Variable) -> str:
    initial = _INITIAL.get(one.initial, one.initial)
    return f"//   {kind:<7} {one.name:<26} {_type(one.type):<12} {initial:<5} {one.text}".rstrip()


def _type(name: str) -> str:
    return f"INT[{len(MEASUREMENTS)}]" if name.startswith("ARRAY") else _TYPES.get(name, name)


def _word(name: str) -> str:
    return f"(words[{_ADDRESS[name]}] AND 16#FFFF)"


def _logic() -> list[str]:
    return [*_polling(), *_watching(), *_judging(), *_values(), *_alarms()]


def _timer(name: str, enabled: str, time: str) -> list[str]:
    return [f"{name}.PRE := {time};", f"{name}.TimerEnable := {enabled};", f"TONR({name});"]


def _polling() -> list[str]:
    return [
        "IF answered OR failed OR NOT enable THEN waiting := 0; request := 0; END_IF;",
        *_timer("pause", "enable AND NOT pause.DN", "poll_time"),
        "IF pause.DN AND NOT waiting THEN waiting := 1; request := 1; END_IF;",
    ]


def _watching() -> list[str]:
    beat = f"words[{_ADDRESS['heartbeat']}]"
    return [
        f"moved := answered AND known AND ({beat} <> beat);",
        f"IF answered THEN beat := {beat}; known := 1; END_IF;",
        "IF moved THEN seen := 1; END_IF;",
        *_timer("silence", "NOT moved", "silence_time"),
        "IF silence.DN OR NOT enable THEN seen := 0; END_IF;",
        "alive := seen;",
    ]


def _judging() -> list[str]:
    test = _ADDRESS["test_u32"]
    return [
        "first := 0;",
        "IF word_swap THEN first := 1; END_IF;",
        f"whole := words[0] = words[{MEASUREMENTS[-1]}];",
        f"order_wrong := known AND ((words[{test} + first] <> 16#1234) OR (words[{test + 1} - first] <> 16#5678));",
        f"simulated := ({_word('status_word')} AND 16#0010) <> 0;",
        f"usable := alive AND whole AND NOT order_wrong AND ({_word('validity')} <> 0)",
        f"    AND (allow_simulated OR NOT simulated) AND ({_word('measurement_age')} <= age_max);",
    ]


def _values() -> list[str]:
    lines = [f"{one.name} := 0.0;" for one in QUANTITIES]
    lines += [f"{one.flag} := 0;" for one in QUANTITIES if one.flag]
    lines += ["decision := 0;", "IF usable THEN"]
    for one in QUANTITIES:
        address = _ADDRESS[one.name]
        flag = f"{one.flag} := 1; " if one.flag else ""
        lines += [
            f"    pair[1] := words[{address} + first];",
            f"    pair[0] := words[{address + 1} - first];",
            f"    IF (pair[1] AND {NO_NUMBER}) <> {NO_NUMBER} THEN {flag}COP(pair[0], {one.name}, 1); END_IF;",
        ]
    return [*lines, f"    decision := {_word('decision')};", "END_IF;"]


def _alarms() -> list[str]:
    rows = [row for row in select(REGISTERS, "coil", "r") if not row.spare]
    return [
        "alarm_dead := NOT alive;",
        "alarm_no_value := alive AND NOT usable;",
        "device_state := 4;",
        f"IF alive THEN device_state := {_word('device_state')}; END_IF;",
        *(
            f"{row.name} := alive AND (({_word('alarm_word')} AND 16#{1 << row.address - ALARMS.start:04X}) <> 0);"
            for row in rows
        ),
    ]
