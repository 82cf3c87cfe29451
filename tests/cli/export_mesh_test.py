#!/usr/bin/python3
"""Exports regions as GLB and OBJ, reads these with decoders of its own and measures the source posts against the triangles.

usage: tests/cli/export_mesh_test.py REPOSITORY PROGRAMS"""

import io
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

import matplotlib.image
import numpy as np
from matplotlib.tri import LinearTriInterpolator, Triangulation
from osgeo import gdal, osr

gdal.UseExceptions()
REPOSITORY, PROGRAMS = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
SOURCE = REPOSITORY / "sample-dem/jacksboro_fault.tif"
REGION = (-84.33, 36.53, -84.25, 36.61)


def cairn(*arguments, code=0):
    ran = subprocess.run([PROGRAMS / "cairn", *map(str, arguments)], capture_output=True, text=True)
    assert ran.returncode == code, f"cairn {arguments}: {ran.returncode}\n{ran.stdout}\n{ran.stderr}"
    return ran


def export(pack, out, *arguments):
    return json.loads(cairn("export", pack, "-o", out, "--json", *arguments).stdout)["levels"][0]


class Mesh:
    """Positions are east, north and up; texture coordinates count from the image's west and north."""

    def surface(self):
        east, north, up = self.positions.T
        return LinearTriInterpolator(Triangulation(east, north, self.triangles), up)


class Glb(Mesh):
    def __init__(self, path):
        data = path.read_bytes()
        magic, version, length, size, kind = struct.unpack_from("<4sIIII", data)
        assert (magic, version, length, kind) == (b"glTF", 2, len(data), 0x4E4F534A)
        gltf = json.loads(data[20 : 20 + size])
        binary = data[28 + size :]
        self.about = gltf["asset"]["extras"]

        def array(number, columns):
            accessor = gltf["accessors"][number]
            view = gltf["bufferViews"][accessor["bufferView"]]
            kind = {5126: "<f4", 5125: "<u4", 5123: "<u2"}[accessor["componentType"]]
            flat = np.frombuffer(binary, kind, accessor["count"] * (1 if columns == 1 else columns), view["byteOffset"])
            return flat if columns == 1 else flat.reshape(-1, columns)

        (primitive,) = gltf["meshes"][0]["primitives"]
        attributes = primitive["attributes"]
        x, y, z = (array(attributes["POSITION"], 3).astype(float) + gltf["nodes"][0]["translation"]).T
        self.positions = np.column_stack([x, -z, y])
        nx, ny, nz = array(attributes["NORMAL"], 3).T
        self.normals = np.column_stack([nx, -nz, ny])
        self.triangles = array(primitive["indices"], 1).astype(np.int64).reshape(-1, 3)
        self.image = None
        if "images" in gltf:
            view = gltf["bufferViews"][gltf["images"][0]["bufferView"]]
            jpeg = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
            self.image = matplotlib.image.imread(io.BytesIO(jpeg), "jpeg")
            self.texture = array(attributes["TEXCOORD_0"], 2)


class Obj(Mesh):
    def __init__(self, folder):
        rows = {"v": [], "vt": [], "vn": [], "f": []}
        for line in (folder / "terrain.obj").read_text().splitlines():
            words = line.split()
            if words[0] == "#":
                self.about = json.loads(line[line.index("{") :])
            elif words[0] == "f":
                rows["f"].append([int(word.split("/")[0]) - 1 for word in words[1:]])
            elif words[0] in rows:
                rows[words[0]].append([float(word) for word in words[1:]])
        x, y, z = np.array(rows["v"]).T
        self.positions = np.column_stack([x, -z, y])
        nx, ny, nz = np.array(rows["vn"]).T
        self.normals = np.column_stack([nx, -nz, ny])
        self.triangles = np.array(rows["f"])
        material = (folder / "terrain.mtl").read_text()
        self.image = None
        if "map_Kd" in material:
            self.image = matplotlib.image.imread(folder / material.split("map_Kd ")[1].strip())
            self.texture = np.array(rows["vt"]) * [1, -1] + [0, 1]


def posts_of(path, region):
    """Longitudes, latitudes and heights of the source's posts in the region, as GDAL reads them."""
    raster = gdal.Open(str(path))
    x0, dx, _, y0, _, dy = raster.GetGeoTransform()
    heights = raster.ReadAsArray().astype(float)
    heights[heights == raster.GetRasterBand(1).GetNoDataValue()] = np.nan
    lon, lat = np.meshgrid(x0 + dx * (np.arange(heights.shape[1]) + 0.5), y0 + dy * (np.arange(heights.shape[0]) + 0.5))
    inside = (lon > region[0]) & (lon < region[2]) & (lat > region[1]) & (lat < region[3])
    return lon[inside], lat[inside], heights[inside]


def on_plane(about, lon, lat):
    """By PROJ, from what the file says of itself."""
    plane, degrees = osr.SpatialReference(), osr.SpatialReference()
    centre = about["centre"]
    plane.ImportFromProj4(f"+proj=tmerc +lat_0={centre['lat']!r} +lon_0={centre['lon']!r} +k=1 +ellps=WGS84 +units=m")
    degrees.ImportFromProj4("+proj=longlat +ellps=WGS84")
    points = osr.CoordinateTransformation(degrees, plane).TransformPoints(np.column_stack([lon, lat]).tolist())
    return np.array(points)[:, :2].T


class Meshes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.pack = cls.folder / "fault.cairn"
        cairn("bake", SOURCE, "-o", cls.pack, "--imagery", cls.picture(), "--datum", "ellipsoid")

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def picture(cls):
        """Red grows to the east and green to the north of REGION."""
        path = cls.folder / "colours.tif"
        size = 500
        raster = gdal.GetDriverByName("GTiff").Create(str(path), size, size, 3)
        raster.SetGeoTransform((REGION[0], (REGION[2] - REGION[0]) / size, 0, REGION[3], 0, (REGION[1] - REGION[3]) / size))
        degrees = osr.SpatialReference()
        degrees.ImportFromEPSG(4326)
        raster.SetProjection(degrees.ExportToWkt())
        along = np.linspace(0, 255, size)
        for band, values in enumerate((np.tile(along, (size, 1)), np.tile(along[::-1, None], (1, size)), np.zeros((size, size)))):
            raster.GetRasterBand(band + 1).WriteArray(values.astype(np.uint8))
        raster = None
        return path

    def check(self, mesh, stated, source=SOURCE, region=REGION):
        self.assertEqual(mesh.about["max_error_m"], stated["max_error_m"])
        self.assertLessEqual(stated["max_error_m"], stated["bound_m"])
        self.assertEqual((len(mesh.positions), len(mesh.triangles)), (stated["vertices"], stated["triangles"]))
        a, b, c = (mesh.positions[mesh.triangles[:, i], :2] for i in range(3))
        areas = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
        self.assertGreater(areas.min(), 0)  # all of them face up
        self.assertTrue(np.allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-3))
        self.assertGreater(mesh.normals[:, 2].min(), 0)
        lon, lat, heights = posts_of(source, region)
        found = mesh.surface()(*on_plane(mesh.about, lon, lat))
        return np.ma.filled(found, np.nan) - heights

    def test_no_post_is_farther_from_the_triangles_than_stated(self):
        region = ",".join(map(str, REGION))
        for bound in (3, 25):
            for kind, reader in (("glb", Glb), ("obj", Obj)):
                with self.subTest(kind=kind, bound=bound):
                    out = self.folder / f"{bound}.{kind}"
                    stated = export(self.pack, out, "--format", kind, "--region=" + region, "--max-error", bound)
                    self.assertEqual(stated["bound_m"], bound)
                    off = self.check(reader(out), stated)
                    self.assertGreater(off.size, 9000)
                    self.assertFalse(np.isnan(off).any())  # every post is covered
                    self.assertLessEqual(np.abs(off).max(), stated["max_error_m"])
                    self.assertGreater(np.abs(off).max(), 0.5 * stated["max_error_m"])

    def test_the_image_lies_as_the_ground_does(self):
        out = {"glb": self.folder / "image.glb", "obj": self.folder / "image.obj"}
        for kind, reader in (("glb", Glb), ("obj", Obj)):
            export(self.pack, out[kind], "--format", kind, "--region=" + ",".join(map(str, REGION)), "--max-error", 50)
            mesh = reader(out[kind])
            height, width, _ = mesh.image.shape
            self.assertGreaterEqual(mesh.texture.min(), 0)
            self.assertLessEqual(mesh.texture.max(), 1)
            u, v = mesh.texture.T
            # Away from the rim, where white begins.
            inside = (u > 0.05) & (u < 0.95) & (v > 0.05) & (v < 0.95)
            colours = mesh.image[(v[inside] * height).astype(int), (u[inside] * width).astype(int)].astype(float)
            corners = on_plane(mesh.about, [REGION[0], REGION[2]], [REGION[1], REGION[3]])
            east, north = (mesh.positions[inside, i] for i in (0, 1))
            self.assertGreater(inside.sum(), 100)
            for colour, at, (low, high) in ((colours[:, 0], east, corners[0]), (colours[:, 1], north, corners[1])):
                self.assertLess(np.abs(colour - 255 * (at - low) / (high - low)).max(), 16)

    def test_ground_without_heights_is_open(self):
        source = self.folder / "hole.tif"
        raster = gdal.GetDriverByName("GTiff").CreateCopy(str(source), gdal.Open(str(SOURCE)))
        band = raster.GetRasterBand(1)
        heights = band.ReadAsArray()
        heights[180:210, 130:170] = -9999
        heights[220, 200] = -9999
        band.SetNoDataValue(-9999)
        band.WriteArray(heights)
        raster.FlushCache()
        raster = band = None
        pack = self.folder / "hole.cairn"
        cairn("bake", source, "-o", pack, "--void", "keep", "--datum", "ellipsoid")
        for bound in (4, 60):
            out = self.folder / f"hole-{bound}.glb"
            stated = export(pack, out, "--format", "glb", "--max-error", bound, "--region=" + ",".join(map(str, REGION)))
            mesh = Glb(out)
            x0, dx, _, y0, _, dy = gdal.Open(str(source)).GetGeoTransform()
            off = self.check(mesh, stated, source)
            known = ~np.isnan(posts_of(source, REGION)[2])
            self.assertLessEqual(np.nanmax(np.abs(off)), stated["max_error_m"])
            # Posts beside the hole lie in cells without a surface: a ring of 150 posts, and 8 around the single one.
            self.assertLess(np.isnan(off[known]).sum(), 250)
            middle = on_plane(mesh.about, [x0 + 150 * dx], [y0 + 195 * dy])
            self.assertTrue(np.ma.is_masked(mesh.surface()(*middle)[0]))
            self.assertGreater(mesh.positions[:, 2].min(), 200)  # no wall goes down to nothing

    def test_bytes_do_not_depend_on_threads(self):
        for kind in ("glb", "obj"):
            one, many = self.folder / f"one.{kind}", self.folder / f"many.{kind}"
            export(self.pack, one, "--format", kind, "--max-error", 60, "--threads", 1)
            export(self.pack, many, "--format", kind, "--max-error", 60, "--threads", 3, "--memory", 700)
            if kind == "glb":
                self.assertEqual(one.read_bytes(), many.read_bytes())
                continue
            self.assertEqual(sorted(p.name for p in one.iterdir()), ["terrain.jpg", "terrain.mtl", "terrain.obj"])
            for path in one.iterdir():
                self.assertEqual(path.read_bytes(), (many / path.name).read_bytes())

    def test_refusals(self):
        for kind in ("glb", "obj"):
            for arguments, code in ((("--region", "10,10,11,11"), 1), (("--levels", "0-2"), 2), (("--max-error", 0.01), 2),
                                    (("--region=-84.3,30,-60,36.6",), 2), (("--region", "170,36,190,37"), 2),
                                    (("--memory", 10), 2)):
                with self.subTest(kind=kind, arguments=arguments):
                    target = self.folder / f"refused-{kind}"
                    ran = cairn("export", self.pack, "-o", target, "--format", kind, *arguments, code=code)
                    self.assertEqual(len([line for line in ran.stderr.splitlines() if line.startswith("cairn:")]), 1)
                    self.assertFalse(target.exists())
                    self.assertFalse(target.with_name(target.name + ".part").exists())
            target = self.folder / f"exists-{kind}"
            target.write_text("mine")
            cairn("export", self.pack, "-o", target, "--format", kind, code=2)
            self.assertEqual(target.read_text(), "mine")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
