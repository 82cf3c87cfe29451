#!/usr/bin/python3
"""Bakes in shards and updates of packs give, byte for byte, what one bake gives.

usage: tests/cli/shards_test.py REPOSITORY PROGRAMS [TEST...]"""

import contextlib
import json
import os
import pathlib
import random
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np

REPOSITORY, PROGRAMS = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
DATA = pathlib.Path(os.environ.get("CAIRN_DATA", REPOSITORY / "../shared/data"))


def run(*arguments):
    return subprocess.run([PROGRAMS / "cairn", *map(str, arguments)], capture_output=True, text=True)


def cairn(*arguments, code=0):
    ran = run(*arguments)
    assert ran.returncode == code, f"cairn {arguments}: {ran.returncode}\n{ran.stdout}\n{ran.stderr}"
    return ran


def kill_midway(arguments, grows):
    """Starts cairn and kills it as `kill -9` does, once the file has some records; whether it was still running."""
    child = subprocess.Popen([PROGRAMS / "cairn", *map(str, arguments)], stdout=subprocess.DEVNULL,
                             stderr=subprocess.DEVNULL)
    while child.poll() is None:
        if grows.exists() and grows.stat().st_size > 4096:
            child.send_signal(signal.SIGKILL)
            break
        time.sleep(0.002)
    return child.wait() == -signal.SIGKILL


def tiff(path, heights, lon, lat, degree):
    """Heights from north to south as a GeoTIFF of int16, whose first post lies at (lon, lat)."""
    rows, columns = heights.shape
    doubles = [(33550, (degree, degree, 0.0)), (33922, (0.0, 0.0, 0.0, lon, lat, 0.0))]
    keys = (1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 2, 2048, 0, 1, 4326)  # geographic, post by post, WGS84
    shorts = {256: columns, 257: rows, 258: 16, 259: 1, 262: 1, 277: 1, 278: rows, 339: 2}
    entries = len(shorts) + len(doubles) + 3
    extra_at = 8 + 2 + 12 * entries + 4
    extra, tags = b"", [(tag, 3, 1, struct.pack("<HH", value, 0)) for tag, value in shorts.items()]
    for tag, values in doubles:
        tags.append((tag, 12, len(values), struct.pack("<I", extra_at + len(extra))))
        extra += struct.pack(f"<{len(values)}d", *values)
    tags.append((34735, 3, len(keys), struct.pack("<I", extra_at + len(extra))))
    extra += struct.pack(f"<{len(keys)}H", *keys)
    tags.append((273, 4, 1, struct.pack("<I", extra_at + len(extra))))
    tags.append((279, 4, 1, struct.pack("<I", 2 * rows * columns)))
    directory = b"".join(struct.pack("<HHI", *tag[:3]) + tag[3] for tag in sorted(tags))
    path.write_bytes(b"II*\0" + struct.pack("<IH", 8, entries) + directory + b"\0\0\0\0" + extra +
                     heights.astype("<i2").tobytes())


def cell(folder, lon, lat, posts, seed=0, void=None):
    """A cell whose heights are a function of place and seed; `void` is a square of places without a value."""
    i = np.arange(posts + 1)
    x = (lon * posts + i)[None, :] / posts
    y = (lat * posts + posts - i)[:, None] / posts
    rough = np.abs(np.sin((x * posts * 12.9898 + y * posts * 78.233) % 6.28318) * 43758.5453) % 1
    heights = 700 + 500 * np.sin(1.7 * x) * np.cos(2.3 * y) + 60 * np.sin(37 * x + 29 * y) + 8 * rough + 40 * seed
    heights = np.round(heights).astype(np.int16)
    if void:
        west, south, east, north = void
        heights[((x > west) & (x < east)) & ((y > south) & (y < north))] = -32768
    path = folder / f"N{lat:02}E{lon:03}.tif"
    tiff(path, heights, float(lon), lat + 1.0, 1 / posts)
    return path


def picture(path, lon, lat, width, height, degree, seed=0):
    """A PNG of noise and bands with its world file."""
    import zlib
    random_ = np.random.default_rng(seed)
    pixels = random_.integers(0, 60, (height, width, 3)) + (np.arange(width)[None, :, None] // 9 % 3) * 60
    rows = b"".join(b"\0" + row.astype(np.uint8).tobytes() for row in pixels)

    def chunk(kind, data):
        return len(data).to_bytes(4, "big") + kind + data + zlib.crc32(kind + data).to_bytes(4, "big")

    head = width.to_bytes(4, "big") + height.to_bytes(4, "big") + bytes([8, 2, 0, 0, 0])
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 1)) +
                     chunk(b"IEND", b""))
    path.with_suffix(".pgw").write_text(
        f"{degree}\n0\n0\n{-degree}\n{lon + degree / 2}\n{lat + height * degree - degree / 2}\n")
    return path


def model(folder, name, size):
    """A model of one triangle."""
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}.obj"
    path.write_text(f"v 0 0 0\nv {size} 0 0\nv 0 {size} {size}\nf 1 2 3\n")
    return path


def places(path, count, bounds, models, seed=0):
    """Places of objects, some of which have no ground beneath them."""
    order = random.Random(seed)
    west, south, east, north = bounds
    lines = ["lon,lat,model,heading,scale,height,mode"]
    for _ in range(count):
        lines.append(f"{order.uniform(west, east):.7f},{order.uniform(south, north):.7f},{order.choice(models)},"
                     f"{order.randrange(360)},{order.uniform(0.5, 2):.3f},"
                     + order.choice(["0,ground", "3.5,ground", "900,absolute"]))
    path.write_text("\n".join(lines) + "\n")
    return path


class InTemporaryFolder(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="cairn-shards-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.inputs = self.folder / "inputs"
        self.inputs.mkdir()

    def copied(self, *names):
        if not DATA.is_dir():
            print("SKIPPED: no real data", file=sys.stderr)
            self.skipTest("no real data")
        paths = []
        for name in names:
            paths.append(self.inputs / pathlib.Path(name).name)
            shutil.copyfile(DATA / name, paths[-1])
        return paths


class Shards(InTemporaryFolder):
    @contextlib.contextmanager
    def only(self, files):
        """Nothing but these inputs is where it was."""
        hidden = self.folder / "hidden"
        hidden.mkdir()
        for path in self.inputs.iterdir():
            if str(path) not in files:
                path.rename(hidden / path.name)
        try:
            yield
        finally:
            for path in hidden.iterdir():
                path.rename(self.inputs / path.name)
            hidden.rmdir()

    def check(self, arguments, counts):
        whole = self.folder / "whole.cairn"
        cairn("bake", *arguments, "-o", whole, "--threads", 2)
        order = random.Random(7)
        for count in counts:
            plan_file = self.folder / f"{count}.json"
            cairn("plan", *arguments, "--shards", count, "-o", plan_file)
            plan = json.loads(plan_file.read_text())
            numbers = list(range(count))
            order.shuffle(numbers)
            parts = []
            for number in numbers:
                part = self.folder / f"{count}.{number}.part"
                parts.append(part)
                files = [plan["files"][f] for f in plan["shards"][number]["files"]]
                names = {f["path"] for f in files} | {b["path"] for f in files for b in f.get("beside", [])}
                verb = ["bake", "--plan", plan_file, "--shard", number, "-o", part, "--threads", 1 + number % 2]
                with self.only(names):
                    if number % 3 == 0:
                        kill_midway(verb, part.with_name(part.name + ".journal"))
                    if not part.exists():
                        cairn(*verb, "--resume")
            order.shuffle(parts)
            merged = self.folder / "merged.cairn"
            with self.only(set()):
                cairn("merge", plan_file, *parts, "-o", merged, "--force", "--threads", 1 + count % 2)
            self.assertEqual(merged.read_bytes(), whole.read_bytes(), f"{count} shards")
            for part in parts:
                part.unlink()

    def test_cells_with_a_lake_across_a_border(self):
        lake = (20.8, 40.2, 21.3, 40.7)
        cells = [cell(self.inputs, 20 + x, 40 + y, 1200, void=lake) for x in range(3) for y in range(2)]
        self.check([*cells, "--tile-size", 257, "--top", -3], [1, 2, 7, 64])

    def test_triangulations_of_fine_cells_among_coarse_ones(self):
        cells = [cell(self.inputs, 20 + x, 40 + y, 1200 if x == 1 else 300) for x in range(3) for y in range(2)]
        self.check([*cells, "--tile-size", 257, "--rqt", 4, "--fade", 3], [2, 7])

    def test_pictures_over_cells(self):
        cells = [cell(self.inputs, 20 + x, 40, 300) for x in range(2)]
        pictures = [picture(self.inputs / f"{n}.png", 20.3 + 0.5 * n, 40.2 + 0.1 * n, 700, 500, 0.001, n)
                    for n in range(3)]
        self.check([*cells, "--imagery", *pictures, "--tile-size", 257, "--texture-quality", "fast", "--feather", 20],
                   [1, 2, 7, 64])

    def test_the_sample(self):
        samples = sorted((REPOSITORY / "sample-dem").glob("*.tif"))
        for sample in samples:
            shutil.copyfile(sample, self.inputs / sample.name)
        self.check([self.inputs / sample.name for sample in samples], [1, 2, 7, 64])

    def test_voids_in_mountains(self):
        self.check(self.copied("srtm3/N41E001.hgt.zip", "srtm3/N42E001.hgt.zip"), [1, 2, 7, 64])

    def test_two_projections_and_a_geoid(self):
        files = self.copied("srtm3/N00E010.hgt", "utm/opentopodata_utm_n00e010.tif")
        geoid = self.copied("geoid/us_nga_egm96_15.tif")
        self.check([*files, "--geoid", *geoid], [2, 7])

    def test_the_whole_earth(self):
        self.check([*self.copied("global/etopo5_4320x2161.tif"), "--tile-size", 257], [7])

    def test_a_photo_over_its_ground(self):
        files = self.copied("geotiff/swellendam_srtm_41_19_4326.tif",
                            "imagery/swellendam_3420B_2010_328_RGB_LATLNG.tif")
        self.check([files[0], "--imagery", files[1], "--texture-quality", "fast", "--region", "20.4,-34.1,20.6,-33.9"],
                   [1, 2, 7, 64])


    def test_parts_stay_good_where_the_change_of_a_cell_is_far_off(self):
        cells = [cell(self.inputs, 20 + x, 40, 600) for x in range(6)]
        plan, parts = self.folder / "plan.json", [self.folder / f"{shard}.part" for shard in range(6)]

        def planned():
            cairn("plan", *cells, "--tile-size", 257, "--shards", 6, "--force", "-o", plan)
            return [shard["key"] for shard in json.loads(plan.read_text())["shards"]]

        def bake(shards):
            for shard in shards:
                cairn("bake", "--plan", plan, "--shard", shard, "--force", "-o", parts[shard])

        before = planned()
        bake(range(6))
        cell(self.inputs, 25, 40, 600, seed=3)
        changed = [shard for shard, key in enumerate(planned()) if key != before[shard]]
        self.assertIn(5, changed)
        self.assertLessEqual(len(changed), 2)
        merged, whole = self.folder / "merged.cairn", self.folder / "whole.cairn"
        self.assertIn(f"{changed[0]}.part", cairn("merge", plan, *parts, "-o", merged, code=3).stderr)
        bake(changed)
        cairn("merge", plan, *parts, "-o", merged)
        cairn("bake", *cells, "--tile-size", 257, "-o", whole)
        self.assertEqual(merged.read_bytes(), whole.read_bytes())


class Objects(InTemporaryFolder):
    """Places and models, beside the folder of rasters: merges and updates read them."""

    OPTIONS = ["--tile-size", 257, "--quantum", 0.25]

    def setUp(self):
        super().setUp()
        self.cells = [cell(self.inputs, 20 + x, 40 + y, 600) for x in range(2) for y in range(2)]
        self.models = self.folder / "models"
        for name, size in (("house", 9), ("mast", 70), ("wall", 2500)):
            model(self.models, name, size)
        self.files = [places(self.folder / f"{n}.csv", 3000, (19.9, 40.1 + n, 22.1, 41 + n), ["house", "mast", "wall"], n)
                      for n in range(2)]

    def arguments(self):
        objects = ["--objects", *self.files, "--models", self.models] if self.files else []
        return [*self.cells, *self.OPTIONS, *objects]

    def full(self):
        pack = self.folder / "full.cairn"
        cairn("bake", *self.arguments(), "-o", pack, "--force", "--threads", 2)
        return pack.read_bytes()

    def test_merged_parts_are_one_bake(self):
        Shards.check(self, [*self.arguments(), "--rqt", 4], [1, 2, 7])

    def test_a_shapefile_in_shards_is_read_as_in_one_bake(self):
        file = self.folder / "p.shp"
        subprocess.run(["ogr2ogr", "-f", "ESRI Shapefile", file, "-dialect", "SQLite", "-sql",
                        f"SELECT MakePoint(CAST(lon AS REAL), CAST(lat AS REAL), 4326), model FROM \"{self.files[0].stem}\"",
                        self.files[0]], check=True, capture_output=True)
        self.files = [file, self.files[1]]
        Shards.check(self, self.arguments(), [2])

    only = Shards.only

    def test_a_merge_reads_objects_as_they_were_planned(self):
        plan, out = self.folder / "plan.json", self.folder / "out.cairn"
        cairn("plan", *self.arguments(), "--shards", 2, "-o", plan)
        parts = [self.folder / f"{shard}.part" for shard in range(2)]
        for shard in range(2):
            cairn("bake", "--plan", plan, "--shard", shard, "-o", parts[shard])
        added = model(self.models, "added", 5)
        self.assertIn("expected the 3 files that were planned", cairn("merge", plan, *parts, "-o", out, code=3).stderr)
        added.unlink()
        for path in (self.files[1], self.models / "mast.obj"):
            text = path.read_text()
            path.write_text(text + "\n")
            self.assertIn(path.name, cairn("merge", plan, *parts, "-o", out, code=3).stderr)
            path.write_text(text)
        (self.files[0]).rename(self.folder / "gone")
        self.assertIn(self.files[0].name, cairn("merge", plan, *parts, "-o", out, code=1).stderr)
        self.assertFalse(out.exists())
        (self.folder / "gone").rename(self.files[0])
        cairn("merge", plan, *parts, "-o", out)
        self.assertEqual(out.read_bytes(), self.full())
        self.assertIn("3.csv", cairn("plan", *self.cells, "--objects", self.folder / "3.csv", "--models", self.models,
                                     "--shards", 2, "-o", self.folder / "no.json", code=2).stderr)

    def test_updates_in_a_row(self):
        pack = self.folder / "pack.cairn"
        cairn("bake", *self.arguments(), "-o", pack)

        def update(*arguments):
            cairn("update", pack, *arguments)
            self.assertEqual(pack.read_bytes(), self.full(), str(arguments))

        update(cell(self.inputs, 21, 41, 600, seed=4))
        update("--objects", places(self.files[0], 2000, (20, 40, 22, 41), ["house", "wall"], 7))
        model(self.models, "house", 12)
        dry = json.loads(cairn("update", pack, "--models", self.models, "--dry-run", "--json").stdout)
        self.assertEqual([pathlib.Path(change["file"]).name for change in dry["changes"]], ["house.obj"])
        self.assertEqual(dry["units_made"], 0)
        update("--models", self.models)
        self.files.append(places(self.folder / "more.csv", 500, (20, 40, 22, 42), ["mast"], 8))
        update("--objects", self.files[-1])
        other = self.folder / "other"
        shutil.move(self.models, other)
        self.models = other
        update("--models", self.models)
        update("--remove", self.files.pop(0).name, cell(self.inputs, 20, 40, 600, seed=2))
        self.files.clear()
        update("--remove", "1.csv", "--remove", "more.csv")
        self.assertIn("models", cairn("update", pack, "--objects", self.folder / "0.csv", code=2).stderr)
        self.files = [self.folder / "0.csv"]
        update("--objects", *self.files, "--models", self.models)
        # What the pack itself states does not say where its objects are from.
        (self.folder / "pack.cairn.units").unlink()
        self.assertIn("pack.cairn.units", cairn("update", pack, *self.cells, code=1).stderr)
        update(*self.cells, "--objects", *self.files, "--models", self.models)


class Refusals(InTemporaryFolder):
    def refused(self, code, *arguments):
        ran = cairn(*arguments, code=code)
        self.assertEqual(len(ran.stderr.splitlines()), 1, ran.stderr)
        return ran.stderr

    def test_what_does_not_belong_together_is_named(self):
        cells = [cell(self.inputs, 20 + x, 40, 240) for x in range(2)]
        first, second = self.folder / "first.json", self.folder / "second.json"
        cairn("plan", *cells, "--tile-size", 257, "--shards", 2, "-o", first)
        cairn("plan", *cells, "--tile-size", 257, "--quantum", 0.5, "--shards", 2, "-o", second)
        self.assertIn("--force", self.refused(2, "plan", *cells, "--shards", 2, "-o", first))
        self.assertIn("input", self.refused(2, "plan", *cells, "--shards", 2, "--force", "-o", cells[0]))
        self.assertIn("--shards", self.refused(2, "plan", *cells, "-o", self.folder / "no.json"))

        a0, a1, b1 = (self.folder / name for name in ("a0.part", "a1.part", "b1.part"))
        cairn("bake", "--plan", first, "--shard", 0, "-o", a0)
        cairn("bake", "--plan", first, "--shard", 1, "-o", a1)
        cairn("bake", "--plan", second, "--shard", 1, "-o", b1)
        self.assertIn("below 2", self.refused(2, "bake", "--plan", first, "--shard", 2, "-o", self.folder / "x"))
        self.assertIn("--shard", self.refused(2, "bake", "--plan", first, "-o", self.folder / "x"))
        self.assertIn("--plan", self.refused(2, "bake", "--shard", 0, *cells, "-o", self.folder / "x"))
        self.assertIn("--level", self.refused(2, "bake", "--plan", first, "--shard", 0, "--level", 3, "-o",
                                              self.folder / "x"))
        self.assertIn("input", self.refused(2, "bake", "--plan", first, "--shard", 0, "--force", "-o", cells[0]))
        self.assertIn("--force", self.refused(2, "bake", "--plan", first, "--shard", 0, "-o", a0))

        out = self.folder / "out.cairn"
        self.assertIn("none for shard 1", self.refused(2, "merge", first, a0, "-o", out))
        twice = self.refused(2, "merge", first, a0, a1, a0, "-o", out)
        self.assertIn("a0.part", twice)
        self.assertIn("shard 0", twice)
        self.assertIn("b1.part", self.refused(3, "merge", first, a0, b1, "-o", out))
        self.assertIn("second.json", self.refused(3, "merge", first, a0, second, "-o", out))
        self.assertIn("a0.part", self.refused(2, "merge", first, a0, a1, "--force", "-o", a0))

        bytes_ = a1.read_bytes()
        for damaged in (b"", bytes_[:30], bytes_[:len(bytes_) // 2], bytes_[:-1], bytes_ + b"\0",
                        bytes_[:-9] + bytes([bytes_[-9] ^ 4]) + bytes_[-8:]):
            a1.write_bytes(damaged)
            self.assertIn("a1.part", self.refused(3, "merge", first, a0, a1, "-o", out))
            self.assertFalse(out.exists())
            self.assertFalse(out.with_name("out.cairn.part").exists())
        a1.write_bytes(bytes_)

        text = first.read_text()
        first.write_text(text.replace('"fade": 1', '"fade": 2'))
        self.assertIn("first.json", self.refused(3, "merge", first, a0, a1, "-o", out))
        first.write_text(text.replace('"cairn": "', '"cairn": "9'))
        self.assertIn("cairn 9", self.refused(3, "merge", first, a0, a1, "-o", out))
        first.write_text(text)
        cairn("merge", first, a1, a0, "-o", out)

        with open(cells[0], "r+b") as changed:
            changed.write(b"\1\2")
        self.assertIn(cells[0].name, self.refused(3, "bake", "--plan", first, "--shard", 0, "-o", self.folder / "x"))


class Updates(InTemporaryFolder):
    def full(self, dems, images, options):
        pack = self.folder / "full.cairn"
        imagery = ["--imagery", *images] if images else []
        cairn("bake", *dems, *imagery, *options, "-o", pack, "--force", "--threads", 2)
        return pack.read_bytes()

    def test_twenty_random_updates_in_a_row(self):
        order = random.Random(3)
        options = ["--tile-size", 257, "--top", -2, "--texture-quality", "fast", "--rqt", 8]
        lake = (20.9, 40.3, 21.2, 40.6)
        places = [(20 + x, 40 + y) for x in range(3) for y in range(2)]

        def new_cell(place):
            return cell(self.inputs, *place, order.choice([300, 300, 600]), seed=order.randrange(9),
                        void=order.choice([None, lake]))

        def new_picture(n):
            return picture(self.inputs / f"{n}.png", 20.2 + 0.4 * n, 40.3, 300, 200, 0.002, order.randrange(99))

        dems = {p: new_cell(p) for p in places[:4]}
        images = {0: new_picture(0)}
        pack = self.folder / "pack.cairn"
        cairn("bake", *dems.values(), "--imagery", *images.values(), *options, "-o", pack)
        for step in range(20):
            what = order.choice(["change", "change", "add", "remove", "picture", "drop"])
            arguments, what_images = [], []
            if what == "remove" and len(dems) > 2:
                gone = order.choice(list(dems))
                arguments = ["--remove", dems.pop(gone).name]
            elif what == "add" and len(dems) < len(places):
                place = order.choice([p for p in places if p not in dems])
                dems[place] = new_cell(place)
                arguments = [dems[place]]
            elif what == "picture" and len(images) < 3:
                n = min(set(range(3)) - set(images))
                images[n] = new_picture(n)
                what_images = ["--imagery", images[n]]
            elif what == "drop" and len(images) > 1:
                arguments = ["--remove", images.pop(order.choice(list(images))).name]
            else:
                place = order.choice(list(dems))
                dems[place] = new_cell(place)
                arguments = [dems[place]]
            if step % 4 == 1:
                kill_midway(["update", pack, *arguments, *what_images], pack.with_name("pack.cairn.journal"))
            cairn("update", pack, *arguments, *what_images, "--threads", 1 + step % 2, "--resume")
            self.assertEqual(pack.read_bytes(), self.full(dems.values(), images.values(), options),
                             f"step {step}: {what} {arguments}")

    def test_one_cell_of_many_is_little_work(self):
        cells = [cell(self.inputs, 20 + x, 40 + y, 1200) for x in range(4) for y in range(4)]
        pack, new = self.folder / "pack.cairn", self.folder / "new.cairn"
        cairn("bake", *cells, "--tile-size", 257, "-o", pack)
        changed = cell(self.inputs, 22, 42, 1200, seed=5)
        dry = json.loads(cairn("update", pack, changed, "--dry-run", "--json").stdout)
        self.assertEqual([c["what"] for c in dry["changes"]], ["changed"])
        before = pack.read_bytes()
        cairn("update", pack, changed, "-o", new)
        self.assertEqual(pack.read_bytes(), before)
        self.assertEqual(new.read_bytes(), self.full(cells, [], ["--tile-size", 257]))
        self.assertEqual(dry["units_made"] + dry["units_taken"], 64)
        self.assertLessEqual(dry["units_made"], 16)  # four of the cell, and those around it

    def test_a_merged_pack_can_be_updated(self):
        cells = [cell(self.inputs, 20 + x, 40, 1200) for x in range(3)]
        pack, plan = self.folder / "pack.cairn", self.folder / "plan.json"
        cairn("plan", *cells, "--tile-size", 257, "--shards", 2, "-o", plan)
        parts = [self.folder / f"{shard}.part" for shard in range(2)]
        for shard in range(2):
            cairn("bake", "--plan", plan, "--shard", shard, "-o", parts[shard])
        cairn("merge", plan, *parts, "-o", pack)
        changed = cell(self.inputs, 22, 40, 1200, seed=1)
        dry = json.loads(cairn("update", pack, changed, "--dry-run", "--json").stdout)
        self.assertGreater(dry["units_taken"], 0)
        cairn("update", pack, changed)
        self.assertEqual(pack.read_bytes(), self.full(cells, [], ["--tile-size", 257]))

    def test_without_its_units_a_pack_is_made_again(self):
        cells = [cell(self.inputs, 20 + x, 40, 300) for x in range(2)]
        pack = self.folder / "pack.cairn"
        cairn("bake", *cells, "--tile-size", 257, "-o", pack)
        (self.folder / "pack.cairn.units").unlink()
        cell(self.inputs, 21, 40, 300, seed=2)
        ran = cairn("update", pack, *cells)
        self.assertIn("every tile is made again", ran.stderr)
        self.assertEqual(pack.read_bytes(), self.full(cells, [], ["--tile-size", 257]))

    def test_names_that_lead_nowhere(self):
        cells = [cell(self.inputs, 20 + x, 40, 240) for x in range(2)]
        pack = self.folder / "pack.cairn"
        cairn("bake", *cells, "--tile-size", 257, "-o", pack)
        self.assertIn("none.tif", cairn("update", pack, "--remove", "none.tif", code=2).stderr)
        cairn("update", pack, code=2)
        cairn("update", pack, "--remove", cells[0].name, "--remove", cells[1].name, code=2)
        cells[0].unlink()
        extra = cell(self.inputs, 22, 40, 240)
        self.assertIn(cells[0].name, cairn("update", pack, extra, code=1).stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
