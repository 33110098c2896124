"""One answer is made from one image."""

import asyncio
import threading
from types import SimpleNamespace
from typing import cast

from modbus_wire import (
    LIVE,
    served,
)
from torn_reads import agrees_with_itself, count_torn

from plc.process_image import ProcessImage, encode
from plc.server import ModbusServer


def moment(n: int) -> ProcessImage:
    return encode({"sequence": n, "diameter": 80 + n % 200 + 0.01, "deviation": n % 100, "bar_max": n % 300})


def test_no_block_is_ever_torn_while_another_thread_publishes(server):
    images = [moment(n) for n in range(256)]
    published = {image.words for image in images} | {encode(LIVE).words}
    stop = threading.Event()

    def publish() -> None:
        while not stop.wait(0.0002):
            server.publish(images[publish.count % 256])
            publish.count += 1

    publish.count = 0
    thread = threading.Thread(target=publish)
    thread.start()
    try:
        exact = count_torn(server.port, 2.0, published.__contains__)
        by_itself = count_torn(server.port, 0.5, agrees_with_itself)
    finally:
        stop.set()
        thread.join()
    assert publish.count > 500
    assert exact.read > 500
    assert exact.torn == by_itself.torn == 0


def test_the_same_count_sees_torn_reads_when_an_image_is_updated_word_by_word():
    server = ModbusServer("127.0.0.1", 0)
    words = bytearray(moment(0).words)
    careless = SimpleNamespace(
        words=words, reading_ring=b"", ingot_ring=b"", bars=b"", coils=0, discretes=0, word_order="big"
    )
    server.publish(cast("ProcessImage", careless))
    images = [moment(n).words for n in range(256)]

    async def update() -> None:
        n = 0
        while True:
            n = (n + 1) % 256
            for place in range(0, 240, 2):
                words[place : place + 2] = images[n][place : place + 2]
                await asyncio.sleep(0)

    with served(server) as loop:
        updating = asyncio.run_coroutine_threadsafe(update(), loop)
        exact = count_torn(server.port, 0.5, set(images).__contains__)
        by_itself = count_torn(server.port, 0.5, agrees_with_itself)
        updating.cancel()
        asyncio.run_coroutine_threadsafe(asyncio.sleep(0), loop).result(1)  # let the cancelled task end
    assert exact.torn > 0
    assert by_itself.torn > 0
