#!/usr/bin/env python3
"""A server of byte ranges that fails in every way a network can: range_server.py FOLDER

Prints its port, then serves FOLDER until its input ends. An address is /FAULT/FILE, and FAULT is one of:
  ok           ranges as they should be
  slow         each answer 50 ms late
  short        the first try of each range ends in the middle
  cut          every try of each range ends in the middle
  flaky        the first try of each range is a 503
  broken       500
  gone, denied 404, 403
  whole        200 and the whole file, whatever is asked for
  packed       Content-Encoding: gzip
  shifted      a range that begins a byte later
  unsaid       206 without Content-Range
  longer       more bytes than were asked for
  shrunk       416 for whatever lies past the first 16,384 bytes
  garbled      a wrong byte in the middle of the first answer for each range past the first 16,384 bytes
  poisoned     a wrong byte in every answer past the first 16,384 bytes
  tagged       with an ETag that is the file's time
  moved        302 to ok
/count is how many ranges were asked for since it was last asked.
"""
import gzip
import http.server
import os
import re
import sys
import threading
import time

START = 16384
lock = threading.Lock()
seen, count = set(), 0


def is_first(key):
    with lock:
        new = key not in seen
        seen.add(key)
        return new


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def answer(self, status, body=b"", headers=(), length=None):
        self.send_response(status)
        for name, value in headers:
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body) if length is None else length))
        self.end_headers()
        self.wfile.write(body)

    def do_GET(self):
        global count
        if self.path == "/count":
            with lock:
                text, count = str(count).encode(), 0
            return self.answer(200, text)
        _, fault, name = self.path.split("/", 2)
        path = os.path.join(sys.argv[1], name)
        wanted = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
        with lock:
            count += 1
        if fault == "moved":
            return self.answer(302, headers=[("Location", f"/ok/{name}")])
        if fault in ("gone", "denied", "broken"):
            return self.answer({"gone": 404, "denied": 403, "broken": 500}[fault])
        if not os.path.exists(path) or not wanted:
            return self.answer(404)
        with open(path, "rb") as file:
            data = file.read()
        if fault == "whole":
            return self.answer(200, data)
        first, last = int(wanted[1]), min(int(wanted[2]), len(data) - 1)
        if first >= len(data) or (fault == "shrunk" and first >= START):
            return self.answer(416, headers=[("Content-Range", f"bytes */{len(data)}")])
        body, key = bytearray(data[first:last + 1]), (self.path, first, last)
        if fault == "slow":
            time.sleep(0.05)
        if fault == "flaky" and is_first(key):
            return self.answer(503)
        if first >= START and (fault == "poisoned" or (fault == "garbled" and is_first(key))):
            body[len(body) // 2] ^= 1
        headers = [("Content-Range", f"bytes {first + (fault == 'shifted')}-{last}/{len(data)}")]
        if fault == "unsaid":
            headers = []
        if fault == "tagged":
            headers.append(("ETag", f'"{os.stat(path).st_mtime_ns}"'))
        if fault == "packed":
            body, headers = gzip.compress(body), headers + [("Content-Encoding", "gzip")]
        if fault == "longer":
            body += b"more"
        length = len(body)
        if fault == "cut" or (fault == "short" and is_first(key)):
            body, self.close_connection = body[:length // 2], True
        return self.answer(206, bytes(body), headers, length)


server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
threading.Thread(target=server.serve_forever, daemon=True).start()
print(server.server_port, flush=True)
sys.stdin.read()
