#!/usr/bin/python3
"""Serves packs with `cairn serve`, compares what it answers with the files and with `cairn sample`, and tries to break
it: paths that leave the packs, malformed and huge ranges, garbage, slow clients, a thousand clients at once, files that
are replaced or damaged meanwhile. All traffic stays on the loopback address.

usage: tests/cli/serve_test.py REPOSITORY PROGRAMS"""

import asyncio
import http.client
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import unittest
import urllib.parse

REPOSITORY, PROGRAMS = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
CAIRN = PROGRAMS / "cairn"
PATIENCE_S = 120  # of a client, before it calls the server dead


def cairn(*arguments, code=0, stdin=None):
    ran = subprocess.run([CAIRN, *map(str, arguments)], capture_output=True, text=True, input=stdin, timeout=PATIENCE_S)
    assert ran.returncode == code, f"cairn {arguments}: {ran.returncode}\n{ran.stdout}\n{ran.stderr}"
    return ran


class Server:
    def __init__(self, *packs):
        self.process = subprocess.Popen([CAIRN, "serve", *map(str, packs), "--port", "0"], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().strip()
        self.port = urllib.parse.urlparse(self.url).port

    def ask(self, target, method="GET", body=None, **fields):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE_S)
        connection.request(method, target, body=body, headers={k.replace("_", "-"): v for k, v in fields.items()})
        answer = connection.getresponse()
        data = answer.read()
        connection.close()
        return answer.status, dict(answer.getheaders()), data

    def send(self, data):
        """Sends bytes as they are; returns all that comes until the server closes."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE_S) as client:
            out = b""
            try:
                client.sendall(data)
                client.shutdown(socket.SHUT_WR)
                while piece := client.recv(65536):
                    out += piece
            except OSError:  # closed by the server
                pass
            return out

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(PATIENCE_S)
        self.process.stdout.close()
        self.process.stderr.close()
        return code


class ServeTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        dem = REPOSITORY / "sample-dem" / "jacksboro_fault.tif"
        cls.pack = cls.folder / "a fault.cairn"
        cls.other = cls.folder / "other.cairn"
        cairn("bake", dem, "-o", cls.pack, "--datum", "egm96")
        cairn("bake", dem, "-o", cls.other, "--datum", "ellipsoid", "--max-error", "5")
        (cls.folder / "secret.txt").write_text("SECRET")
        cls.bytes = cls.pack.read_bytes()
        cls.server = Server(cls.pack, cls.other)
        cls.target = "/packs/a%20fault.cairn"

    @classmethod
    def tearDownClass(cls):
        code = cls.server.stop()
        shutil.rmtree(cls.folder)
        assert code == 0, f"cairn serve: exit {code} on SIGTERM"

    def alive(self):
        status, _, data = self.server.ask(self.target, Range="bytes=0-7")
        self.assertEqual((status, data), (206, b"\x89CAIRN\r\n"))

    def test_list_and_whole_file(self):
        status, fields, data = self.server.ask("/packs.json")
        self.assertEqual(status, 200)
        packs = json.loads(data)
        self.assertEqual([p["name"] for p in packs], ["a fault.cairn", "other.cairn"])
        info = json.loads(cairn("info", self.pack, "--json").stdout)
        self.assertEqual(packs[0]["bytes"], len(self.bytes))
        self.assertIn(packs[0]["id"], json.dumps(info))
        status, fields, data = self.server.ask("/" + packs[0]["url"])
        self.assertEqual((status, data), (200, self.bytes))
        self.assertEqual(fields["ETag"], f'"{packs[0]["id"]}"')
        self.assertEqual(fields["Access-Control-Allow-Origin"], "*")
        status, fields, data = self.server.ask(self.target, method="HEAD")
        self.assertEqual((status, data, fields["Content-Length"]), (200, b"", str(len(self.bytes))))
        status, fields, _ = self.server.ask(self.target, method="OPTIONS")
        self.assertEqual(status, 204)
        self.assertIn("Range", fields["Access-Control-Allow-Headers"])

    def test_ranges(self):
        size = len(self.bytes)
        dice = random.Random(1)
        for _ in range(200):
            first = dice.randrange(size)
            last = dice.randrange(first, size + 100)
            status, fields, data = self.server.ask(self.target, Range=f"bytes={first}-{last}")
            self.assertEqual((status, data), (206, self.bytes[first:last + 1]))
            self.assertEqual(fields["Content-Range"], f"bytes {first}-{min(last, size - 1)}/{size}")
        huge = "9" * 60
        for text, expected in [("bytes=5-", self.bytes[5:]), ("bytes=-7", self.bytes[-7:]), ("Bytes = 1-2", self.bytes[1:3]),
                               (f"bytes=-{huge}", self.bytes), (f"bytes=0-{huge}", self.bytes)]:
            status, _, data = self.server.ask(self.target, Range=text)
            self.assertEqual((status, data), (206, expected), text)
        for text in [f"bytes={size}-", f"bytes={huge}-", f"bytes={huge}-{huge}", "bytes=-0", "bytes=2-1", "bytes=", "bytes=-",
                     "bytes=a-b", "bytes=0-1,3-4", "bytes=" + "0-0," * 1000 + "0-0", "bytes=+1-2", "bytes=0x1-2", "bytes",
                     "bytes=1-2-3", "bytes=18446744073709551615-18446744073709551616"]:
            status, fields, data = self.server.ask(self.target, Range=text)
            self.assertEqual((status, data), (416, b""), text)
            self.assertEqual(fields["Content-Range"], f"bytes */{size}")
        self.assertEqual(self.server.ask(self.target, Range="lines=1-2")[0], 200)

    def test_conditions(self):
        etag = self.server.ask(self.target, method="HEAD")[1]["ETag"]
        self.assertEqual(self.server.ask(self.target, If_None_Match=etag)[0], 304)
        self.assertEqual(self.server.ask(self.target, If_None_Match=f'"x", {etag}')[0], 304)
        self.assertEqual(self.server.ask(self.target, If_None_Match='"x"', Range="bytes=0-1")[0], 206)
        self.assertEqual(self.server.ask(self.target, If_Match='"x"', Range="bytes=0-1")[0], 412)
        self.assertEqual(self.server.ask(self.target, If_Match=etag, Range="bytes=0-1")[0], 206)
        self.assertEqual(self.server.ask(self.target, If_Range=etag, Range="bytes=0-1")[0], 206)
        self.assertEqual(self.server.ask(self.target, If_Range='"x"', Range="bytes=0-1")[2], self.bytes)

    def test_paths_stay_in_the_packs(self):
        names = ["../secret.txt", "secret.txt", "..%2fsecret.txt", "%2e%2e/secret.txt", "..%5csecret.txt", "/etc/passwd",
                 "%2fetc%2fpasswd", "a%20fault.cairn/../secret.txt", "a%20fault.cairn/..", "a%20fault.cairn%00.txt", ".", "..", "",
                 "....//secret.txt", str(self.folder / "secret.txt"), "~/secret.txt", "%252e%252e%252fsecret.txt", "A FAULT.cairn",
                 "file:///etc/passwd", "\\secret.txt", "a%20fault.cairn/", "a+fault.cairn"]
        for prefix in ["/packs/", "/terrarium/", "/quantized-mesh/", "/", "/page/", "//"]:
            for name in names:
                answer = self.server.send(f"GET {prefix}{name} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n".encode())
                self.assertNotIn(b"SECRET", answer)
                self.assertNotIn(b"root:", answer)
                if name != "" and not (prefix == "/packs/" and name == "a%20fault.cairn/"):
                    self.assertNotIn(b" 200 ", answer.split(b"\r\n")[0], prefix + name)
        self.alive()

    def test_garbage(self):
        dice = random.Random(2)
        for _ in range(100):
            self.server.send(dice.randbytes(dice.randrange(1, 3000)))
        request = f"GET {self.target} HTTP/1.1\r\nHost: x\r\nRange: bytes=0-99\r\n\r\n".encode()
        for _ in range(300):  # flipped, cut and doubled
            data = bytearray(request)
            data[dice.randrange(len(data))] ^= 1 << dice.randrange(8)
            self.server.send(bytes(data[:dice.randrange(1, len(data) + 1)]))
        first_line = lambda data: self.server.send(data).split(b"\r\n")[0]
        self.assertIn(b" 431 ", first_line(b"GET / HTTP/1.1\r\nX: " + b"a" * 100000 + b"\r\n\r\n"))
        self.assertIn(b" 431 ", first_line(b"GET /" + b"a" * 100000 + b" HTTP/1.1\r\n\r\n"))
        self.assertIn(b" 431 ", first_line(b"GET / HTTP/1.1\r\n" + b"X: a\r\n" * 5000 + b"\r\n"))
        self.assertIn(b" 413 ", first_line(b"GET / HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n"))
        self.assertIn(b" 413 ", first_line(b"GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nffffffff\r\n"))
        self.assertIn(b" 400 ", first_line(b"GET / HTTP/1.1\r\nContent-Length: 3\r\nContent-Length: 4\r\n\r\nabc"))
        self.assertIn(b" 400 ", first_line(b"GET / HTTP/9.9\r\n\r\n"))
        self.assertIn(b" 400 ", first_line(b"GET /%zz HTTP/1.1\r\n\r\n"))
        self.assertIn(b" 400 ", first_line(b"GET http://elsewhere/ HTTP/1.1\r\n\r\n"))
        for method in ["POST", "PUT", "DELETE", "PATCH", "TRACE", "CONNECT", "PROPFIND"]:
            self.assertIn(b" 405 ", first_line(f"{method} {self.target} HTTP/1.1\r\n\r\n".encode()), method)
        self.assertEqual(self.pack.read_bytes(), self.bytes)
        self.alive()

    def test_heights(self):
        dice = random.Random(3)
        places = [(dice.uniform(-84.5, -84.0), dice.uniform(36.4, 36.8)) for _ in range(1000)]
        lon, lat = (",".join(repr(p[i]) for p in places) for i in (0, 1))
        # Too long for a request: in parts of a hundred.
        answers = []
        for i in range(0, 1000, 100):
            part = places[i:i + 100]
            lon, lat = (",".join(repr(p[k]) for p in part) for k in (0, 1))
            status, _, data = self.server.ask(f"/heights?lon={lon}&lat={lat}&pack=a+fault.cairn")
            self.assertEqual(status, 200)
            answers += json.loads(data)
        points = "lon,lat\n" + "".join(f"{x!r},{y!r}\n" for x, y in places)
        expected = json.loads(cairn("sample", self.pack, "--points", "-", "--json", stdin=points).stdout)
        self.assertEqual([a["height"] for a in answers], [e["height"] for e in expected])
        self.assertTrue(any(a["height"] is None for a in answers))
        self.assertTrue(sum(a["height"] is not None for a in answers) > 100)
        for query in ["", "lon=1", "lat=1", "lon=a&lat=1", "lon=nan&lat=1", "lon=inf&lat=1", "lon=1&lat=91", "lon=1,2&lat=1",
                      "lon=1&lat=", "lon=1,&lat=1,", "lon=1e999&lat=1", "lon=0x1&lat=1", "lon=1%00&lat=1",
                      "lon=" + ",".join("1" * 1001) + "&lat=" + ",".join("1" * 1001)]:
            self.assertEqual(self.server.ask("/heights?" + query)[0], 400, query)
        self.assertEqual(self.server.ask("/heights?lon=1&lat=1&pack=none")[0], 404)

    def test_terrarium(self):
        import numpy as np
        import rasterio
        status, fields, data = self.server.ask("/terrarium/a%20fault.cairn/10/272/399.png")
        self.assertEqual((status, fields["Content-Type"]), (200, "image/png"))
        with rasterio.MemoryFile(data) as file, file.open() as image:
            red, green, blue = image.read().astype(float)
        metres = red * 256 + green + blue / 256 - 32768
        dice = random.Random(4)
        pixels = [(dice.randrange(512), dice.randrange(512)) for _ in range(200)]
        lon = [(272 + (x + 0.5) / 512) / 1024 * 360 - 180 for x, _ in pixels]
        lat = [float(np.degrees(np.arctan(np.sinh(np.pi * (1 - 2 * (399 + (y + 0.5) / 512) / 1024))))) for _, y in pixels]
        level = 2
        points = "lon,lat\n" + "".join(f"{a!r},{b!r}\n" for a, b in zip(lon, lat))
        expected = json.loads(cairn("sample", self.pack, "--points", "-", "--json", "--level", level, stdin=points).stdout)
        compared = 0
        for (x, y), e in zip(pixels, expected):
            if e["height"] is not None:
                self.assertAlmostEqual(metres[y, x], e["height"], delta=1 / 512 + 1e-9)
                compared += 1
        self.assertGreater(compared, 50)
        tiles = json.loads(self.server.ask("/terrarium/a%20fault.cairn/tiles.json")[2])
        self.assertEqual(tiles["encoding"], "terrarium")
        for tile in ["0/1/0.png", "-1/0/0.png", "99/0/0.png", "10/272/399.jpg", "10/272/399", "1e1/0/0.png", "10/0/0.png",
                     "10/99999999999999999999/0.png", "10/272/399.png/x"]:
            self.assertEqual(self.server.ask("/terrarium/a%20fault.cairn/" + tile)[0], 404, tile)

    def test_quantized_mesh(self):
        out = self.folder / "meshes"
        cairn("export", self.other, "-o", out, "--format", "quantized-mesh")
        layer = json.loads(self.server.ask("/quantized-mesh/other.cairn/layer.json")[2])
        written = json.loads((out / "layer.json").read_text())
        self.assertEqual((layer["format"], layer["maxzoom"]), ("quantized-mesh-1.0", written["maxzoom"]))
        self.assertEqual(layer["vertical_datum"], "ellipsoid")
        tiles = sorted(out.glob("*/*/*.terrain"))
        for tile in tiles[:6] + tiles[-6:]:
            status, fields, data = self.server.ask(f"/quantized-mesh/other.cairn/{tile.relative_to(out)}?v=1")
            self.assertEqual((status, fields["Content-Type"]), (200, "application/vnd.quantized-mesh"))
            self.assertEqual(data, tile.read_bytes(), tile)
        for tile in ["0/2/0.terrain", "0/0/1.terrain", "31/0/0.terrain", "99/0/0.terrain", "a/0/0.terrain", "0/0/0", "8/0/0.terrain",
                     "0/-1/0.terrain", "0/99999999999999/0.terrain", "../layer.json"]:
            self.assertEqual(self.server.ask("/quantized-mesh/other.cairn/" + tile)[0], 404, tile)

    def test_a_thousand_clients_at_once(self):
        async def client(i, barrier):
            reader, writer = await asyncio.open_connection("127.0.0.1", self.server.port)
            barrier.append(i)
            while len(barrier) < 1000:  # all are connected before any asks
                await asyncio.sleep(0.05)
            first = i * 37 % (len(self.bytes) - 5000)
            writer.write(f"GET {self.target} HTTP/1.1\r\nHost: x\r\nRange: bytes={first}-{first + 4999}\r\n"
                         "Connection: close\r\n\r\n".encode())
            data = await reader.read(-1)
            writer.close()
            return data.partition(b"\r\n\r\n")[2] == self.bytes[first:first + 5000]

        async def all_clients():
            barrier = []
            return await asyncio.gather(*(client(i, barrier) for i in range(1000)))

        import resource
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))
        self.assertEqual(sum(asyncio.run(all_clients())), 1000)
        self.alive()

    def test_slow_clients_are_cut_off_and_keep_nobody_waiting(self):
        slow = [socket.create_connection(("127.0.0.1", self.server.port)) for _ in range(300)]
        for client in slow[:100]:
            client.sendall(b"GET / HTTP/1.1\r\nX-Slow: ")
        for client in slow[100:200]:  # ask for the file, and do not read
            client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
            client.sendall(f"GET {self.target} HTTP/1.1\r\nHost: x\r\n\r\n".encode())
        self.alive()
        # Those that go on sending a byte now and then, and those that send nothing, are closed.
        closed = 0
        for _ in range(PATIENCE_S):
            for client in slow[:100]:
                try:
                    client.send(b"a")
                except OSError:
                    pass
            try:
                slow[0].settimeout(1)
                closed = slow[0].recv(1) == b""
            except TimeoutError:
                continue
            except ConnectionError:
                closed = True
            if closed:
                break
        self.assertTrue(closed)
        slow[250].settimeout(PATIENCE_S)
        self.assertEqual(slow[250].recv(1), b"")
        for client in slow:
            client.close()
        self.alive()


class ReplacedFileTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        dem = REPOSITORY / "sample-dem" / "jacksboro_fault.tif"
        self.old, self.new = self.folder / "old.cairn", self.folder / "new.cairn"
        cairn("bake", dem, "-o", self.old, "--datum", "egm96")
        cairn("bake", dem, "-o", self.new, "--datum", "egm96", "--max-error", "5")
        self.pack = self.folder / "pack.cairn"
        shutil.copy(self.old, self.pack)
        self.server = Server(self.pack)

    def tearDown(self):
        self.assertEqual(self.server.stop(), 0)
        shutil.rmtree(self.folder)

    def test_replaced_damaged_and_removed(self):
        etag = self.server.ask("/packs/pack.cairn", method="HEAD")[1]["ETag"]
        shutil.copy(self.new, self.folder / "part")
        os.rename(self.folder / "part", self.pack)
        status, fields, data = self.server.ask("/packs/pack.cairn")
        self.assertEqual((status, data), (200, self.new.read_bytes()))
        self.assertNotEqual(fields["ETag"], etag)
        self.assertEqual(self.server.ask("/packs/pack.cairn", If_Match=etag, Range="bytes=0-9")[0], 412)
        (self.folder / "part").write_bytes(self.old.read_bytes()[:30000])
        os.rename(self.folder / "part", self.pack)
        status, _, data = self.server.ask("/packs/pack.cairn")
        self.assertEqual(status, 503)
        self.assertIn("pack.cairn", json.loads(data)["error"])
        self.assertEqual(self.server.ask("/heights?lon=-84.2&lat=36.6")[0], 503)
        self.assertIn("error", json.loads(self.server.ask("/packs.json")[2])[0])
        shutil.copy(self.old, self.folder / "part")
        os.rename(self.folder / "part", self.pack)
        self.assertEqual(self.server.ask("/packs/pack.cairn")[1]["ETag"], etag)
        self.pack.unlink()
        self.assertEqual(self.server.ask("/packs/pack.cairn")[2], self.old.read_bytes())
        # A block of heights that is damaged on the disk is told.
        data = bytearray(self.old.read_bytes())
        data[20000] ^= 1
        for at in range(16384, len(data) - 30000, 50):
            data[at] ^= 1
        (self.folder / "part").write_bytes(data)
        os.rename(self.folder / "part", self.pack)
        status, _, data = self.server.ask("/heights?lon=-84.2&lat=36.6")
        self.assertIn(status, (500, 503))
        self.assertIn("checksum", json.loads(data)["error"])

    def test_command_lines(self):
        (self.folder / "sub").mkdir()
        shutil.copy(self.old, self.folder / "sub" / "pack.cairn")
        for arguments, code in [([self.pack, self.folder / "sub" / "pack.cairn"], 2), ([self.folder / "none.cairn"], 1),
                                ([self.pack, "--port", "99999"], 2), ([self.pack, "--port", "x"], 2), ([], 2),
                                ([self.pack, "--bind", "nowhere"], 2), ([self.pack, "--port", self.server.port], 1),
                                ([REPOSITORY / "LICENSE"], 3)]:
            ran = cairn("serve", *arguments, code=code)
            self.assertEqual(ran.stdout, "")
            self.assertEqual(len(ran.stderr.strip().splitlines()), 1, ran.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
