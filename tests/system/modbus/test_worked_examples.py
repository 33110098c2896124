"""The examples of docs/plc, run or compared with the map."""

import json
import re
import shlex
import struct
import subprocess
import tomllib
from pathlib import Path

import pytest
from modbus_wire import LIVE

from plc.process_image import encode
from plc.registers import REGISTERS

EXAMPLES = Path(__file__).parents[3] / "docs" / "plc"
ROWS = {row.name: row for row in REGISTERS}
COMMANDS = re.findall(r"^mbpoll .*$", (EXAMPLES / "mbpoll.md").read_text(encoding="utf-8"), flags=re.MULTILINE)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_mbpoll_command_is_answered(server, command):
    result = subprocess.run(
        shlex.split(command.replace("5020", str(server.port))), capture_output=True, text=True, timeout=10, check=False
    )
    assert result.returncode == 0, result.stdout + result.stderr
    addresses = {int(address) for address in re.findall(r"^\[(\d+)\]:", result.stdout, flags=re.MULTILINE)}
    asked = int(re.search(r"-r (\d+)", command)[1])
    assert asked in addresses or "References written" in result.stdout or "Written" in result.stdout


def test_mbpoll_writes_the_set_points_that_its_example_says(server, written):
    (command,) = [command for command in COMMANDS if " -t 4 " in command]
    subprocess.run(shlex.split(command.replace("5020", str(server.port))), capture_output=True, timeout=10, check=True)
    assert written == [{"target_diameter": 26550, "tolerance_plus": 40, "tolerance_minus": 30}]


def test_telegraf_reads_every_value_at_its_address_with_its_type():
    types = {"u16": "UINT16", "u32": "UINT32", "f32": "FLOAT32-IEEE"}
    text = (EXAMPLES / "telegraf.conf").read_text(encoding="utf-8")
    text = re.sub(r"\},\n\s*\]", "}]", re.sub(r"\n\s+\{", " {", text))  # an array of TOML may end with a comma
    (plugin,) = tomllib.loads(text)["inputs"]["modbus"]
    assert len(plugin["input_registers"]) == 10
    for one in plugin["input_registers"]:
        row = ROWS[one["name"]]
        assert one["address"] == list(range(row.address, row.end))
        assert one["data_type"] == types[row.type]


JUDGE = """
const fs = require("fs");
const flow = JSON.parse(fs.readFileSync(process.argv[1], "utf8"));
const code = flow.find((node) => node.type === "function").func;
const kept = {}, allowed = process.argv[3] === "true";
const context = { get: (name) => kept[name], set: (name, value) => { kept[name] = value; } };
const judge = new Function("msg", "context", "flow", code);
const out = JSON.parse(process.argv[2]).map(
  (words) => judge({ payload: words }, context, { get: () => allowed }).payload);
console.log(JSON.stringify(out));
"""


def judged(images: list[dict], *, allowed: bool = False) -> list[dict]:
    words = [list(struct.unpack(">120H", encode(image).words)) for image in images]
    command = ["node", "-e", JUDGE, EXAMPLES / "node-red.json", json.dumps(words), str(allowed).lower()]
    return json.loads(subprocess.run(command, capture_output=True, text=True, timeout=20, check=True).stdout)


def test_the_function_of_node_red_uses_only_living_valid_values():
    dead, alive = judged([LIVE, LIVE | {"heartbeat": 6}])
    assert not dead["usable"]
    assert alive["usable"]
    assert alive["diameter"] == pytest.approx(265.53, abs=1e-4)
    for change in ({"validity": 0}, {"simulated": True}):
        assert not judged([LIVE, LIVE | {"heartbeat": 6} | change])[1]["usable"]
    assert judged([LIVE, LIVE | {"heartbeat": 6, "simulated": True}], allowed=True)[1]["usable"]
