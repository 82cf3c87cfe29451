#!/usr/bin/env python3
"""Tests the Python module against the program `cairn`.

usage: tests/python/module_test.py PROGRAMS PACKAGES
PACKAGES is the folder with the package cairn."""

import csv
import gc
import io
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings

PROGRAMS, PACKAGES = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(PACKAGES))

import numpy as np  # noqa: E402

import cairn  # noqa: E402

DEM = ROOT / "sample-dem" / "jacksboro_fault.tif"


def run(*arguments, **options):
    done = subprocess.run([PROGRAMS / "cairn", *map(str, arguments)], capture_output=True, text=True, **options)
    if done.returncode:
        raise AssertionError(f"cairn {arguments}: {done.stderr}")
    return done.stdout


def write_image(path):
    """A georeferenced image of 400 x 300 pixels, by GDAL."""
    from osgeo import gdal, osr
    gdal.UseExceptions()
    y, x = np.mgrid[0:300, 0:400]
    raster = gdal.GetDriverByName("GTiff").Create(str(path), 400, 300, 3, gdal.GDT_Byte)
    raster.SetGeoTransform([-84.40, 1 / 2400, 0, 36.70, 0, -1 / 2400])
    crs = osr.SpatialReference()
    crs.ImportFromEPSG(4326)
    raster.SetProjection(crs.ExportToWkt())
    for i, band in enumerate((x * 255 // 400, y * 255 // 300, (x + y) % 256)):
        raster.GetRasterBand(i + 1).WriteArray(band.astype(np.uint8))


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.dir = pathlib.Path(cls.folder.name)
        cls.path = cls.dir / "sample.cairn"
        images = []
        try:
            write_image(cls.dir / "image.tif")
            images = [cls.dir / "image.tif"]
        except ImportError:
            pass
        cls.has_imagery = bool(images)
        cls.report = cairn.bake(DEM, cls.path, imagery=images, datum="egm96", threads=1)
        cls.pack = cairn.open(cls.path)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def places(self, count=2000):
        random = np.random.default_rng(7)
        return random.uniform(-84.5, -84.0, count), random.uniform(36.4, 36.8, count)

    def test_bake_makes_the_bytes_of_the_program(self):
        images = ["--imagery", self.dir / "image.tif"] if self.has_imagery else []
        run("bake", DEM, *images, "-o", self.dir / "program.cairn", "--datum", "egm96", "--threads", 2)
        self.assertEqual(self.path.read_bytes(), (self.dir / "program.cairn").read_bytes())
        self.assertEqual(self.report["file_bytes"], self.path.stat().st_size)
        self.assertTrue(self.report["within_error_bound"])
        self.assertEqual(self.report["metadata"], self.pack.info)

    def test_facts_are_those_of_info(self):
        info = json.loads(run("info", self.path, "--json"))
        self.assertEqual(self.pack.tile_size, info["tile_size"])
        self.assertEqual(self.pack.quantum_m, info["quantum_m"])
        self.assertEqual(self.pack.vertical_datum, "egm96")
        self.assertEqual(self.pack.levels, (info["levels"][0]["level"], info["levels"][-1]["level"]))
        self.assertEqual(self.pack.info["accuracy"]["max_m"], info["accuracy"]["max_m"])
        self.assertEqual(pathlib.Path(self.pack.path), self.path)
        self.assertIn("sample.cairn", repr(self.pack))

    def test_heights_are_those_of_sample_in_any_order(self):
        lon, lat = self.places()
        table = "lon,lat\n" + "".join(f"{x!r},{y!r}\n" for x, y in zip(lon.tolist(), lat.tolist()))
        rows = list(csv.DictReader(io.StringIO(run("sample", self.path, "--points", "-", input=table))))
        found = self.pack.heights(lon, lat)
        there = np.array([row["height"] != "" for row in rows])
        self.assertTrue(there.any() and not there.all())
        np.testing.assert_array_equal(~np.isnan(found.metres), there)
        expected = [float(row["height"]) for row in rows if row["height"]]
        np.testing.assert_allclose(found.metres[there], expected, rtol=0, atol=0.51e-4)
        np.testing.assert_array_equal(found.level[there], [int(row["level"]) for row in rows if row["height"]])
        np.testing.assert_array_equal(found.level[~there], -128)
        np.testing.assert_array_equal(np.isnan(found.error_m), ~there)
        bound = self.pack.info["levels"][-1]["max_error_m"]
        self.assertTrue(np.all(found.error_m[there & (found.level == self.pack.levels[1])] <= np.float32(bound)))

    def test_heights_broadcast_and_take_one_level(self):
        lon = np.linspace(-84.3, -84.2, 5)
        grid = self.pack.heights(lon, np.linspace(36.5, 36.6, 4)[:, None])
        self.assertEqual(grid.metres.shape, (4, 5))
        self.assertEqual(self.pack.heights(-84.3, 36.5).metres.shape, ())
        self.assertAlmostEqual(float(self.pack.heights(-84.3 + 360, 36.5).metres),
                               float(self.pack.heights(-84.3, 36.5).metres), 6)
        self.assertEqual(self.pack.heights([], []).metres.shape, (0,))
        self.assertTrue(np.all(self.pack.heights(lon, 36.5, level=0).level == 0))

    def test_places_that_are_none_have_no_height(self):
        found = self.pack.heights([np.nan, -84.3, np.inf, -84.3, -84.3], [36.5, np.nan, 36.5, 91, 36.5])
        np.testing.assert_array_equal(np.isnan(found.metres), [True, True, True, True, False])

    def test_wrong_arguments_are_value_errors(self):
        for call in (lambda: self.pack.heights([1, 2], [1, 2, 3]), lambda: self.pack.heights(1, 2, level=40),
                     lambda: self.pack.window((1, 2, 1, 3), (5, 5)), lambda: self.pack.window((1, 2, 3, 4), (0, 5)),
                     lambda: self.pack.window((1, 2, 3, 4), (2**40, 2**40)),
                     lambda: self.pack.window((np.nan, 2, 3, 4), (5, 5)), lambda: self.pack.tile(99, 0, 0),
                     lambda: self.pack.tile(0, 0, 0, "colours")):
            with self.assertRaises(ValueError):
                call()
        with self.assertRaises(TypeError):
            self.pack.window((1, 2, 3), (5, 5))
        with self.assertRaises(KeyError):
            self.pack.tile(0, 0, 0)
        with self.assertRaises((ValueError, TypeError)):
            self.pack.heights("a", 1)

    def test_a_window_has_the_heights_at_its_pixels_centres(self):
        bounds, shape = (-84.45, 36.45, -84.15, 36.65), (40, 60)
        window = self.pack.window(bounds, shape, level=self.pack.levels[1])
        lon = bounds[0] + (np.arange(60) + 0.5) * 0.3 / 60
        lat = bounds[3] - (np.arange(40) + 0.5) * 0.2 / 40
        heights = self.pack.heights(lon, lat[:, None]).metres
        self.assertTrue(window.mask.any() and not window.mask.all())
        np.testing.assert_array_equal(window.mask, np.isnan(heights))
        np.testing.assert_allclose(window.filled(0), np.nan_to_num(heights), rtol=0, atol=1e-6)
        coarse = self.pack.window(bounds, (4, 6))
        np.testing.assert_allclose(coarse.compressed(), self.pack.window(bounds, (4, 6), level=0).compressed())

    def test_a_tile_has_its_samples_from_the_north(self):
        level = self.pack.levels[1]
        x, y = int((-84.3 + 180) * 2**level), int((36.6 + 90) * 2**level)
        tile = self.pack.tile(level, x, y)
        side = self.pack.tile_size
        self.assertEqual(tile.shape, (side, side))
        lon = x / 2**level - 180 + np.arange(side) / (side - 1) / 2**level
        lat = (y + 1) / 2**level - 90 - np.arange(side) / (side - 1) / 2**level
        inner = slice(1, side - 1)
        heights = self.pack.heights(lon[inner], lat[inner][:, None]).metres
        np.testing.assert_array_equal(tile.filled(np.nan)[inner, inner], heights)

    def test_imagery_is_the_texels_of_the_tiles(self):
        if not self.has_imagery:
            self.skipTest("GDAL's Python bindings are absent")
        level = self.pack.imagery_levels[1]
        x, y = int((-84.35 + 180) * 2**level), int((36.65 + 90) * 2**level)
        tile = self.pack.tile(level, x, y, "imagery")
        side = self.pack.tile_size - 1
        self.assertEqual(tile.shape, (side, side, 4))
        west, south = x / 2**level - 180, y / 2**level - 90
        window = self.pack.imagery((west, south, west + 2.0**-level, south + 2.0**-level), (side, side))
        np.testing.assert_array_equal(window, tile)
        self.assertEqual(self.pack.imagery((0, 0, 1, 1), (3, 4)).sum(), 0)

    def test_many_threads_share_a_pack(self):
        lon, lat = self.places(20000)
        expected = self.pack.heights(lon, lat).metres
        results = [None] * 8
        threads = [threading.Thread(target=lambda i=i: results.__setitem__(i, self.pack.heights(lon, lat).metres))
                   for i in range(8)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        for result in results:
            np.testing.assert_array_equal(result, expected)

    def test_arrays_outlive_the_pack(self):
        pack = cairn.open(self.path)
        tile = pack.window((-84.3, 36.5, -84.2, 36.6), (9, 9))
        del pack
        gc.collect()
        self.assertGreater(tile.min(), 200)

    def test_files_that_are_no_packs(self):
        with self.assertRaises(FileNotFoundError):
            cairn.open(self.dir / "none.cairn")
        garbage = self.dir / "garbage.cairn"
        garbage.write_bytes(b"x" * 5000)
        with self.assertRaisesRegex(cairn.BadDataError, "garbage.cairn"):
            cairn.open(garbage)
        data = bytearray(self.path.read_bytes())
        for at in range(len(data) // 10, len(data) * 8 // 10, 97):
            data[at] ^= 1
        garbage.write_bytes(data)
        with self.assertRaises(cairn.BadDataError):
            lon, lat = self.places()
            cairn.open(garbage).heights(lon, lat)
        self.assertTrue(issubclass(cairn.BadDataError, cairn.Error) and issubclass(cairn.BadDataError, ValueError))

    def test_bakes_that_cannot_be(self):
        target = self.dir / "wrong.cairn"
        for arguments in (dict(tile_size=100), dict(resampling="best"), dict(void="x"), dict(datum="y"), dict(level=99),
                          dict(region=(2, 1, 1, 2)), dict(memory_mib=1), dict(max_error_m=-1.0), dict(threads=-1)):
            with self.assertRaises(cairn.UsageError, msg=str(arguments)):
                cairn.bake(DEM, target, **arguments)
        with self.assertRaises(cairn.Error):
            cairn.bake(self.dir / "none.tif", target)
        with self.assertRaises(cairn.UsageError):
            cairn.bake([], target)
        with self.assertRaisesRegex(cairn.Error, "force=True"):
            cairn.bake(DEM, self.path)
        with self.assertRaises(TypeError):
            cairn.bake(DEM, target, frobnicate=1)
        self.assertFalse(target.exists())
        with self.assertRaisesRegex(cairn.Error, "allow_error=True"):
            cairn.bake(DEM, target, level=0)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            report = cairn.bake(DEM, target, level=0, allow_error=True, force=True)
        self.assertFalse(report["within_error_bound"])
        self.assertTrue(any(issubclass(w.category, RuntimeWarning) for w in caught))

    def test_progress_cancels_and_resume_goes_on(self):
        target, calls = self.dir / "cancelled.cairn", []
        with self.assertRaisesRegex(cairn.Cancelled, "resume=True"):
            cairn.bake(DEM, target, datum="egm96", level=5, threads=1, progress=lambda *p: calls.append(p) or False)
        self.assertFalse(target.exists())
        stage, done, total = calls[0]
        self.assertTrue(isinstance(stage, str) and 0 <= done <= total)
        self.assertTrue(cairn.bake(DEM, target, datum="egm96", level=5, resume=True)["resumed"])
        with self.assertRaises(ZeroDivisionError):
            cairn.bake(DEM, self.dir / "raised.cairn", threads=1, progress=lambda *p: 1 / 0)

    def test_ctrl_c_ends_a_bake(self):
        code = (f"import sys; sys.path.insert(0, {str(PACKAGES)!r}); import cairn\n"
                f"def told(*p): print('told', flush=True)\n"
                f"cairn.bake({str(DEM)!r}, {str(self.dir / 'interrupted.cairn')!r}, level=8, threads=1, progress=told)")
        with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as bake:
            self.assertEqual(bake.stdout.readline().strip(), "told")
            bake.send_signal(signal.SIGINT)
            _, err = bake.communicate(timeout=300)
        self.assertIn("KeyboardInterrupt", err)
        self.assertFalse((self.dir / "interrupted.cairn").exists())

    def test_the_gil_is_free_while_a_bake_works(self):
        ticks, ended = [], threading.Event()

        def tick():
            while not ended.wait(0.01):
                ticks.append(time.monotonic())

        ticker = threading.Thread(target=tick)
        ticker.start()
        cairn.bake(DEM, self.dir / "free.cairn", level=5)
        ended.set()
        ticker.join()
        self.assertGreater(len(ticks), 3)


if __name__ == "__main__":
    os.environ.setdefault("PYTHONFAULTHANDLER", "1")
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
