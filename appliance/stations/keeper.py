"""Starts a measuring process, listens to it, and starts it again when it ends, for whatever reason."""

import asyncio
import contextlib
import socket
import sys
import time
from asyncio.subprocess import DEVNULL, Process
from collections.abc import Callable

from appliance.stations.link import Message, parse

SILENCE_LIMIT_S = 15.0  # longest honest silence: a first calibration on a busy computer
LEAVE_TIME_S = 2.5  # a process leaves by itself when its link closes; it gives itself 2 s
PAUSE_FIRST_S = 0.2
PAUSE_LONGEST_S = 5.0
GOOD_RUN_S = 30.0


async def keep(
    module: str, settings_json: str, on_message: Callable[[Message], None], on_end: Callable[[str], None]
) -> None:
    """Keep one measuring process running until cancelled; it is gone when this returns.

    Parameters
    ----------
    module : str
        Python module that is run, with the number of its link's file descriptor as argument.
    settings_json : str
        One line, sent over the link first.
    on_message : callable
        Gets each message as soon as it is there.
    on_end : callable
        Gets one sentence on why the process ended, each time it does.
    """
    pause_s = PAUSE_FIRST_S
    while True:
        started_s = time.monotonic()
        on_end(await _run_once(module, settings_json, on_message))
        if time.monotonic() - started_s > GOOD_RUN_S:
            pause_s = PAUSE_FIRST_S
        await asyncio.sleep(pause_s)
        pause_s = min(2 * pause_s, PAUSE_LONGEST_S)


async def _run_once(module: str, settings_json: str, on_message: Callable[[Message], None]) -> str:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        try:
            process = await _start(module, theirs.fileno())
        except OSError as error:
            return f"the measuring process cannot be started: {error}"
        theirs.close()
        reader, writer = await asyncio.open_unix_connection(sock=ours)
        try:
            writer.write(settings_json.encode() + b"\n")
            reason = await _listen(reader, on_message)
        finally:
            writer.close()
            await _end(process)
    return f"{reason} ({_how_it_ended(process)})"


async def _start(module: str, link: int) -> Process:
    # away from the terminal: Ctrl-C on a terminal ends the supervisor only, and that closes the link
    return await asyncio.create_subprocess_exec(
        sys.executable, "-P", "-m", module, str(link),
        pass_fds=(link,), stdin=DEVNULL, stdout=DEVNULL, start_new_session=True,
    )  # fmt: skip


async def _listen(reader: asyncio.StreamReader, on_message: Callable[[Message], None]) -> str:
    try:
        while (line := await asyncio.wait_for(reader.readline(), SILENCE_LIMIT_S)).endswith(b"\n"):
            on_message(parse(line))
    except TimeoutError:
        return f"the measuring process said nothing for {SILENCE_LIMIT_S:.0f} s and was ended"
    except (ValueError, ConnectionError) as error:
        return f"the measuring process sent what cannot be read and was ended: {error}"
    return "the measuring process ended"  # a half-written last line is no message


async def _end(process: Process) -> None:
    try:
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(process.wait(), LEAVE_TIME_S)
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()


def _how_it_ended(process: Process) -> str:
    code = process.returncode or 0
    return f"signal {-code}" if code < 0 else f"exit code {code}"
