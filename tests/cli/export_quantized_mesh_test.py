#!/usr/bin/python3
"""Bakes packs, exports them as quantized-mesh and reads every tile with a decoder of its own.

usage: tests/cli/export_quantized_mesh_test.py REPOSITORY PROGRAMS"""

import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

import numpy as np

REPOSITORY, PROGRAMS = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
LARGEST = 32767
ROOT_ERROR = 77067.34


def cairn(*arguments, code=0):
    ran = subprocess.run([PROGRAMS / "cairn", *map(str, arguments)], capture_output=True, text=True)
    assert ran.returncode == code, f"cairn {arguments}: {ran.returncode}\n{ran.stdout}\n{ran.stderr}"
    return ran


def zigzag_sums(values):
    values = values.astype(np.int64)
    return np.cumsum((values >> 1) ^ -(values & 1))


class Tile:
    """One .terrain file, after the quantized-mesh README."""

    def __init__(self, path, level, x, y):
        data = path.read_bytes()
        self.level, self.x, self.y, self.width = level, x, y, 180 / 2**level
        self.west, self.south = x * self.width - 180, y * self.width - 90
        head = struct.unpack_from("<3d2f7d", data)
        self.header, (self.low, self.high) = np.array(head), head[3:5]
        (count,) = struct.unpack_from("<I", data, 88)
        packed = np.frombuffer(data, "<u2", 3 * count, 92).reshape(3, count)
        self.u, self.v, self.q = (zigzag_sums(row) for row in packed)
        self.metres = self.low + self.q * (self.high - self.low) / LARGEST
        kind, at = ("<u2", 92 + 6 * count) if count <= 65536 else ("<u4", -(-(92 + 6 * count) // 4) * 4)
        size = int(kind[2])
        (triangles,) = struct.unpack_from("<I", data, at)
        codes = np.frombuffer(data, kind, 3 * triangles, at + 4).astype(np.int64)
        highest = np.concatenate([[0], np.cumsum(codes == 0)[:-1]])
        self.triangles = (highest - codes).reshape(-1, 3)
        at += 4 + 3 * triangles * size
        self.edges = []
        for _ in range(4):  # west, south, east, north
            (n,) = struct.unpack_from("<I", data, at)
            self.edges.append(np.frombuffer(data, kind, n, at + 4).astype(np.int64))
            at += 4 + n * size
        self.extensions = {}
        while at < len(data):
            number, length = struct.unpack_from("<BI", data, at)
            self.extensions[number] = data[at + 5 : at + 5 + length]
            at += 5 + length
        assert at == len(data)
        self.normals = np.frombuffer(self.extensions[1], np.uint8).reshape(-1, 2)
        (length,) = struct.unpack_from("<I", self.extensions[4])
        self.metadata = json.loads(self.extensions[4][4 : 4 + length])
        self.error = self.metadata["geometricerror"]

    def edge(self, side):
        """Where its vertices are, how high, and their normals."""
        i = self.edges[side]
        along = (self.v if side % 2 == 0 else self.u)[i]
        return [tuple(along), tuple(self.metres[i]), tuple(map(tuple, self.normals[i]))]

    def heights_at(self, lon, lat):
        """Of the places within; NaN where no triangle has one."""
        out = np.full(lon.shape, np.nan)
        px, py = (lon - self.west) / self.width * LARGEST, (lat - self.south) / self.width * LARGEST
        for a, b, c in self.triangles:
            (xa, xb, xc), (ya, yb, yc) = self.u[[a, b, c]], self.v[[a, b, c]]
            area = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
            if area <= 0:
                continue
            near = np.nonzero((px >= min(xa, xb, xc) - 1e-6) & (px <= max(xa, xb, xc) + 1e-6) &
                              (py >= min(ya, yb, yc) - 1e-6) & (py <= max(ya, yb, yc) + 1e-6))[0]
            wb = ((px[near] - xa) * (yc - ya) - (xc - xa) * (py[near] - ya)) / area
            wc = ((xb - xa) * (py[near] - ya) - (px[near] - xa) * (yb - ya)) / area
            inside = (wb > -1e-9) & (wc > -1e-9) & (wb + wc < 1 + 1e-9)
            out[near[inside]] = (self.metres[a] + wb * (self.metres[b] - self.metres[a]) +
                                 wc * (self.metres[c] - self.metres[a]))[inside]
        return out


class Export:
    def __init__(self, folder):
        self.layer = json.loads((folder / "layer.json").read_text())
        self.report = json.loads((folder / "export.json").read_text())
        self.tiles = {}
        for path in folder.glob("*/*/*.terrain"):
            level, x, y = int(path.parts[-3]), int(path.parts[-2]), int(path.stem)
            self.tiles[level, x, y] = Tile(path, level, x, y)


def bytes_of(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


class QuantizedMesh(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.fault, cls.earth = cls.folder / "fault.cairn", cls.folder / "earth.cairn"
        samples = REPOSITORY / "sample-dem"
        cairn("bake", samples / "jacksboro_fault.tif", "-o", cls.fault, "--datum", "ellipsoid")
        cairn("bake", samples / "etopo5_thinned.tif", "-o", cls.earth, "--datum", "ellipsoid")
        cairn("export", cls.fault, "-o", cls.folder / "fault", "--format", "quantized-mesh", "--threads", 1)
        cairn("export", cls.earth, "-o", cls.folder / "earth", "--format", "quantized-mesh")
        cls.exports = {name: Export(cls.folder / name) for name in ("fault", "earth")}

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def test_every_tile_is_whole(self):
        for export in self.exports.values():
            for t in export.tiles.values():
                with self.subTest(tile=(t.level, t.x, t.y)):
                    self.assertTrue(np.isfinite(t.header).all() and np.isfinite(t.metres).all())
                    self.assertLessEqual(t.error, ROOT_ERROR / 2**t.level)
                    self.assertEqual(len(t.normals), len(t.u))
                    self.assertLess(t.triangles.max(), len(t.u))
                    self.assertEqual({(u, v) for u, v in zip(t.u, t.v) if u in (0, LARGEST) and v in (0, LARGEST)},
                                     {(0, 0), (0, LARGEST), (LARGEST, 0), (LARGEST, LARGEST)})
                    for side, on in enumerate((t.u == 0, t.v == 0, t.u == LARGEST, t.v == LARGEST)):
                        self.assertEqual(set(t.edges[side]), set(np.nonzero(on)[0]))

    def test_layer_lists_the_tiles_that_there_are(self):
        for export in self.exports.values():
            stated = {(level, x, y) for level, ranges in enumerate(export.layer["available"]) for r in ranges
                      for x in range(r["startX"], r["endX"] + 1) for y in range(r["startY"], r["endY"] + 1)}
            self.assertEqual(stated, set(export.tiles))
            self.assertEqual(export.layer["maxzoom"], max(level for level, _, _ in export.tiles))
            for level, x, y in export.tiles:
                if level > 0:
                    self.assertIn((level - 1, x // 2, y // 2), export.tiles)
                    for q in range(4):
                        self.assertIn((level, x // 2 * 2 + q % 2, y // 2 * 2 + q // 2), export.tiles)
            self.assertIn((0, 0, 0), export.tiles)
            self.assertIn((0, 1, 0), export.tiles)
            # CesiumJS takes what there is from tiles of every so many levels.
            step, listed = export.layer["metadataAvailability"], {(0, 0, 0), (0, 1, 0)}
            for level, x, y in export.tiles:
                ranges = export.tiles[level, x, y].metadata.get("available")
                self.assertEqual(ranges is not None, level % step == 0 and (level + 1, 2 * x, 2 * y) in export.tiles)
                listed |= {(level + 1 + i, c, r) for i, here in enumerate(ranges or ()) for q in here
                           for c in range(q["startX"], q["endX"] + 1) for r in range(q["startY"], q["endY"] + 1)}
            self.assertEqual(listed, set(export.tiles))

    def test_neighbours_have_the_same_edges(self):
        for export in self.exports.values():
            pairs = 0
            for (level, x, y), t in export.tiles.items():
                for (dx, dy), mine, theirs in (((1, 0), 2, 0), ((0, 1), 3, 1)):
                    other = export.tiles.get((level, (x + dx) % 2 ** (level + 1), y + dy))
                    if other is None:
                        continue
                    pairs += 1
                    self.assertEqual(t.edge(mine), other.edge(theirs), (level, x, y))
            self.assertGreater(pairs, 100)

    def test_no_post_is_farther_off_than_stated(self):
        from osgeo import gdal
        for name, file in (("fault", "jacksboro_fault.tif"), ("earth", "etopo5_thinned.tif")):
            raster = gdal.Open(str(REPOSITORY / "sample-dem" / file))
            x0, dx, _, y0, _, dy = raster.GetGeoTransform()
            posts = raster.ReadAsArray().astype(float)
            lon = x0 + dx * (np.arange(posts.shape[1]) + 0.5)
            lat = y0 + dy * (np.arange(posts.shape[0]) + 0.5)
            measured = 0
            for t in self.exports[name].tiles.values():
                columns = np.nonzero((lon >= t.west) & (lon <= t.west + t.width))[0]
                rows = np.nonzero((lat >= t.south) & (lat <= t.south + t.width) & (abs(lat) < 89.99))[0]
                if len(columns) == 0 or len(rows) == 0:
                    continue
                at_lon, at_lat = np.meshgrid(lon[columns], lat[rows])
                at_lon, at_lat, truth = at_lon.ravel(), at_lat.ravel(), posts[np.ix_(rows, columns)].ravel()
                if len(truth) > 4000:  # evenly thinned: the decoder here is slow
                    keep = np.linspace(0, len(truth) - 1, 4000).astype(int)
                    at_lon, at_lat, truth = at_lon[keep], at_lat[keep], truth[keep]
                found = t.heights_at(at_lon, at_lat)
                self.assertFalse(np.isnan(found).any(), (name, t.level, t.x, t.y))
                off = np.abs(found - truth).max()
                self.assertLessEqual(off, t.error, (name, t.level, t.x, t.y))
                measured += len(truth)
            self.assertGreater(measured, 100000)

    def test_poles_have_no_flat_triangles(self):
        for t in self.exports["earth"].tiles.values():
            for pole, south in ((LARGEST, t.south + t.width == 90), (0, t.south == -90)):
                if south:
                    self.assertEqual(((t.v[t.triangles] == pole).sum(axis=1) >= 2).sum(), 0)

    def test_threads_and_interruptions_change_no_byte(self):
        other = self.folder / "two"
        cairn("export", self.fault, "-o", other, "--format", "quantized-mesh", "--threads", 2)
        whole = bytes_of(self.folder / "fault")
        self.assertEqual(whole, bytes_of(other))
        # The work of an export that was killed after some of its parts.
        part = self.folder / "again.part"
        cairn("export", self.fault, "-o", self.folder / "again", "--format", "quantized-mesh")
        (self.folder / "again").rename(part)
        cairn("export", self.fault, "-o", self.folder / "again", "--format", "quantized-mesh", "--resume", code=2)

    def test_max_error_is_kept_in_the_finest_tiles(self):
        out = self.folder / "close"
        cairn("export", self.fault, "-o", out, "--format", "quantized-mesh", "--max-error", 1, "--region",
              "-84.3,36.5,-84.2,36.6")
        export = Export(out)
        within = [t for t in export.tiles.values() if t.level == export.layer["maxzoom"] and t.west < -84.2 and
                  t.west + t.width > -84.3 and t.south < 36.6 and t.south + t.width > 36.5]
        self.assertGreater(len(within), 20)
        for t in within:
            self.assertLessEqual(t.error, 1, (t.level, t.x, t.y))

    def test_refusals(self):
        unknown = self.folder / "unknown.cairn"
        cairn("bake", REPOSITORY / "sample-dem/jacksboro_fault.tif", "-o", unknown)
        formats = ("--format", "quantized-mesh")
        for arguments, code, says in (
                ((unknown, "-o", self.folder / "x", *formats), 2, "--datum"),
                ((self.fault, "-o", self.fault, *formats), 2, "found one"),
                ((self.fault, "-o", self.folder / "fault", *formats), 2, "found one"),
                ((self.fault, "-o", self.folder / "no/where", *formats), 1, "found none"),
                ((self.fault, "-o", self.folder / "x", *formats, "--datum", "egm96"), 2, "vertical datum"),
                ((self.fault, "-o", self.folder / "x", *formats, "--max-error", 0.01), 2, "largest error"),
                ((self.fault, "-o", self.folder / "x", *formats, "--levels", "3-8"), 2, "levels"),
                ((self.fault, "-o", self.folder / "x", *formats, "--region", "10,10,11,11"), 1, "region"),
                ((self.fault, "-o", self.folder / "x", "--format", "shapefile"), 2, "format"),
                ((REPOSITORY / "README.md", "-o", self.folder / "x", *formats), 3, "README.md")):
            with self.subTest(arguments=arguments):
                ran = cairn("export", *arguments, code=code)
                self.assertIn(says, ran.stderr)
                self.assertEqual(len(ran.stderr.strip().splitlines()), 1)
                self.assertFalse((self.folder / "x").exists())
                self.assertFalse((self.folder / "x.part").exists())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
