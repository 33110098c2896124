"""A gauge whose output nobody reads, or that cannot be written, measures and stops as any other."""

import os
import signal
import socket
import subprocess
import sys
import time

import pytest
from running import free_port


def serve(port: int, tmp_path, *shell: str, **streams: object) -> subprocess.Popen:
    config = tmp_path / "gauge.toml"
    config.write_text(f'[plc]\nport = {port}\n[sizing.camera]\nkind = "mill"\nprepared_frames = 5\n')
    return subprocess.Popen([*shell, sys.executable, "-m", "appliance", "run", "--config", str(config)], **streams)


def answers(port: int) -> bool:
    try:
        with socket.create_connection(("127.0.0.1", port), 1) as connection:
            connection.settimeout(2)
            connection.sendall(bytes.fromhex("0001 0000 0006 01 04 0002 0001"))
            return len(connection.recv(64)) == 11
    except OSError:
        return False


def wait_for_answer(port: int, process: subprocess.Popen) -> None:
    until_s = time.monotonic() + 90
    while not answers(port):
        assert process.poll() is None
        assert time.monotonic() < until_s
        time.sleep(0.2)


def test_a_standard_error_that_nobody_reads_blocks_nothing(tmp_path):
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    while True:
        try:
            os.write(writer, b"x" * 4096)
        except BlockingIOError:
            break
    os.set_blocking(writer, True)
    port = free_port()
    process = serve(port, tmp_path, stdout=writer, stderr=writer)
    try:
        wait_for_answer(port, process)
        children = subprocess.run(["pgrep", "-P", str(process.pid)], check=True, capture_output=True, text=True).stdout
        for child in children.split():
            os.kill(int(child), signal.SIGKILL)  # a fault, so that there is something to log
        time.sleep(3)
        assert answers(port)
        process.send_signal(signal.SIGINT)
        assert process.wait(15) == 0
    finally:
        process.kill()
        process.wait()
        os.close(reader)
        os.close(writer)


@pytest.mark.parametrize("output", ["/dev/full", "closed pipe", "closed"])
def test_a_welcome_that_cannot_be_written_ends_nothing(tmp_path, output):
    words = ()
    if output == "closed":  # the station's crash is logged to the other closed stream
        stream, words = subprocess.DEVNULL, ("sh", "-c", 'exec "$@" >&- 2>&-', "sh")
    elif output == "/dev/full":
        stream = os.open(output, os.O_WRONLY)
    else:
        reader, stream = os.pipe()
        os.close(reader)
    port = free_port()
    process = serve(port, tmp_path, *words, stdout=stream, stderr=subprocess.DEVNULL)
    try:
        wait_for_answer(port, process)
        time.sleep(1)
        assert answers(port)
        process.send_signal(signal.SIGINT)
        assert process.wait(15) == 0
    finally:
        process.kill()
        process.wait()
        if output != "closed":
            os.close(stream)
