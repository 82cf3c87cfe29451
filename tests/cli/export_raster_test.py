#!/usr/bin/python3
"""Bakes a pack, exports it as PMTiles, GeoTIFF and heightmaps, and reads these with decoders of its own or GDAL.

usage: tests/cli/export_raster_test.py REPOSITORY PROGRAMS"""

import gzip
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

import numpy as np

REPOSITORY, PROGRAMS = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
REGION = "-84.35,36.5,-84.15,36.7"


def cairn(*arguments, code=0, stdin=None):
    ran = subprocess.run([PROGRAMS / "cairn", *map(str, arguments)], capture_output=True, text=True, input=stdin)
    assert ran.returncode == code, f"cairn {arguments}: {ran.returncode}\n{ran.stdout}\n{ran.stderr}"
    return ran


def sample(pack, lon, lat):
    """The pack's heights, as `cairn sample` prints them."""
    points = "".join(f"{x:.17g},{y:.17g}\n" for x, y in zip(lon, lat))
    out = cairn("sample", pack, "--points", "-", stdin="lon,lat\n" + points).stdout.splitlines()
    column = out[0].split(",").index("height")
    return np.array([float(line.split(",")[column]) for line in out[1:]])


def varints(data):
    values, at = [], 0
    while at < len(data):
        value, shift = 0, 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                break
        values.append(value)
    return values


def hilbert(number):
    """Zoom, x and y of a tile's number, after the PMTiles specification."""
    zoom = 0
    while number >= 4**zoom:
        number -= 4**zoom
        zoom += 1
    x = y = 0
    t, s = number, 1
    while s < 2**zoom:
        rx, ry = 1 & (t // 2), 1 & (t ^ (1 & (t // 2)))
        if ry == 0:
            if rx == 1:
                x, y = s - 1 - x, s - 1 - y
            x, y = y, x
        x, y, t, s = x + s * rx, y + s * ry, t // 4, 2 * s
    return zoom, x, y


class Archive:
    def __init__(self, path):
        self.data = path.read_bytes()
        assert self.data[:8] == b"PMTiles\x03"
        (self.root, self.root_bytes, metadata, metadata_bytes, self.leaves, self.leaf_bytes, self.start, _, self.addressed,
         self.entries, self.contents) = struct.unpack_from("<11Q", self.data, 8)
        self.internal, self.compression, self.type, self.min_zoom, self.max_zoom = self.data[97:102]
        self.bounds = [v / 1e7 for v in struct.unpack_from("<4i", self.data, 102)]
        self.metadata = json.loads(gzip.decompress(self.data[metadata : metadata + metadata_bytes]))
        self.tiles = dict(self.walk(self.root, self.root_bytes))

    def walk(self, at, size):
        values = varints(gzip.decompress(self.data[at : at + size]))
        n, values = values[0], values[1:]
        ids = np.cumsum(values[:n])
        runs, lengths, offsets = values[n : 2 * n], values[2 * n : 3 * n], values[3 * n :]
        before = 0
        for number, run, length, offset in zip(ids, runs, lengths, offsets):
            start = before if offset == 0 else offset - 1
            before = start + length
            if run == 0:
                yield from self.walk(self.leaves + start, length)
            for k in range(run):
                yield hilbert(int(number) + k), self.data[self.start + start : self.start + start + length]


def png_rgb(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack_from(">IIBB", body)
            assert (depth, colour) == (8, 2)
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 3 * width)
    out = np.zeros((height, 3 * width), np.uint8)
    for row in range(height):  # the five filters of PNG
        kind, line = raw[row, 0], raw[row, 1:].astype(np.int64)
        above = out[row - 1].astype(np.int64) if row else np.zeros(3 * width, np.int64)
        if kind == 0:
            out[row] = line
        elif kind == 2:
            out[row] = (line + above) % 256
        else:
            now = np.zeros(3 * width + 3, np.int64)
            up = np.concatenate([np.zeros(3, np.int64), above])
            for i in range(3 * width):
                a, b, c = now[i], up[i + 3], up[i]
                if kind == 1:
                    guess = a
                elif kind == 3:
                    guess = (a + b) // 2
                else:
                    pa, pb, pc = abs(b - c), abs(a - c), abs(a + b - 2 * c)
                    guess = a if pa <= pb and pa <= pc else b if pb <= pc else c
                now[i + 3] = (line[i] + guess) % 256
            out[row] = now[3:]
    return out.reshape(height, width, 3)


class Rasters(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.pack = cls.folder / "fault.cairn"
        cairn("bake", REPOSITORY / "sample-dem/jacksboro_fault.tif", "-o", cls.pack)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def test_pmtiles_read_as_maplibre_reads_them(self):
        out = self.folder / "a.pmtiles"
        report = json.loads(cairn("export", self.pack, "-o", out, "--format", "pmtiles", "--json").stdout)
        again = self.folder / "b.pmtiles"
        cairn("export", self.pack, "-o", again, "--format", "pmtiles", "--threads", 1)
        self.assertEqual(out.read_bytes(), again.read_bytes())
        archive = Archive(out)
        self.assertEqual((archive.type, archive.compression), (2, 1))
        self.assertEqual(archive.addressed, len(archive.tiles))
        self.assertEqual(archive.min_zoom, min(z for z, _, _ in archive.tiles))
        self.assertEqual(archive.max_zoom, max(z for z, _, _ in archive.tiles))
        self.assertLess(archive.bounds[0], archive.bounds[2])
        md = archive.metadata
        self.assertEqual(md["encoding"], "terrarium")  # the pack's quantum of 0.6 m is coarser than 1/256 m
        errors = {level["level"]: level["max_error_m"] for level in report["levels"]}
        # MapLibre's reading: pixel i is at (i + 1/2)/512 of the tile's width.
        zoom = archive.max_zoom
        generator = np.random.default_rng(7)
        lon = generator.uniform(-84.35, -84.15, 400)
        lat = generator.uniform(36.5, 36.7, 400)
        truth = sample(self.pack, lon, lat)
        x = (lon + 180) / 360 * 2**zoom
        y = (1 - np.arcsinh(np.tan(np.radians(lat))) / math.pi) / 2 * 2**zoom
        decoded, worst, read = {}, 0, 0
        for px, py, height in zip(x, y, truth):
            key = (zoom, int(px), int(py))
            u, v = (px - int(px)) * 512 - 0.5, (py - int(py)) * 512 - 0.5
            if not (0 <= u < 511 and 0 <= v < 511):  # its neighbour would be read too
                continue
            if key not in decoded:
                rgb = png_rgb(archive.tiles[key]).astype(float)
                decoded[key] = (rgb @ [256, 1, 1 / 256]) - 32768
            m, c, r = decoded[key], int(u), int(v)
            u, v = u - c, v - r
            found = (m[r, c] * (1 - u) + m[r, c + 1] * u) * (1 - v) + (m[r + 1, c] * (1 - u) + m[r + 1, c + 1] * u) * v
            worst, read = max(worst, abs(found - height)), read + 1
        self.assertGreater(read, 300)
        self.assertLessEqual(worst, errors[zoom] + 0.5)
        for tile in decoded.values():
            self.assertGreater(tile.min(), -500)

    def test_imagery_as_webp_shows_the_packs_colours(self):
        from osgeo import gdal, osr
        west, south, east, north, size = -84.3, 36.55, -84.2, 36.63, 700
        picture = self.folder / "colours.tif"
        raster = gdal.GetDriverByName("GTiff").Create(str(picture), size, size, 3)
        raster.SetGeoTransform((west, (east - west) / size, 0, north, 0, (south - north) / size))
        degrees = osr.SpatialReference()
        degrees.ImportFromEPSG(4326)
        raster.SetProjection(degrees.ExportToWkt())
        along = np.linspace(0, 255, size)
        for band, values in enumerate((np.tile(along, (size, 1)), np.tile(along[::-1, None], (1, size)), np.full((size, size), 80))):
            raster.GetRasterBand(band + 1).WriteArray(values.astype(np.uint8))
        raster = None
        pack, out, again = (self.folder / name for name in ("colours.cairn", "i.pmtiles", "j.pmtiles"))
        cairn("bake", REPOSITORY / "sample-dem/jacksboro_fault.tif", "--imagery", picture, "-o", pack)
        report = json.loads(cairn("export", pack, "-o", out, "--format", "pmtiles-imagery", "--json").stdout)
        cairn("export", pack, "-o", again, "--format", "pmtiles-imagery", "--threads", 1)
        self.assertEqual(out.read_bytes(), again.read_bytes())
        archive = Archive(out)
        self.assertEqual(archive.type, 4)
        self.assertEqual({z for z, _, _ in archive.tiles}, set(range(archive.min_zoom, archive.max_zoom + 1)))
        for a, b in zip(archive.bounds, (west, south, east, north)):
            self.assertAlmostEqual(a, b, places=3)
        self.assertEqual(sum(level["tiles"] for level in report["levels"]), len(archive.tiles))
        worst = 0
        for (zoom, x, y), data in archive.tiles.items():
            if zoom < archive.max_zoom - 1:
                continue
            gdal.FileFromMemBuffer("/vsimem/tile.webp", data)
            colours = gdal.Open("/vsimem/tile.webp").ReadAsArray().astype(float)
            self.assertEqual(colours.shape[1:], (512, 512))
            u, v = np.meshgrid((np.arange(512) + 0.5) / 512, (np.arange(512) + 0.5) / 512)
            lon = (x + u) / 2**zoom * 360 - 180
            lat = np.degrees(np.arctan(np.sinh(np.pi * (1 - 2 * (y + v) / 2**zoom))))
            inside = (lon > west + 0.002) & (lon < east - 0.002) & (lat > south + 0.002) & (lat < north - 0.002)
            outside = (lon < west - 0.002) | (lon > east + 0.002) | (lat < south - 0.002) | (lat > north + 0.002)
            if colours.shape[0] == 4:
                self.assertTrue((colours[3][inside] == 255).all())
                self.assertTrue((colours[3][outside] == 0).all())
            for band, expected in ((0, 255 * (lon - west) / (east - west)), (1, 255 * (lat - south) / (north - south))):
                if inside.any():
                    worst = max(worst, np.abs(colours[band] - expected)[inside].max())
        self.assertGreater(worst, 0)
        self.assertLess(worst, 20)
        cairn("export", self.pack, "-o", self.folder / "none.pmtiles", "--format", "pmtiles-imagery", code=3)
        for arguments, code in ((("--max-error", 1), 2), (("--region", "10,10,11,11"), 1), (("--levels", "30-31"), 2)):
            target = self.folder / "refused.pmtiles"
            cairn("export", pack, "-o", target, "--format", "pmtiles-imagery", *arguments, code=code)
            self.assertFalse(target.exists() or target.with_name(target.name + ".part").exists())

    def test_geotiff_has_the_packs_samples(self):
        from osgeo import gdal
        out = self.folder / "a.tif"
        cairn("export", self.pack, "-o", out, "--format", "geotiff", "--region", "-84.41,36.45,-84.08,36.73")
        raster = gdal.Open(str(out))
        self.assertEqual(raster.GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG")
        self.assertEqual(raster.GetMetadataItem("AREA_OR_POINT"), "Point")
        x0, dx, _, y0, _, dy = raster.GetGeoTransform()
        heights = raster.ReadAsArray()
        columns = np.arange(0, heights.shape[1], 97)
        rows = np.arange(0, heights.shape[0], 89)
        c, r = (a.ravel() for a in np.meshgrid(columns, rows))
        lon, lat = x0 + dx * (c + 0.5), y0 + dy * (r + 0.5)
        self.assertTrue(np.array_equal(heights[r, c], sample(self.pack, lon, lat).astype(np.float32)))
        self.assertGreater(raster.GetRasterBand(1).GetOverviewCount(), 0)
        raster = None
        from osgeo_utils.samples import validate_cloud_optimized_geotiff as cog
        warnings, errors, _ = cog.validate(str(out), full_check=True)
        self.assertEqual((warnings, errors), ([], []))
        import rasterio
        with rasterio.open(out) as again:
            self.assertEqual((again.crs.to_epsg(), again.nodata, again.dtypes), (4326, -32768, ("float32",)))
            self.assertTrue(np.array_equal(again.read(1), heights))
            picked = [p[0] for p in again.sample(zip(lon[:50], lat[:50]))]
            self.assertTrue(np.array_equal(picked, heights[r[:50], c[:50]]))

    def test_heightmaps_share_rows_and_keep_the_stated_error(self):
        out = self.folder / "engine"
        cairn("export", self.pack, "-o", out, "--format", "r16", "--region", REGION, "--posts", 129)
        side = json.loads((out / "heightmap.json").read_text())
        posts, across, down = side["posts_a_side"], side["columns_of_files"], side["rows_of_files"]
        files = {(x, y): np.fromfile(out / f"fault_x{x}_y{y}.r16", "<u2").reshape(posts, posts)
                 for x in range(across) for y in range(down)}
        self.assertEqual(len(files) + 1, len(list(out.iterdir())))
        self.assertGreater(len(files), 1)
        for (x, y), heights in files.items():
            if (x + 1, y) in files:
                self.assertTrue(np.array_equal(heights[:, -1], files[x + 1, y][:, 0]))
            if (x, y + 1) in files:
                self.assertTrue(np.array_equal(heights[-1], files[x, y + 1][0]))
        # In the middle of the region, where the plane's axes are east and north.
        metres = side["lowest_m"] + side["metres_a_step"] * files[0, 0].astype(float)
        self.assertGreaterEqual(metres.min(), side["lowest_m"])
        self.assertLessEqual(metres.max(), side["highest_m"] + 1e-6)
        column = -side["first_post_m"]["east"] / side["metres_a_post"]
        row = side["first_post_m"]["north"] / side["metres_a_post"]
        x, y = int(column // (posts - 1)), int(row // (posts - 1))
        c, r = column - x * (posts - 1), row - y * (posts - 1)
        m = side["lowest_m"] + side["metres_a_step"] * files[x, y].astype(float)
        i, j, u, v = int(c), int(r), c % 1, r % 1
        found = (m[j, i] * (1 - u) + m[j, i + 1] * u) * (1 - v) + (m[j + 1, i] * (1 - u) + m[j + 1, i + 1] * u) * v
        truth = sample(self.pack, [side["centre"]["lon"]], [side["centre"]["lat"]])[0]
        self.assertLessEqual(abs(found - truth), side["max_error_m"])
        for size, code in ((1009, 0), (1, 2)):
            cairn("export", self.pack, "-o", self.folder / f"s{size}", "--format", "r16", "--posts", size, code=code)

    def test_refusals(self):
        for name in ("pmtiles", "geotiff", "r16"):
            for arguments, code in ((("--region", "10,10,11,11"), 1), (("--datum", "nowhere"), 2),
                                    (("--heights", "ellipsoidal"), 2)):
                if name == "pmtiles" and arguments[0] == "--region":
                    continue  # coarse tiles that touch the region are written, whatever lies in it
                with self.subTest(name=name, arguments=arguments):
                    target = self.folder / f"refused-{name}"
                    ran = cairn("export", self.pack, "-o", target, "--format", name, *arguments, code=code)
                    self.assertEqual(len(ran.stderr.strip().splitlines()), 1)
                    self.assertFalse(target.exists())
            target = self.folder / "exists"
            target.write_text("mine")
            cairn("export", self.pack, "-o", target, "--format", name, code=2)
            self.assertEqual(target.read_text(), "mine")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
