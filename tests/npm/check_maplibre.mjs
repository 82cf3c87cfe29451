// Shows PMTiles exports in MapLibre GL in headless Chromium from a server on this machine, and checks the heights that it reads.
//
// usage: node check_maplibre.mjs HEIGHTS.pmtiles IMAGERY.pmtiles|- LON,LAT,ZOOM,BEARING,PITCH PLACES.csv PICTURE.png
//   PLACES.csv: lines lon,lat,height of the pack; queryTerrainElevation must give each within the error that the archive states
//   for its finest zoom.
// MapLibre must say nothing on the console. Prints one JSON line; exits 1 where something is wrong, and 0 with SKIPPED where
// there is no Chromium.
import fs from "node:fs";
import path from "node:path";
import { PMTiles } from "pmtiles";
import { showPage, writePicture } from "./browser.mjs";

const [heights, imagery, camera, placesFile, picture] = process.argv.slice(2);
const handle = fs.openSync(heights);
const archive = new PMTiles({
  getKey: () => heights,
  getBytes: async (offset, length) => {
    const bytes = new Uint8Array(length);
    return { data: bytes.buffer.slice(0, fs.readSync(handle, bytes, 0, length, offset)) };
  },
});
const { maxZoom } = await archive.getHeader(), metadata = await archive.getMetadata();
const { encoding, redFactor, greenFactor, blueFactor, baseShift } = metadata;
const stated = metadata.levels.find((level) => level.zoom === maxZoom).max_error_m;

// Places in squares that one view at the finest zoom shows.
const all = fs.readFileSync(placesFile, "utf8").trim().split("\n").map((line) => line.split(",").map(Number))
  .filter((p) => p.length >= 3 && p.every(Number.isFinite));
const width = 360 / 2 ** maxZoom / 4, squares = new Map();
for (const place of all) {
  const key = `${Math.floor(place[0] / width)},${Math.floor((2 * place[1]) / width)}`;
  if (!squares.has(key)) squares.set(key, []);
  squares.get(key).push(place);
}
const views = [...squares.values()].map((places) => ({
  centre: [0, 1].map((i) => (Math.min(...places.map((p) => p[i])) + Math.max(...places.map((p) => p[i]))) / 2),
  places: places.map(([lon, lat]) => [lon, lat]),
}));
const truth = [...squares.values()].flat();

const modules = path.join(path.dirname(new URL(import.meta.url).pathname), "node_modules");
const folders = { "/maplibre/": path.join(modules, "maplibre-gl/dist"), "/pmtiles/": path.join(modules, "pmtiles/dist"),
                  "/export-heights": heights, "/export-imagery": imagery };
const found = await showPage("maplibre_page.html", folders, {
  encoding: encoding === "custom" ? { encoding, redFactor, greenFactor, blueFactor, baseShift } : { encoding },
  imagery: imagery !== "-", camera: camera.split(",").map(Number), finest: maxZoom, views });

const faults = found.failed.slice(0, 10).map((url) => `404: ${url}`).concat((found.complaints ?? []).slice(0, 10));
if (found.error) faults.push(found.error);
let largest = 0, above = 0, read = 0;
(found.found ?? []).forEach((metres, i) => {
  if (metres === "outside") return;
  ++read;
  const [lon, lat, height] = truth[i], off = metres === null ? Infinity : Math.abs(metres - height);
  largest = Math.max(largest, off);
  if (off > stated && ++above < 5) faults.push(`${lon} ${lat}: ${metres}, expected ${height} to ${stated} m`);
});
if (read < 0.9 * all.length) faults.push(`${read} of ${all.length} places were in view`);
writePicture(picture, found.picture);
console.log(JSON.stringify({ encoding, asked: found.asked, failed: found.failed.length, complaints: found.complaints?.length,
                             views: views.length, places: read, above, stated_m: stated, largest_m: largest, faults }));
process.exit(faults.length ? 1 : 0);
