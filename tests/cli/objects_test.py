#!/usr/bin/python3
"""Objects from CSV, GeoJSON and models into a pack and back, and what a bake of objects refuses.

usage: tests/cli/objects_test.py REPOSITORY PROGRAMS [TEST...]"""

import csv
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

REPOSITORY, PROGRAMS = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
DEM = REPOSITORY / "sample-dem/jacksboro_fault.tif"
MAKER = REPOSITORY / "scripts/make_object_data"
QUANTUM = 0.25


def cairn(*arguments, code=0):
    ran = subprocess.run([PROGRAMS / "cairn", *map(str, arguments)], capture_output=True, text=True)
    assert ran.returncode == code, f"cairn {arguments}: {ran.returncode}\n{ran.stdout}\n{ran.stderr}"
    return ran


class Objects(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.dir = pathlib.Path(cls.folder.name)
        cls.models = cls.dir / "models"
        subprocess.run([MAKER, "models", cls.models], check=True)
        cairn("bake", DEM, "-o", cls.dir / "ground.cairn", "--quantum", QUANTUM)
        cls.ground = json.loads(cairn("info", cls.dir / "ground.cairn", "--json").stdout)
        b = cls.ground["bounds"]
        cls.west, cls.south, cls.east, cls.north = (b[k] for k in ("west", "south", "east", "north"))
        cls.places = cls.dir / "places.csv"
        subprocess.run([MAKER, "places", cls.places, "--count", "20000",
                        f"--bounds={cls.west + 1e-4},{cls.south + 1e-4},{cls.east - 1e-4},{cls.north - 1e-4}"], check=True)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def bake(self, name, places, *more, code=0):
        pack = self.dir / name
        ran = cairn("bake", DEM, "-o", pack, "--quantum", QUANTUM, "--force", "--objects", *places, "--models",
                    self.models, *more, code=code)
        return pack, ran

    def rows(self, pack):
        out = self.dir / "out.csv"
        cairn("extract", pack, "--layer", "objects", "-o", out)
        with open(out) as text:
            return list(csv.DictReader(text))

    def write(self, name, text):
        path = self.dir / name
        path.write_text(text)
        return path

    def middle(self, dx=0.0, dy=0.0):
        return (self.west + self.east) / 2 + dx, (self.south + self.north) / 2 + dy

    def refused(self, text, expected, name="bad.csv", models=None, code=3):
        path = self.write(name, text)
        target = self.dir / "refused.cairn"
        ran = cairn("bake", DEM, "-o", target, "--objects", path, "--models", models or self.models, code=code)
        self.assertEqual(len(ran.stderr.strip().splitlines()), 1, ran.stderr)
        self.assertIn(expected, ran.stderr)
        self.assertFalse(target.exists())
        self.assertFalse(target.with_suffix(".cairn.part").exists())

    def test_every_place_comes_back_and_the_pack_verifies(self):
        pack, _ = self.bake("a.cairn", [self.places])
        cairn("verify", pack)
        with open(self.places) as text:
            given = list(csv.DictReader(text))
        got = self.rows(pack)
        self.assertEqual(len(got), len(given))
        # A tile's step is 1/65536 of its height, and its objects are 1/512 of that or larger: 1/128 of a size.
        key = lambda r: (r["model"], round(float(r["scale"]), 3), round(float(r["heading"]), 1) % 360)
        at = {}
        for row in got:
            at.setdefault(key(row), []).append((float(row["lon"]), float(row["lat"])))
        for row in given:
            near = at[key(row)]
            distance = min(max(abs(x - float(row["lon"])), abs(y - float(row["lat"]))) for x, y in near)
            self.assertLess(distance * 111320, 30 / 128)

    def test_a_bake_of_what_was_extracted_is_the_same_layer(self):
        first, _ = self.bake("b.cairn", [self.places])
        before = self.rows(first)
        with open(self.dir / "again.csv", "w") as out:
            out.write((self.dir / "out.csv").read_text())
        second, _ = self.bake("c.cairn", [self.dir / "again.csv"])
        self.assertEqual(self.rows(second), before)

    def test_bytes_depend_neither_on_threads_nor_memory_nor_the_order_of_places(self):
        one, _ = self.bake("one.cairn", [self.places], "--threads", 1, "--memory", 512)
        two, _ = self.bake("two.cairn", [self.places], "--threads", 3)
        self.assertEqual(one.read_bytes(), two.read_bytes())
        lines = self.places.read_text().splitlines()
        random.Random(3).shuffle(rest := lines[1:])
        shuffled = self.write("shuffled.csv", "\n".join([lines[0], *rest]) + "\n")
        three, _ = self.bake("three.cairn", [shuffled])
        self.assertEqual(self.rows(one), self.rows(three))

    def test_geojson_and_csv_of_equal_places_are_equal_objects(self):
        lon, lat = self.middle()
        text = f"lon,lat,model,heading,scale,height,mode\n{lon},{lat},house,90,1.5,2,ground\n{lon},{lat},fir,,,,\n"
        point = {"type": "Point", "coordinates": [lon, lat]}
        feature = lambda **p: {"type": "Feature", "geometry": point, "properties": p}
        collection = {"type": "FeatureCollection", "features": [
            feature(model="house", heading=90, scale=1.5, height=2, mode="ground"), feature(model="fir")]}
        a, _ = self.bake("csv.cairn", [self.write("two.csv", text)])
        b, _ = self.bake("geojson.cairn", [self.write("two.geojson", json.dumps(collection))])
        self.assertEqual(self.rows(a), self.rows(b))
        self.assertEqual({r["model"] for r in self.rows(a)}, {"house", "fir"})

    def test_an_absolute_foot_is_at_its_height_and_ground_is_kept(self):
        lon, lat = self.middle()
        pack, _ = self.bake("abs.cairn", [self.write("abs.csv", f"lon,lat,model,height,mode\n"
                                                                f"{lon},{lat},house,1000,absolute\n")])
        row = self.rows(pack)[0]
        sampled = json.loads(cairn("sample", pack, row["lon"], row["lat"], "--json").stdout)
        ground = sampled["height"]
        self.assertLessEqual(abs(ground + float(row["height"]) - 1000), QUANTUM)

    def test_places_without_ground_are_left_out_with_a_warning(self):
        lon, lat = self.middle()
        pack, ran = self.bake("out.cairn", [self.write("some.csv", f"lon,lat,model\n{lon},{lat},oak\n0,0,oak\n")])
        self.assertIn("objects: 1 of 2 left out", ran.stderr)
        self.assertEqual(len(self.rows(pack)), 1)
        self.assertEqual(json.loads(cairn("info", pack, "--json").stdout)["objects"]["left_out"], 1)
        cairn("verify", pack)
        self.refused("lon,lat,model\n0,0,oak\n", "expected a place with ground beneath it, found none")

    def test_bad_places_are_refused_by_one_line(self):
        lon, lat = self.middle()
        head = "lon,lat,model,scale,mode\n"
        self.refused(head + f"{lon},{lat},elm,1,ground\n", "line 2: model: expected one of")
        self.refused(head + f"{lon},{lat},oak,nan,ground\n", "line 2: scale: expected")
        self.refused(head + f"{lon},{lat},oak,0,ground\n", "line 2: scale: expected")
        self.refused(head + f"{lon},91,oak,1,ground\n", "line 2: lat: expected -90 to 90")
        self.refused(head + f"inf,{lat},oak,1,ground\n", "line 2: lon: expected")
        self.refused(head + f"{lon},{lat},oak,1,floating\n", "line 2: mode: expected ground or absolute")
        self.refused(head + f"{lon},{lat},oak\n", "line 2: expected 5 fields, found 3")
        self.refused("lon,lat\n1,2\n", "line 1: expected columns lon,lat,model")
        self.refused("lon,lat,model,colour\n", "found 'colour'")
        self.refused("", "expected lines of places")
        self.refused(head, "expected places of objects, found none")
        self.refused("{", "found no JSON", name="bad.geojson")
        line = {"type": "Feature", "geometry": {"type": "LineString", "coordinates": []}, "properties": {}}
        self.refused(json.dumps(line), "feature 0: geometry: expected a Point", name="bad.geojson")

    def test_bad_models_are_refused_by_one_line(self):
        lon, lat = self.middle()
        place = f"lon,lat,model\n{lon},{lat},bad\n"
        triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl skin\nf 1 2 3\n"
        cycle = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                 "nodes": [{"children": [1]}, {"children": [0]}]}
        cases = [("bad.obj", "this is no model\n", "bad.obj: "),
                 ("bad.gltf", json.dumps(cycle), "bad.gltf: "),
                 ("bad.glb", "glTF", "bad.glb: "),
                 ("bad.obj", "v 1 2 3\nv 1 2 3\nv 1 2 3\nf 1 2 3\n", "bad.obj: "),
                 ("bad.obj", "v 0 0 0\nv 1e30 0 0\nv 0 1e30 0\nf 1 2 3\n", "bad.obj: "),
                 ("bad.obj", "mtllib bad.mtl\n" + triangle, "texture gone.png: expected an image"),
                 ("bad.3x4.png", "no image", "bad.3x4.png: ")]
        for name, text, expected in cases:
            with self.subTest(name=name, text=text[:30]), tempfile.TemporaryDirectory() as folder:
                folder = pathlib.Path(folder)
                (folder / name).write_text(text)
                (folder / "bad.mtl").write_text("newmtl skin\nmap_Kd gone.png\n")
                self.refused(place, expected, models=folder)
        with tempfile.TemporaryDirectory() as folder:
            for name in ("bad.obj", "bad.dxf"):
                (pathlib.Path(folder) / name).write_text(triangle)
            self.refused(place, "expected one file for model bad", models=folder, code=2)

    def test_wrong_usage_is_refused_by_one_line(self):
        target = self.dir / "never.cairn"
        for more, expected in ((["--objects", self.places], "expected --models with it"),
                               (["--models", self.models], "expected --objects with it"),
                               (["--objects", self.dir / "gone.csv", "--models", self.models], "expected a file"),
                               (["--objects", self.places, "--models", self.places], "expected a folder")):
            ran = cairn("bake", DEM, "-o", target, *more, code=2)
            self.assertIn(expected, ran.stderr)
            self.assertEqual(len(ran.stderr.strip().splitlines()), 1, ran.stderr)
        ran = cairn("plan", DEM, "-o", self.dir / "plan.json", "--shards", 2, "--objects", self.places, "--models",
                    self.models, code=2)
        self.assertIn("expected none in a bake that is divided", ran.stderr)
        pack, _ = self.bake("update.cairn", [self.places])
        ran = cairn("update", pack, DEM, code=2)
        self.assertIn("expected a pack without objects", ran.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
