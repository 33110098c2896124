"""Spoils files and command lines as disks, cables and people do; the same random numbers spoil in the same way."""

import json
import random

VALUES = (
    None, True, False, 0, -1, 1, 2**31, 10**400, 1e308, -1e308, 1e-308, 0.5, "", "x", "0", "NaN", [], {}, [[]], [1, 2],
    [1e300] * 5, {"a": {}},
)  # fmt: skip
TOKENS = ("NaN", "Infinity", "-Infinity", "1e999", "9" * 5000, "[" * 3000, "'", "\ufeff", "\x00", "//", "0x10")
WORDS = (
    "", "-1", "0", "1", "2", "nan", "inf", "1e309", "9" * 400, "x", "é", "--", "-", "--nothing", "-h", "a b", "%", "\n",
    "rig.json", "mill", "ends", "out.xlsx", "out/none.csv", "out.csv", "--output", "--output=", "--rig", "--method",
    "conveyor", "virtual-board", "csv", "json", "127.0.0.1:1", "tangent", "none", "references", "gauge.toml", ".",
    "bar", "video", "--config", "--plot", "plots", "--squares", "--region", "--barrier-mm", "500",
)  # fmt: skip


def spoilt_bytes(chance: random.Random, data: bytes) -> bytes:
    """A file whose bytes were changed, cut, doubled or lost in one to three places."""
    for _ in range(chance.randint(1, 3)):
        data = _spoilt_once(chance, data)
    return data


def _spoilt_once(chance: random.Random, data: bytes) -> bytes:
    at = chance.randrange(len(data) + 1)
    length = min(chance.choice([1, 2, 4, 16, 256, 4096]), len(data) - at)
    kinds = {
        "cut": data[:at],
        "lost": data[:at] + data[at + length :],
        "zeros": data[:at] + bytes(length) + data[at + length :],
        "noise": data[:at] + chance.randbytes(length) + data[at + length :],
        "doubled": data[: at + length] + data[at:],
        "added": data[:at] + chance.randbytes(chance.choice([1, 2, 7, 300])) + data[at:],
        "bit": data[:at] + bytes(one ^ 1 << chance.randrange(8) for one in data[at : at + 1]) + data[at + 1 :],
        "tail": data + chance.randbytes(chance.choice([1, 50])),
        "head": chance.choice([b"\xef\xbb\xbf", b"\xff\xfe", b"\0", b"\x89PNG", b"\xff\xd8"]) + data,
        "nothing": b"",
    }
    return kinds[chance.choice(sorted(kinds))]


def spoilt_text(chance: random.Random, data: bytes) -> bytes:
    """A text with one word changed, moved or replaced, or its bytes spoilt."""
    kind = chance.randrange(4)
    if kind == 0:
        return spoilt_bytes(chance, data)
    words = data.decode("utf-8", errors="replace").split(" ")
    at = chance.randrange(len(words))
    if kind == 1:
        words[at] = chance.choice(TOKENS)
    elif kind == 2:
        words[at : at + 1] = [words[at], words[at]]
    else:
        del words[at]
    return " ".join(words).encode("utf-8", errors="surrogateescape")


def spoilt_json(chance: random.Random, data: bytes) -> bytes:
    """A JSON text with a value, a key or a token that does not belong there, or its bytes spoilt."""
    kind = chance.randrange(6)
    if kind == 0:
        return spoilt_bytes(chance, data)
    values = json.loads(data)
    holder = values
    while isinstance(inner := _any(chance, holder), dict | list) and inner and chance.random() < 0.8:
        holder = inner
    places = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
    at = chance.choice(places)
    if kind == 1:
        del holder[at]
    elif kind == 2 and isinstance(holder, dict):
        holder[at[:-1] + "x"] = holder.pop(at)
    elif kind == 3:
        holder[at] = "@"
        return json.dumps(values).encode().replace(b'"@"', chance.choice(TOKENS).encode(), 1)
    else:
        holder[at] = chance.choice(VALUES)
    return json.dumps(values).encode()


def _any(chance: random.Random, holder: dict | list) -> object:
    return holder[chance.choice(list(holder) if isinstance(holder, dict) else list(range(len(holder))))]


def spoilt_words(chance: random.Random, words: list[str]) -> list[str]:
    """A command line with words left out, doubled, exchanged, replaced or added; the command itself stays mostly."""
    words = list(words)
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        at = chance.randrange(0 if chance.random() < 0.05 else 1, len(words) + 1)
        kind = chance.randrange(5)
        if kind == 0:
            words[at : at + 1] = []
        elif kind == 1:
            words[at : at + 1] = [chance.choice(WORDS)]
        elif kind == 2:
            words[at:at] = [chance.choice(WORDS)]
        elif kind == 3:
            words[at:at] = words[at - 1 : at]
        else:
            other = chance.randrange(len(words))
            words[at : at + 1], words[other] = [words[other]], (words[at : at + 1] or [words[other]])[0]
    return words
