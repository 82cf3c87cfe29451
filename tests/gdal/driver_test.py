#!/usr/bin/env python3
"""Reads packs through the GDAL driver and compares every value with what the program `cairn` gives.

usage: tests/gdal/driver_test.py PROGRAMS PLUGINS
Prints SKIPPED where GDAL's Python bindings are absent."""

import csv
import http.server
import io
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import unittest
import zipfile

PROGRAMS, PLUGINS = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
os.environ["GDAL_DRIVER_PATH"] = str(PLUGINS)

try:
    import numpy as np
    from osgeo import gdal, osr
except ImportError as error:
    print(f"SKIPPED: {error}")
    sys.exit(0)

NODATA = -32768
SIDE = 300  # posts of the made DEM along a side, 3 seconds apart


def cairn(*arguments, **options):
    done = subprocess.run([PROGRAMS / "cairn", *map(str, arguments)], capture_output=True, text=True, **options)
    if done.returncode:
        raise AssertionError(f"cairn {arguments}: {done.stderr}")
    return done.stdout


def write_raster(path, bands, west, north, step, nodata=None):
    kind = gdal.GDT_Byte if bands.dtype == np.uint8 else gdal.GDT_Float32
    raster = gdal.GetDriverByName("GTiff").Create(str(path), bands.shape[2], bands.shape[1], bands.shape[0], kind)
    raster.SetGeoTransform([west, step, 0, north, 0, -step])
    crs = osr.SpatialReference()
    crs.ImportFromEPSG(4326)
    raster.SetProjection(crs.ExportToWkt())
    for i, band in enumerate(bands):
        raster.GetRasterBand(i + 1).WriteArray(band)
        if nodata is not None:
            raster.GetRasterBand(i + 1).SetNoDataValue(nodata)


def hills():
    """Hills in the east, a plain in the west, which is left out at the finest levels, and a hole."""
    y, x = np.mgrid[0:SIDE, 0:SIDE]
    metres = np.where(x > 2 * SIDE // 3, 900 + 150 * np.sin(x / 7.0) * np.cos(y / 9.0), 900).astype(np.float32)
    metres[40:60, 240:270] = -9999
    return metres


def sampled(pack, lon, lat, level=None):
    """What `cairn sample` prints at the places: heights, NaN where there is none."""
    table = "lon,lat\n" + "\n".join(f"{x!r},{y!r}" for x, y in zip(lon.ravel().tolist(), lat.ravel().tolist()))
    options = [] if level is None else ["--level", level]
    rows = csv.DictReader(io.StringIO(cairn("sample", pack, "--points", "-", *options, input=table + "\n")))
    heights = [float(row["height"]) if row["height"] else np.nan for row in rows]
    return np.array(heights).reshape(lon.shape)


def centres(dataset):
    west, step_x, _, north, _, step_y = dataset.GetGeoTransform()
    columns, rows = np.arange(dataset.RasterXSize) + 0.5, np.arange(dataset.RasterYSize) + 0.5
    return np.meshgrid(west + columns * step_x, north + rows * step_y)


def heights_of(band):
    metres = band.ReadAsArray().astype(np.float64)
    metres[metres == NODATA] = np.nan
    return metres


class RangeHandler(http.server.BaseHTTPRequestHandler):
    """Sends ranges of the files of a folder, as web servers do."""
    protocol_version = "HTTP/1.1"
    folder = None

    def do_HEAD(self):
        self.send(False)

    def do_GET(self):
        self.send(True)

    def send(self, with_body):
        file = self.folder / self.path.lstrip("/")
        if not file.is_file():
            self.send_response(404)
            self.send_header("Content-Length", "0")
            self.end_headers()
            return
        data = file.read_bytes()
        found = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range", ""))
        first, last = (int(found[1]), int(found[2] or len(data) - 1)) if found else (0, len(data) - 1)
        part = data[first : last + 1]
        self.send_response(206 if found else 200)
        if found:
            self.send_header("Content-Range", f"bytes {first}-{first + len(part) - 1}/{len(data)}")
        self.send_header("Accept-Ranges", "bytes")
        self.send_header("Content-Length", str(len(part)))
        self.end_headers()
        if with_body:
            self.wfile.write(part)

    def log_message(self, *arguments):
        pass


class Driver(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        gdal.UseExceptions()
        cls.folder = tempfile.TemporaryDirectory()
        cls.dir = pathlib.Path(cls.folder.name)
        write_raster(cls.dir / "hills.tif", hills()[None], 8.1, 46.9, 1 / 1200, -9999)
        y, x = np.mgrid[0:500, 0:700]
        colours = np.stack([x * 255 // 700, y * 255 // 500, (x + y) % 256]).astype(np.uint8)
        write_raster(cls.dir / "image.tif", colours, 8.12, 46.88, 1 / 6000)
        cls.pack = cls.dir / "both.cairn"
        cairn("bake", cls.dir / "hills.tif", "--imagery", cls.dir / "image.tif", "-o", cls.pack, "--void", "keep",
              "--datum", "egm96", "--tile-size", 257, "--level", 4)
        cls.info = json.loads(cairn("info", cls.pack, "--json"))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def assert_equals_sample(self, found, expected):
        np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
        # The program prints four decimals, the band is the nearest float.
        limit = 0.5e-4 + np.abs(expected[~np.isnan(expected)]) * 2.0**-24
        self.assertTrue(np.all(np.abs(found - expected)[~np.isnan(expected)] <= limit + 1e-9))

    def test_every_height_is_what_sample_prints(self):
        tiles = {level["level"]: level["tiles"] for level in self.info["levels"]}
        self.assertLess(tiles[4], 4 * tiles[3], "expected tiles that were left out")
        dataset = gdal.Open(str(self.pack))
        lon, lat = centres(dataset)
        found = heights_of(dataset.GetRasterBand(1))
        self.assertGreater(np.isnan(found).sum(), 100)
        self.assert_equals_sample(found, sampled(self.pack, lon, lat))

    def test_gdal_translate_gives_every_height(self):
        subprocess.run(["gdal_translate", "-q", self.pack, self.dir / "out.tif"], check=True)
        out, dataset = gdal.Open(str(self.dir / "out.tif")), gdal.Open(str(self.pack))
        np.testing.assert_array_equal(out.ReadAsArray(), dataset.ReadAsArray())
        self.assertEqual(out.GetGeoTransform(), dataset.GetGeoTransform())
        self.assertEqual(out.GetRasterBand(1).GetNoDataValue(), NODATA)

    def test_samples_are_pixel_centres_and_cover_the_sources(self):
        dataset = gdal.Open(str(self.pack))
        west, step, _, north, _, _ = dataset.GetGeoTransform()
        self.assertEqual(step, 1 / (256 * 16))
        self.assertEqual((west + step / 2) / step, round((west + step / 2) / step))
        bounds = self.info["bounds"]
        self.assertLessEqual(west + step / 2, bounds["west"])
        self.assertGreaterEqual(north - step / 2, bounds["north"])
        self.assertGreaterEqual(west + (dataset.RasterXSize - 0.5) * step, bounds["east"])
        self.assertLessEqual(north - (dataset.RasterYSize - 0.5) * step, bounds["south"])

    def test_an_overview_is_its_level_at_the_centres_of_its_pixels(self):
        dataset = gdal.Open(str(self.pack))
        band = dataset.GetRasterBand(1)
        self.assertGreater(band.GetOverviewCount(), 0)
        west, step, _, north, _, _ = dataset.GetGeoTransform()
        for i in range(band.GetOverviewCount()):
            overview = band.GetOverview(i)
            columns = (np.arange(overview.XSize) + 0.5) * step * dataset.RasterXSize / overview.XSize
            rows = (np.arange(overview.YSize) + 0.5) * step * dataset.RasterYSize / overview.YSize
            lon, lat = np.meshgrid(west + columns, north - rows)
            expected = sampled(self.pack, lon, lat, 4 - 1 - i)
            found = heights_of(overview)
            there = ~np.isnan(expected)  # --level asks that level only, the band coarser ones as well
            self.assertGreater(there.sum(), 1000)
            self.assertTrue(np.all(np.abs(found - expected)[there] <= 2e-4))

    def test_a_level_that_is_named_has_its_own_grid(self):
        dataset = gdal.Open(f'CAIRN:"{self.pack}":heights:2')
        self.assertEqual(dataset.GetGeoTransform()[1], 1 / (256 * 4))
        lon, lat = centres(dataset)
        found, expected = heights_of(dataset.GetRasterBand(1)), sampled(self.pack, lon, lat, 2)
        there = ~np.isnan(expected)  # --level asks that level only, the band coarser ones as well
        self.assertGreater(there.sum(), 1000)
        self.assert_equals_sample(found[there], expected[there])

    def test_crs_follows_the_datum(self):
        self.assertIn("EGM96", gdal.Open(str(self.pack)).GetSpatialRef().ExportToWkt())
        self.assertTrue(gdal.Open(str(self.pack)).GetSpatialRef().IsCompound())
        for datum, code in (("unknown", "4326"), ("ellipsoid", "4979")):
            pack = self.dir / f"{datum}.cairn"
            cairn("bake", self.dir / "hills.tif", "-o", pack, "--datum", datum, "--level", 1, "--allow-error")
            self.assertEqual(gdal.Open(str(pack)).GetSpatialRef().GetAuthorityCode(None), code)

    def test_metadata_states_the_bound_and_what_was_measured(self):
        dataset = gdal.Open(str(self.pack))
        items = dataset.GetMetadata()
        self.assertEqual(float(items["CAIRN_ERROR_BOUND_M"]), self.info["error_bound_m"])
        self.assertAlmostEqual(float(items["CAIRN_POST_ERROR_MAX_M"]), self.info["accuracy"]["max_m"], 6)
        self.assertAlmostEqual(float(items["CAIRN_LEVEL_4_MAX_ERROR_M"]), self.info["levels"][-1]["max_error_m"], 6)
        self.assertEqual(items["AREA_OR_POINT"], "Point")
        whole = json.loads(dataset.GetMetadata_List("json:cairn")[0])
        self.assertEqual(whole["accuracy"]["posts"], self.info["accuracy"]["posts"])

    def test_subdatasets_are_the_layers(self):
        names = gdal.Open(str(self.pack)).GetSubDatasets()
        self.assertEqual([name for name, _ in names], [f'CAIRN:"{self.pack}":heights', f'CAIRN:"{self.pack}":imagery'])
        for name, _ in names:
            gdal.Open(name)

    def test_imagery_is_the_texels_of_the_tiles(self):
        dataset = gdal.Open(f"CAIRN:{self.pack}:imagery")
        self.assertEqual([dataset.GetRasterBand(i).GetColorInterpretation() for i in range(1, 5)],
                         [gdal.GCI_RedBand, gdal.GCI_GreenBand, gdal.GCI_BlueBand, gdal.GCI_AlphaBand])
        west, step, _, north, _, _ = dataset.GetGeoTransform()
        datasets = [(self.info["imagery"]["levels"][-1]["level"], dataset.ReadAsArray(), step)]
        for i in range(dataset.GetRasterBand(1).GetOverviewCount()):
            overview = np.stack([dataset.GetRasterBand(b).GetOverview(i).ReadAsArray() for b in range(1, 5)])
            datasets.append((datasets[0][0] - 1 - i, overview, step * 2 ** (i + 1)))
        self.assertGreater(len(datasets), 1)
        for level, texels, size in datasets:
            x, y = int((8.14 + 180) * 2**level), int((46.85 + 90) * 2**level)
            cairn("extract", self.pack, f"{level}/{x}/{y}", "--layer", "imagery", "-o", self.dir / "tile.png")
            tile = gdal.Open(str(self.dir / "tile.png")).ReadAsArray()
            left = round((x / 2**level - 180 - west) / size)
            top = round((north - ((y + 1) / 2**level - 90)) / size)
            rows = slice(max(0, top), min(texels.shape[1], top + 256))
            columns = slice(max(0, left), min(texels.shape[2], left + 256))
            self.assertGreater((rows.stop - rows.start) * (columns.stop - columns.start), 0)
            np.testing.assert_array_equal(texels[:, rows, columns],
                                          tile[:, rows.start - top : rows.stop - top,
                                               columns.start - left : columns.stop - left])

    def test_across_the_antimeridian(self):
        write_raster(self.dir / "pacific.tif", hills()[None], 179.9, 10.1, 1 / 1200, -9999)
        pack = self.dir / "pacific.cairn"
        cairn("bake", self.dir / "pacific.tif", "-o", pack, "--level", 2, "--allow-error")
        dataset = gdal.Open(str(pack))
        lon, lat = centres(dataset)
        self.assertGreater(lon.max(), 180)
        self.assert_equals_sample(heights_of(dataset.GetRasterBand(1)), sampled(pack, lon, lat))

    def test_gdalwarp_and_statistics(self):
        subprocess.run(["gdalwarp", "-q", "-t_srs", "EPSG:32632+5773", self.pack, self.dir / "utm.tif"], check=True)
        utm = gdal.Open(str(self.dir / "utm.tif"))  # which its bands do not keep open
        metres = heights_of(utm.GetRasterBand(1))
        self.assertTrue(740 < np.nanmin(metres) <= np.nanmax(metres) < 1060)

    def test_rasterio_masks_voids(self):
        try:
            import rasterio
        except ImportError as error:
            self.skipTest(str(error))
        with rasterio.open(self.pack) as dataset:
            metres = dataset.read(1, masked=True)
            self.assertEqual(dataset.units, ("m",))
            self.assertTrue(metres.mask.any() and not metres.mask.all())
            self.assertEqual(len(dataset.subdatasets), 2)
            value = next(dataset.sample([(8.2, 46.8)]))[0]
        self.assertAlmostEqual(float(value), float(cairn("sample", self.pack, "8.2", "46.8")), delta=0.5)

    def test_packs_of_gdals_own_file_systems(self):
        expected = gdal.Open(str(self.pack)).ReadAsArray()
        with zipfile.ZipFile(self.dir / "packs.zip", "w") as archive:
            archive.write(self.pack, "both.cairn")
        handler = type("Handler", (RangeHandler,), {"folder": self.dir})
        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            web = f"/vsicurl/http://127.0.0.1:{server.server_port}"
            for name in (f"/vsizip/{self.dir}/packs.zip/both.cairn", f"{web}/both.cairn",
                         f'CAIRN:"{web}/both.cairn":heights'):
                np.testing.assert_array_equal(gdal.Open(name).ReadAsArray(), expected)
            with self.assertRaises(RuntimeError):
                gdal.Open(f'CAIRN:"{web}/none.cairn":heights')
            server.shutdown()

    def test_what_cannot_be_opened_says_why(self):
        cairn("bake", self.dir / "hills.tif", "-o", self.dir / "heights.cairn", "--level", 1, "--allow-error")
        (self.dir / "short.cairn").write_bytes(self.pack.read_bytes()[:5000])
        for name, words in ((f"CAIRN:{self.dir}/heights.cairn:imagery", "the pack has none"),
                            (f"CAIRN:{self.pack}:heights:9", "expected a level"), (f"CAIRN:{self.pack}", "expected"),
                            (f"CAIRN:{self.pack}:colours", "expected"), (str(self.dir / "short.cairn"), "expected"),
                            (f"CAIRN:{self.dir}/none.cairn:heights", "No such file")):
            with self.assertRaisesRegex(RuntimeError, words):
                gdal.Open(name)
        with self.assertRaises(RuntimeError):
            gdal.Open(str(self.pack), gdal.GA_Update)

    def test_a_damaged_tile_is_an_error_and_no_height(self):
        data = bytearray(self.pack.read_bytes())
        for at in range(len(data) // 10, len(data) * 8 // 10, 97):
            data[at] ^= 1
        damaged = self.dir / "damaged.cairn"
        damaged.write_bytes(data)
        with self.assertRaises(RuntimeError):
            gdal.Open(str(damaged)).ReadAsArray()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
