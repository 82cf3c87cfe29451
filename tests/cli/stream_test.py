#!/usr/bin/python3
"""Serves packs with `cairn serve --stream`, looks at the pictures that it sends, and tries to break it: clients that
show nothing, that send garbage, that are too many, drawing processes that are killed. All traffic stays on the loopback
address.

usage: tests/cli/stream_test.py REPOSITORY PROGRAMS"""

import asyncio
import http.client
import json
import os
import pathlib
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.parse

import numpy
import rasterio
import rasterio.io
import websockets

REPOSITORY, PROGRAMS = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
CAIRN = PROGRAMS / "cairn"
PATIENCE_S = 120
CAMERA = [-84.27, 36.36, 3500, 25, -30]
HOUR = 9
SIZE = [320, 180]


def text_of(file):
    """Of a process or a thread, which may have ended since it was listed: nothing then."""
    try:
        return file.read_text()
    except OSError:
        return ""


class Server:
    def __init__(self, *arguments):
        self.process = subprocess.Popen([CAIRN, "serve", *map(str, arguments), "--port", "0"], stdout=subprocess.PIPE,
                                        stderr=subprocess.DEVNULL, text=True)
        self.url = urllib.parse.urlparse(self.process.stdout.readline().strip())

    def ask(self, target, **fields):
        connection = http.client.HTTPConnection("127.0.0.1", self.url.port, timeout=PATIENCE_S)
        connection.request("GET", target, headers={k.replace("_", "-"): v for k, v in fields.items()})
        answer = connection.getresponse()
        data = answer.read()
        connection.close()
        return answer.status, data

    def stream(self, name="fault.cairn"):
        return websockets.connect(f"ws://127.0.0.1:{self.url.port}/stream/{name}", open_timeout=PATIENCE_S,
                                  max_size=1 << 24)

    def drawing(self):
        """The processes that draw for this server's viewers."""
        children = pathlib.Path(f"/proc/{self.process.pid}/task").glob("*/children")
        pids = [int(pid) for file in children for pid in text_of(file).split()]
        return [pid for pid in pids if text_of(pathlib.Path(f"/proc/{pid}/comm")).startswith("cairn-stream")]

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(PATIENCE_S)
        self.process.stdout.close()
        return code


def frame_of(message):
    length, = struct.unpack_from("<I", message)
    return json.loads(message[4:4 + length]), message[4 + length:]


def pixels_of(jpeg_or_png):
    with rasterio.io.MemoryFile(jpeg_or_png) as file, file.open() as picture:
        return picture.read().astype(float)


async def take(socket):
    return frame_of(await asyncio.wait_for(socket.recv(), PATIENCE_S))


async def last_picture(socket):
    """Shows frames until one has all that the view needs, and another second brings no other. Returns that one."""
    picture = note = None
    while True:
        try:
            patience = PATIENCE_S if picture is None or not note["complete"] else 1.5
            new, jpeg = frame_of(await asyncio.wait_for(socket.recv(), patience))
        except asyncio.TimeoutError:
            return note, picture
        note, picture = new, jpeg or picture
        await socket.send(json.dumps({"shown": note["frame"]}))


class StreamTest(unittest.IsolatedAsyncioTestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.pack = cls.folder / "fault.cairn"
        subprocess.run([CAIRN, "bake", REPOSITORY / "sample-dem" / "jacksboro_fault.tif", "-o", cls.pack, "--datum", "egm96"],
                       check=True, capture_output=True)
        cls.server = Server(cls.pack, "--stream", "--viewers", "2")

    @classmethod
    def tearDownClass(cls):
        drawing = cls.server.drawing()
        assert cls.server.stop() == 0
        assert not [pid for pid in drawing if pathlib.Path(f"/proc/{pid}").exists()], "processes that outlive the server"
        cls.temporary.cleanup()

    async def wait_for_places(self):
        """Until the processes of viewers that are gone have ended."""
        end = time.monotonic() + PATIENCE_S
        while self.server.drawing() and time.monotonic() < end:
            await asyncio.sleep(0.1)
        self.assertEqual(self.server.drawing(), [])

    async def asyncTearDown(self):
        await self.wait_for_places()

    def test_list_says_where(self):
        status, body = self.server.ask("/packs.json")
        self.assertEqual(status, 200)
        self.assertEqual(json.loads(body)[0]["stream"], "stream/fault.cairn")

    async def test_picture_is_that_of_the_viewer(self):
        shot = self.folder / "shot.png"
        subprocess.run([CAIRN, "view", self.pack, "--camera", ",".join(map(str, CAMERA)), "--hour", str(HOUR),
                        "--size", "x".join(map(str, SIZE)), "--screenshot", shot], check=True, capture_output=True)
        async with self.server.stream() as socket:
            await socket.send(json.dumps({"size": SIZE, "camera": CAMERA, "hour": HOUR, "input": 7}))
            note, jpeg = await last_picture(socket)
        self.assertEqual((note["size"], note["input"], note["complete"]), (SIZE, 7, True))
        numpy.testing.assert_allclose(note["camera"], CAMERA, atol=1e-3)
        sent, expected = pixels_of(jpeg), pixels_of(shot.read_bytes())[:3]
        self.assertEqual(sent.shape, expected.shape)
        # JPEG blurs colours; a picture of another camera or hour is off by much more.
        self.assertLess(numpy.abs(sent - expected).mean(), 4)
        self.assertLess(numpy.percentile(numpy.abs(sent.mean(0) - expected.mean(0)), 99), 24)

    async def test_keys_move_the_eye(self):
        async with self.server.stream() as socket:
            await socket.send(json.dumps({"size": [64, 64], "camera": CAMERA}))
            before, _ = await last_picture(socket)
            await socket.send(json.dumps({"held": [1, 0, 0, 1], "input": 1}))
            while (moving := (await take(socket))[0])["input"] < 1:
                pass
            for _ in range(5):
                await socket.send(json.dumps({"shown": moving["frame"]}))
                moving, _ = await take(socket)
            await socket.send(json.dumps({"held": [0, 0, 0, 1], "turn": 90, "input": 2, "shown": moving["frame"]}))
            after, _ = await last_picture(socket)
        self.assertEqual(after["input"], 2)
        self.assertGreater(after["camera"][1], before["camera"][1])  # to the north-east
        self.assertGreater(after["camera"][0], before["camera"][0])
        self.assertAlmostEqual(after["camera"][3], before["camera"][3] + 90, delta=0.5)

    async def test_a_viewer_that_shows_nothing_gets_two_frames_and_then_the_newest_state(self):
        async with self.server.stream() as socket:
            await socket.send(json.dumps({"size": [64, 64], "camera": CAMERA, "held": [1, 0, 0, 1]}))
            first, second = (await take(socket))[0], (await take(socket))[0]
            self.assertEqual((first["frame"], second["frame"]), (1, 2))
            with self.assertRaises(asyncio.TimeoutError):
                await asyncio.wait_for(socket.recv(), 1.5)
            await socket.send(json.dumps({"camera": [-84, 36, 9000, 0, -45], "held": [0, 0, 0, 1], "shown": 2}))
            third = (await take(socket))[0]
            self.assertEqual(third["frame"], 3)
            self.assertAlmostEqual(third["camera"][2], 9000, delta=1)

    async def test_what_is_malformed_ends_the_stream_with_a_reason(self):
        for text, reason in [("{", "expected a JSON object"), ("[]", "expected a JSON object"),
                             ('{"size": [1, 1]}', "size: expected a number from 64"),
                             ('{"size": [100000, 100]}', "size: expected"), ('{"size": "big"}', "size: expected an array"),
                             ('{"camera": [0, 91, 0, 0, 0]}', "latitude: expected"),
                             ('{"camera": [0, 0, 1e400, 0, 0]}', ""), ('{"held": [2, 0, 0, 1]}', "held: ahead"),
                             ('{"hour": null}', "hour: expected"), ('{"shown": -1}', "shown: expected a whole number"),
                             ('{"turn": 1e9}', "turn: expected"), ('{"hour": "' + "x" * 5000 + '"}', "")]:
            async with self.server.stream() as socket:
                await socket.send(text)
                with self.assertRaises(websockets.ConnectionClosed) as closed:
                    while True:
                        await asyncio.wait_for(socket.recv(), PATIENCE_S)
                if reason:
                    self.assertIn(reason, closed.exception.rcvd.reason, text[:40])
            await self.wait_for_places()
        async with self.server.stream() as socket:  # it still draws
            await take(socket)

    async def test_more_viewers_than_allowed_are_refused(self):
        async with self.server.stream() as one, self.server.stream() as two:
            await take(one)
            await take(two)
            with self.assertRaises(websockets.InvalidStatusCode) as refused:
                await self.server.stream()
            self.assertEqual(refused.exception.status_code, 503)
            self.assertEqual(self.server.ask("/packs.json")[0], 200)
        await self.wait_for_places()
        async with self.server.stream() as three:
            await take(three)

    async def test_a_process_that_dies_ends_one_stream_only(self):
        async with self.server.stream() as one:
            await take(one)
            victim, = self.server.drawing()
            async with self.server.stream() as two:
                await take(two)
                os.kill(victim, signal.SIGKILL)
                with self.assertRaises(websockets.ConnectionClosed):
                    while True:
                        await asyncio.wait_for(one.recv(), PATIENCE_S)
                await two.send(json.dumps({"camera": CAMERA, "input": 3, "shown": 2}))
                while (await take(two))[0]["input"] < 3:
                    pass
        self.assertEqual(self.server.ask("/packs.json")[0], 200)

    def test_other_requests_are_refused(self):
        websocket = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec_WebSocket_Version": "13"}
        key = {"Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ=="}
        self.assertEqual(self.server.ask("/stream/fault.cairn")[0], 426)
        self.assertEqual(self.server.ask("/stream/fault.cairn", **{**websocket, **key, "Sec_WebSocket_Version": "8"})[0], 426)
        self.assertEqual(self.server.ask("/stream/fault.cairn", **websocket)[0], 400)
        self.assertEqual(self.server.ask("/stream/fault.cairn", **websocket, Sec_WebSocket_Key="$(true)")[0], 400)
        self.assertEqual(self.server.ask("/stream/other.cairn", **websocket, **key)[0], 404)
        self.assertEqual(self.server.ask("/stream/", **websocket, **key)[0], 404)

    def test_without_the_option_nothing_is_drawn(self):
        server = Server(self.pack)
        self.assertNotIn(b"stream", server.ask("/packs.json")[1])
        self.assertEqual(server.ask("/stream/fault.cairn")[0], 404)
        self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
