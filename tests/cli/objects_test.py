#!/usr/bin/python3
"""Objects from CSV, GeoJSON and models into a pack and back, and what a bake of objects refuses.

usage: tests/cli/objects_test.py REPOSITORY PROGRAMS [TEST...]"""

import csv
import json
import math
import pathlib
import random
import struct
import subprocess
import sys
import tempfile
import unittest

import numpy as np

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
        self.refused_file(self.write(name, text), expected, models, code)

    def refused_file(self, path, expected, models=None, code=3):
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

    def forest(self, **rule):
        lon, lat = self.middle()
        ring = [[lon - 0.05, lat - 0.05], [lon + 0.05, lat - 0.05], [lon + 0.04, lat + 0.05], [lon - 0.05, lat + 0.05]]
        properties = {"model": "fir:3,oak", "density": 5, "spacing": 20, "seed": 3, **rule}
        return {"type": "FeatureCollection", "features": [{
            "type": "Feature", "properties": properties,
            "geometry": {"type": "Polygon", "coordinates": [ring + ring[:1]]}}]}

    def test_a_polygon_scatters_objects_by_its_rule_whatever_the_threads(self):
        forest = self.write("forest.geojson", json.dumps(self.forest(min_scale=0.5, max_scale=2)))
        one, _ = self.bake("forest1.cairn", [forest], "--threads", 1)
        two, _ = self.bake("forest2.cairn", [forest], "--threads", 3, "--memory", 512)
        self.assertEqual(one.read_bytes(), two.read_bytes())
        cairn("verify", one)
        rows = self.rows(one)
        lon, lat = self.middle()
        # A trapezium of 0.095 by 0.1 degrees on WGS84.
        f = 1 / 298.257223563
        w = 1 - f * (2 - f) * math.sin(math.radians(lat)) ** 2
        north = math.radians(6378137 * (1 - f) ** 2 / w ** 1.5)
        east = math.radians(6378137 / w ** 0.5 * math.cos(math.radians(lat)))
        expected = 5 * 0.095 * east * 0.1 * north / 1e4
        self.assertLess(abs(len(rows) - expected), 5 * expected ** 0.5)
        firs = sum(r["model"] == "fir" for r in rows)
        self.assertLess(abs(firs - 0.75 * len(rows)), 5 * (0.1875 * len(rows)) ** 0.5)
        self.assertTrue(all(0.499 < float(r["scale"]) < 2.001 for r in rows))
        info = json.loads(cairn("info", one, "--json").stdout)["objects"]
        self.assertEqual((info["scattered"], info["outside_limits"], info["left_out"]), (len(rows), 0, 0))
        # No two within the spacing: each is looked for in the squares around it. A place is stored to 1/128 of its size.
        squares = {}
        at = [(float(r["lon"]) * east, float(r["lat"]) * north) for r in rows]
        for x, y in at:
            squares.setdefault((x // 20, y // 20), []).append((x, y))
        for x, y in at:
            near = [p for i in (-1, 0, 1) for j in (-1, 0, 1) for p in squares.get((x // 20 + i, y // 20 + j), [])]
            self.assertEqual(sum(math.hypot(p[0] - x, p[1] - y) < 19.5 for p in near), 1)

    def test_limits_of_height_and_slope_keep_the_others_of_the_same_objects(self):
        everywhere, _ = self.bake("all.cairn", [self.write("all.geojson", json.dumps(self.forest(density=1)))])
        all_rows = self.rows(everywhere)
        limits = dict(min_height=400, max_height=700, max_slope=20)
        some, _ = self.bake("some.cairn", [self.write("some.geojson", json.dumps(self.forest(density=1, **limits)))])
        got = self.rows(some)
        # The slope by heights that cairn sample says, within the square of four samples.
        level = json.loads(cairn("info", everywhere, "--json").stdout)["levels"][-1]["level"]
        step = 2.0 ** -level / 512
        points = []
        for r in all_rows:
            lon, lat = float(r["lon"]), float(r["lat"])
            west, south = math.floor(lon / step) * step, math.floor(lat / step) * step
            points += [(lon, lat), (west + step / 4, lat), (west + 3 * step / 4, lat), (lon, south + step / 4),
                       (lon, south + 3 * step / 4)]
        table = self.write("points.csv", "lon,lat\n" + "".join(f"{x!r},{y!r}\n" for x, y in points))
        heights = [float(r["height"]) for r in csv.DictReader(
            cairn("sample", everywhere, "--points", table).stdout.splitlines())]
        expected, unsure = [], 0
        for i, r in enumerate(all_rows):
            h, w, e, s, n = heights[5 * i:5 * i + 5]
            lat = math.radians(float(r["lat"]))
            f = 1 / 298.257223563
            v = 1 - f * (2 - f) * math.sin(lat) ** 2
            dx = math.radians(step / 2) * 6378137 / v ** 0.5 * math.cos(lat)
            dy = math.radians(step / 2) * 6378137 * (1 - f) ** 2 / v ** 1.5
            slope = math.degrees(math.atan(math.hypot((e - w) / dx, (n - s) / dy)))
            unsure += min(abs(slope - 20), abs(h - 400), abs(h - 700)) < 0.05
            if 400 <= h <= 700 and slope <= 20:
                expected.append((r["lon"], r["lat"], r["model"]))
        self.assertLessEqual(len(set(expected) ^ {(r["lon"], r["lat"], r["model"]) for r in got}), unsure)
        self.assertTrue(0.1 * len(all_rows) < len(got) < 0.9 * len(all_rows))
        info = json.loads(cairn("info", some, "--json").stdout)["objects"]
        self.assertEqual((info["scattered"], info["outside_limits"]), (len(got), len(all_rows) - len(got)))
        self.refused(json.dumps(self.forest(min_height=8000)), "within its rule's limits, found none", name="no.geojson")

    def test_what_ogr_writes_gives_the_objects_of_geojson(self):
        lon, lat = self.middle()
        point = lambda x, **p: {"type": "Feature", "properties": p,
                                "geometry": {"type": "Point", "coordinates": [lon + x, lat]}}
        points = self.write("points.geojson", json.dumps({"type": "FeatureCollection", "features": [
            point(0, model="house", heading=90.5, scale=1.5, height=2, mode="ground"),
            point(0.01, model="fir", heading=0, scale=1, height=900, mode="absolute")]}))
        forest = self.write("wood.geojson", json.dumps(self.forest()))
        def near(a, b):  # PROJ there and back moves a place by less than a step of it
            self.assertEqual(len(a), len(b))
            order = lambda r: (r["model"], round(float(r["lat"]), 5), round(float(r["lon"]), 5))
            for p, q in zip(sorted(a, key=order), sorted(b, key=order)):
                self.assertEqual(p["model"], q["model"])
                for key, most in (("lon", 2e-6), ("lat", 2e-6), ("heading", 0.01), ("scale", 0.001), ("height", QUANTUM)):
                    self.assertLessEqual(abs(float(p[key]) - float(q[key])), most, key)
        for source in (points, forest):
            pack, _ = self.bake("own.cairn", [source])
            own = self.rows(pack)
            # The driver LIBKML writes a field "model" as a thing of KML's own; KML writes it as it is.
            for driver, ending, crs in (("ESRI Shapefile", "shp", "EPSG:32616"), ("GPKG", "gpkg", "EPSG:3857"),
                                        ("KML", "kml", "EPSG:4326")):
                with self.subTest(source=source.name, driver=driver):
                    file = self.dir / f"{source.stem}.{ending}"
                    subprocess.run(["ogr2ogr", "-f", driver, "-t_srs", crs, file, source], check=True,
                                   capture_output=True)
                    pack, _ = self.bake("ogr.cairn", [file])
                    near(self.rows(pack), own)
        # The files of a shapefile are all inputs: the bake is another where its table changes.
        (self.dir / "wood.dbf").unlink()
        self.refused_file(self.dir / "wood.shp", "model: expected NAME")
        # Metres without a CRS are no degrees, and a table has no geometry.
        subprocess.run(["ogr2ogr", "-t_srs", "EPSG:32616", self.dir / "bare.shp", points], check=True, capture_output=True)
        (self.dir / "bare.prj").unlink()
        self.refused_file(self.dir / "bare.shp", "feature 0: lon: expected -360 to 360")
        lines = self.write("lines.geojson", json.dumps({"type": "Feature", "properties": {}, "geometry": {
            "type": "LineString", "coordinates": [[lon, lat], [lon + 0.1, lat]]}}))
        subprocess.run(["ogr2ogr", self.dir / "lines.gpkg", lines], check=True, capture_output=True)
        self.refused_file(self.dir / "lines.gpkg", "layer lines: feature 1: geometry: expected a Point")

    def test_a_side_car_of_the_editor_is_a_file_of_places(self):
        lon, lat = self.middle()
        text = {"type": "FeatureCollection", "features": [
            {"type": "Feature", "note": "kept", "properties": {"model": "barn", "heading": 725.5, "scale": 1.25, "owner": 3},
             "geometry": {"type": "Point", "coordinates": [lon, lat]}}]}
        side_car = self.write("ground.cairn.objects.json", json.dumps(text))
        pack, _ = self.bake("edited.cairn", [side_car])
        row, = self.rows(pack)
        self.assertEqual(row["model"], "barn")
        self.assertAlmostEqual(float(row["heading"]), 5.5, delta=360 / 65536)
        self.assertAlmostEqual(float(row["scale"]), 1.25, delta=1 / 4096)
        # One from which all were deleted adds nothing to other files, and alone it is refused.
        empty = self.write("empty.objects.json", json.dumps({"type": "FeatureCollection", "features": []}))
        both, _ = self.bake("both.cairn", [empty, side_car])
        self.assertEqual(self.rows(both), [row])
        self.refused_file(empty, "expected places of objects, found none")

    def instances(self, folder):
        """Of every GLB below: the model's name, its foot, its right, up and back geocentric, and its scale."""
        found = []
        for path in sorted((folder / "objects").rglob("*.glb")):
            data = path.read_bytes()
            size, = struct.unpack_from("<I", data, 12)
            gltf, binary = json.loads(data[20:20 + size]), data[28 + size:]
            self.assertEqual(gltf["extensionsRequired"], ["EXT_mesh_gpu_instancing"])

            def array(number):
                accessor = gltf["accessors"][number]
                view = gltf["bufferViews"][accessor["bufferView"]]
                columns = {"VEC3": 3, "VEC4": 4}[accessor["type"]]
                return np.frombuffer(binary, "<f4", accessor["count"] * columns, view["byteOffset"]).reshape(-1, columns).astype(float)

            for node in gltf["nodes"]:
                mesh = gltf["meshes"][node["mesh"]]["primitives"][0]
                buffer = gltf["buffers"][gltf["bufferViews"][gltf["accessors"][mesh["indices"]]["bufferView"]]["buffer"]]
                self.assertEqual((path.parent / buffer["uri"]).stat().st_size, buffer["byteLength"])
                self.assertTrue((path.parent / gltf["images"][0]["uri"]).read_bytes().startswith(b"\x89PNG"))
                attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
                for t, (x, y, z, w), scale in zip(*(array(attributes[k]) for k in ("TRANSLATION", "ROTATION", "SCALE"))):
                    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
                    z_up = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
                    found.append((node["name"], z_up @ (t + node["translation"]), (z_up @ turn).T, scale[0]))
        return found

    def test_an_export_as_3d_tiles_has_every_object_on_the_ground(self):
        lon, lat = self.middle()
        lines = "".join(f"{lon + 0.001 * i},{lat + 0.0005 * i},{m},{37 * i % 360},{0.6 + 0.1 * i},{h},{mode}\n"
                        for i, (m, h, mode) in enumerate([("house", 0, "ground"), ("fir", 2.5, "ground"), ("oak", 900, "absolute"),
                                                          ("bush", 0, "ground"), ("barn", 0, "ground")] * 3))
        pack = self.dir / "tiles.cairn"
        cairn("bake", DEM, "-o", pack, "--quantum", QUANTUM, "--datum", "ellipsoid", "--objects", self.places,
              self.write("few.csv", "lon,lat,model,heading,scale,height,mode\n" + lines), "--models", self.models)
        printed = cairn("export", pack, "-o", self.dir / "tiles", "--format", "3dtiles").stdout
        rows = self.rows(pack)
        found = self.instances(self.dir / "tiles")
        self.assertIn(f"{len(rows)} objects of 5 models", printed)
        self.assertEqual(len(found), len(rows))
        table = self.write("feet.csv", "lon,lat\n" + "".join(f"{r['lon']},{r['lat']}\n" for r in rows))
        ground = [float(r["height"]) for r in csv.DictReader(cairn("sample", pack, "--points", table).stdout.splitlines())]
        by_name = {}
        for name, foot, axes, scale in found:
            by_name.setdefault(name, []).append((foot, axes, scale))
        trees = {name: np.array([f for f, _, _ in those]) for name, those in by_name.items()}
        a, f = 6378137.0, 1 / 298.257223563
        for r, height in zip(rows, ground):
            x, y = math.radians(float(r["lon"])), math.radians(float(r["lat"]))
            up = np.array([math.cos(y) * math.cos(x), math.cos(y) * math.sin(x), math.sin(y)])
            east = np.array([-math.sin(x), math.cos(x), 0])
            north = np.cross(up, east)
            n = a / math.sqrt(1 - f * (2 - f) * math.sin(y) ** 2)
            high = height + float(r["height"])
            expected = np.array([(n + high) * up[0], (n + high) * up[1], (n * (1 - f) ** 2 + high) * up[2]])
            off = np.linalg.norm(trees[r["model"]] - expected, axis=1)
            nearest = int(np.argmin(off))
            # Feet are whole quanta, and what is printed of a place is 1e-10 degrees.
            self.assertLess(off[nearest], QUANTUM / 2 + 0.01)
            _, axes, scale = by_name[r["model"]][nearest]
            turn = math.radians(float(r["heading"]))
            ahead = math.sin(turn) * east + math.cos(turn) * north
            self.assertLess(np.abs(axes - [np.cross(ahead, up), up, -ahead]).max(), 1e-4)
            self.assertAlmostEqual(scale, float(r["scale"]), delta=1e-5)
        # A region has those of its own, and a pack without any there the ground alone.
        west, south, east, north = lon - 0.02, lat - 0.02, lon + 0.02, lat + 0.02
        cairn("export", pack, "-o", self.dir / "part", "--format", "3dtiles", f"--region={west},{south},{east},{north}")
        inside = [r for r in rows if west <= float(r["lon"]) <= east and south <= float(r["lat"]) <= north]
        self.assertEqual(len(self.instances(self.dir / "part")), len(inside))
        self.assertTrue(0 < len(inside) < len(rows))
        cairn("export", self.dir / "ground.cairn", "-o", self.dir / "bare", "--format", "3dtiles", "--datum", "ellipsoid")
        self.assertFalse((self.dir / "bare/objects").exists() or (self.dir / "bare/ground.json").exists())

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
        self.refused("no vectors", "expected CSV, GeoJSON or a format of GDAL", name="bad.gpkg")

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


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
