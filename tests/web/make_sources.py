#!/usr/bin/python3
"""Makes heights of hills, heights.tif with a few voids, and a picture over most of them, picture.tif.

usage: make_sources.py FOLDER DEGREES"""
import sys

import numpy as np
import rasterio
from rasterio.transform import from_origin

folder, degrees = sys.argv[1], float(sys.argv[2])
west, north, posts = 7.0, 47.0, 1200
side = int(degrees * posts / 4) if degrees > 1 else int(degrees * posts)
step = degrees / side
x, y = np.meshgrid(np.arange(side) * step, np.arange(side) * step)
heights = 900 + 600 * np.sin(9 * x / degrees) * np.cos(7 * y / degrees) + 60 * np.sin(90 * x / degrees + 40 * y / degrees)
heights = np.round(heights).astype("int16")
heights[side // 3:side // 3 + 5, side // 2:side // 2 + 9] = -32768
with rasterio.open(f"{folder}/heights.tif", "w", driver="GTiff", width=side, height=side, count=1, dtype="int16", nodata=-32768,
                   crs="EPSG:4326", transform=from_origin(west, north, step, step)) as out:
    out.write(heights, 1)

# Squares of two greens, and colours that follow the heights.
part = int(side * 0.8)
picture = np.zeros((3, part, part), dtype="uint8")
rows, columns = np.mgrid[0:part, 0:part]
board = (rows // 40 + columns // 40) % 2
relief = np.clip((heights[:part, :part].astype(float) + 200) / 8, 0, 255)
picture[0] = np.clip(relief * 0.8, 0, 255)
picture[1] = np.where(board, 150, 110)
picture[2] = np.clip(255 - relief, 0, 255) * 0.5
with rasterio.open(f"{folder}/picture.tif", "w", driver="GTiff", width=part, height=part, count=3, dtype="uint8", photometric="RGB",
                   crs="EPSG:4326", transform=from_origin(west, north, step, step)) as out:
    out.write(picture)
