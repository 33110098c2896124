"""Starts a measuring process, receives its messages, and restarts it whenever it ends.

After `ENDS_BEFORE_FAILING` ends in a row the station is `failing`: it is restarted every `FAILING_PAUSE_S` until a
process has sent readings for `GOOD_RUN_TIME_S`.
"""

import asyncio
import contextlib
import math
import socket
import sys
import time
from asyncio.subprocess import DEVNULL, Process
from collections.abc import Callable
from typing import Generic, Literal, NamedTuple

from appliance.processes.message import Messages, MessageT, StateMessage
from appliance.processes.resource_limits import EXIT_OUT_OF_MEMORY

SILENCE_LIMIT_S = 4.0  # chosen: a process that sends nothing for so long after a reading hangs and is ended
START_LIMIT_S = 60.0  # chosen: cameras open and a simulated rig calibrates within it, on a busy computer too
LEAVE_TIME_S = 2.5  # a process ends itself within 2 s of its link's close (`station_process`); then it is killed
FIRST_PAUSE_S = 0.2  # chosen: before the first restart; each further one in a row waits twice as long
LONGEST_PAUSE_S = 3.0  # chosen
ENDS_BEFORE_FAILING = 5  # chosen: ends in a row, the last of which makes the station `failing`
FAILING_PAUSE_S = 30.0  # chosen
UNREAD_MAX_BYTES = 1 << 20  # chosen: a process that leaves more unread is sent nothing
GOOD_RUN_TIME_S = 30.0  # chosen: readings for so long end `failing`, and the count of ends begins anew


State = Literal["running", "renewing", "restarting", "failing"]


class Health(NamedTuple):
    """State of a station's process.

    Attributes
    ----------
    state : {"running", "renewing", "restarting", "failing"}
        `running`: readings come. `renewing`: the process was ended for new settings.
        `restarting`: the process ended and is started again at once. `failing`: it ended
        `ENDS_BEFORE_FAILING` times in a row and has not sent readings for `GOOD_RUN_TIME_S` since.
    ended : bool
        Whether a process has just ended.
    detail : str
        Why the process ended; with `failing` also when the next one starts.
    """

    state: State
    ended: bool = False
    detail: str = ""


class MonitoredProcess(Generic[MessageT]):
    """Keeps one measuring process running.

    Parameters
    ----------
    module : str
        Python module that is run, with the number of its link's file descriptor as argument.
    settings_json : str
        Settings of the station; the first line on the link.
    messages : TypeAdapter
        Reads the lines that the process sends.
    on_message : callable
        Receives each message when it arrives.
    on_health : callable
        Receives the state of the process when it changes, and each time that a process ends.
    """

    def __init__(
        self,
        module: str,
        settings_json: str,
        messages: Messages[MessageT],
        on_message: Callable[[StateMessage | MessageT], None],
        on_health: Callable[[Health], None],
    ) -> None:
        self._module = module
        self._settings_json = settings_json
        self._messages = messages
        self._on_message = on_message
        self._on_health = on_health
        self._life: asyncio.Task[str] | None = None
        self._state: State = "running"
        self._ends = 0
        self._measures_since_s = math.inf
        self._writer: asyncio.StreamWriter | None = None

    async def run(self) -> None:
        """Start processes until cancelled; none is left when this returns."""
        while True:
            self._measures_since_s = math.inf
            self._life = asyncio.create_task(self._live())
            try:
                reason = await self._life
            except asyncio.CancelledError:
                if (task := asyncio.current_task()) and task.cancelling():
                    raise
                self._ends = 0  # `renew` has cancelled the process, not the caller `run`
                self._report("renewing", ended=True)
                continue
            await asyncio.sleep(self._count_end(reason))

    def renew(self, settings_json: str) -> None:
        """End the process and start one with other settings."""
        self._settings_json = settings_json
        if self._life is not None and not self._life.done():  # between two processes the next start uses them
            self._life.cancel()

    def send(self, line: bytes) -> bool:
        """Send a line to the process that runs now; whether there is one that reads.

        Parameters
        ----------
        line : bytes
            Without its end.
        """
        writer = self._writer
        if writer is None or writer.is_closing() or writer.transport.get_write_buffer_size() > UNREAD_MAX_BYTES:
            return False
        writer.write(line + b"\n")
        return True

    def _count_end(self, reason: str) -> float:
        """Report an end and return the pause before the next start, seconds."""
        self._ends = 1 if self._runs_well() else self._ends + 1
        if self._ends >= ENDS_BEFORE_FAILING:
            self._report(
                "failing", ended=True, detail=f"{reason}, {self._ends} times; next try in {FAILING_PAUSE_S:.0f} s"
            )
            return FAILING_PAUSE_S
        self._report("restarting", ended=True, detail=reason)
        return min(FIRST_PAUSE_S * 2 ** (self._ends - 1), LONGEST_PAUSE_S)

    def _receive(self, message: StateMessage | MessageT) -> None:
        if not isinstance(message, StateMessage):
            self._measures_since_s = min(self._measures_since_s, time.monotonic())
            if self._state != "failing" or self._runs_well():
                self._report("running")
        self._on_message(message)

    def _runs_well(self) -> bool:
        return time.monotonic() - self._measures_since_s > GOOD_RUN_TIME_S

    def _report(self, state: State, *, ended: bool = False, detail: str = "") -> None:
        if ended or state != self._state:
            self._state = state
            self._on_health(Health(state, ended, detail))

    async def _live(self) -> str:
        """Run one process to its end and return why it ended."""
        try:
            ours, theirs = socket.socketpair()
        except OSError as error:  # no descriptors
            return f"the measuring process cannot be linked: {error}"
        with ours, theirs:
            try:
                process = await _start(self._module, theirs.fileno())
            except OSError as error:
                return f"the measuring process cannot be started: {error}"
            theirs.close()
            reader, writer = await asyncio.open_unix_connection(sock=ours)
            try:
                writer.write(self._settings_json.encode() + b"\n")
                self._writer = writer
                reason = await _listen(reader, self._messages, self._receive)
            finally:
                self._writer = None
                writer.close()
                await _end(process)
        return f"{reason} ({_how_it_ended(process)})"


async def _start(module: str, link: int) -> Process:
    # in a process group of its own: Ctrl-C ends only the supervisor, which closes the link and so ends the station
    return await asyncio.create_subprocess_exec(
        sys.executable, "-P", "-m", module, str(link),
        pass_fds=(link,), stdin=DEVNULL, stdout=DEVNULL, start_new_session=True,
    )  # fmt: skip


async def _listen(
    reader: asyncio.StreamReader,
    messages: Messages[MessageT],
    on_message: Callable[[StateMessage | MessageT], None],
) -> str:
    limit_s = START_LIMIT_S
    heard_s = time.monotonic()
    try:
        while True:
            # `timeout`, because `wait_for` swallows a cancellation that coincides with an incoming line
            async with asyncio.timeout(heard_s + limit_s - time.monotonic()):
                line = await reader.readline()
            if not line.endswith(b"\n"):
                return "the measuring process ended"  # a last line without its end is discarded
            message = messages.validate_json(line)
            on_message(message)
            measures = not isinstance(message, StateMessage)
            # `starting` does not restart the silence timer. `warming` does; the station stops sending it after
            # WARM_UP_TIME_S.
            if measures or message.fault or message.state == "warming":
                limit_s = SILENCE_LIMIT_S if measures else START_LIMIT_S
                heard_s = time.monotonic()
    except TimeoutError:
        return f"the measuring process did nothing for {limit_s:.0f} s and was ended"
    except (ValueError, ConnectionError) as error:
        return f"the measuring process sent what cannot be read and was ended: {error}"


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
    if code == EXIT_OUT_OF_MEMORY:
        return "it needed more memory than it may have"
    return f"signal {-code}" if code < 0 else f"exit code {code}"
