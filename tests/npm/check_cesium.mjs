// Shows an export in CesiumJS in headless Chromium from a server on this machine, and checks what it draws and reads.
//
// usage: node check_cesium.mjs terrain|tileset FOLDER LON,LAT,HEIGHT,HEADING,PITCH PLACES.csv PICTURE.png
//   PLACES.csv: lines lon,lat,height of the pack above the ellipsoid; sampleTerrainMostDetailed must give each within the error
//   that the tile with the place states (of a tileset the places are not asked for).
// Every request must be answered: none with 404. Prints one JSON line; exits 1 where something is wrong, and 0 with SKIPPED
// where there is no Chromium.
import fs from "node:fs";
import path from "node:path";
import { createRequire } from "node:module";
import { showPage, writePicture } from "./browser.mjs";
const require = createRequire(import.meta.url);
const decoder = require("@here/quantized-mesh-decoder");
const decode = decoder.default ?? decoder;

const [kind, folder, camera, placesFile, picture] = process.argv.slice(2);

const places = kind === "terrain"
  ? fs.readFileSync(placesFile, "utf8").trim().split("\n").map((line) => line.split(",").map(Number))
      .filter((p) => p.length >= 3 && p.every(Number.isFinite))
  : [];
const task = { kind, places: places.map(([lon, lat]) => [lon, lat]), camera: camera.split(",").map(Number),
               time: process.env.CAIRN_TIME ?? "2026-06-21T14:00:00Z" };
const cesium = path.join(path.dirname(new URL(import.meta.url).pathname), "node_modules/cesium/Build/Cesium");
const found = await showPage("cesium_page.html", { "/cesium/": cesium, "/export/": folder }, task);

const faults = found.failed.slice(0, 10).map((url) => `404: ${url}`);
if (found.error) faults.push(found.error);
const stated = new Map();
function statedError(lon, lat) {
  const layer = JSON.parse(fs.readFileSync(path.join(folder, "layer.json")));
  for (let level = layer.maxzoom; level >= 0; --level) {
    const width = 180 / 2 ** level;
    const x = Math.min(2 ** (level + 1) - 1, Math.floor((lon + 180) / width)), y = Math.min(2 ** level - 1, Math.floor((lat + 90) / width));
    const file = path.join(folder, `${level}/${x}/${y}.terrain`);
    if (!fs.existsSync(file)) continue;
    if (!stated.has(file)) {
      const bytes = fs.readFileSync(file);
      stated.set(file, decode(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength)).extensions.metadata.geometricerror);
    }
    return stated.get(file);
  }
}
let largest = 0, above = 0;
(found.heights ?? []).forEach((height, i) => {
  const [lon, lat, truth] = places[i], off = height === null ? Infinity : Math.abs(height - truth);
  largest = Math.max(largest, off);
  if (off > statedError(lon, lat)) { if (++above < 5) faults.push(`${lon} ${lat}: ${height}, expected ${truth}`); }
});
writePicture(picture, found.picture);
console.log(JSON.stringify({ kind, asked: found.asked, failed: found.failed.length, frames: found.frames, places: places.length, above,
                             largest_m: largest, faults }));
process.exit(faults.length ? 1 : 0);
