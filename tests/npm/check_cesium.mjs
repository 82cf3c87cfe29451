// Shows an export in CesiumJS in headless Chromium from a server on this machine, and checks what it draws and reads.
//
// usage: node check_cesium.mjs terrain|tileset FOLDER LON,LAT,HEIGHT,HEADING,PITCH PLACES.csv PICTURE.png
//   PLACES.csv: lines lon,lat,height of the pack above the ellipsoid; sampleTerrainMostDetailed must give each within the error
//   that the tile with the place states (of a tileset the places are not asked for).
// Every request must be answered: none with 404. Prints one JSON line; exits 1 where something is wrong, and 0 with SKIPPED
// where there is no Chromium.
import { execFileSync, spawn } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import os from "node:os";
import path from "node:path";
import { createRequire } from "node:module";
const require = createRequire(import.meta.url);
const decoder = require("@here/quantized-mesh-decoder");
const decode = decoder.default ?? decoder;

const [kind, folder, camera, placesFile, picture] = process.argv.slice(2);
const chromium = ["chromium", "chromium-browser", "google-chrome"].find((name) => {
  try { execFileSync("which", [name], { stdio: "ignore" }); return true; } catch { return false; }
});
if (!chromium) { console.log("SKIPPED: no Chromium is installed"); process.exit(0); }

const places = kind === "terrain"
  ? fs.readFileSync(placesFile, "utf8").trim().split("\n").map((line) => line.split(",").map(Number))
      .filter((p) => p.length >= 3 && p.every(Number.isFinite))
  : [];
const task = { kind, places: places.map(([lon, lat]) => [lon, lat]), camera: camera.split(",").map(Number),
               time: process.env.CAIRN_TIME ?? "2026-06-21T14:00:00Z" };
const cesium = path.join(path.dirname(new URL(import.meta.url).pathname), "node_modules/cesium/Build/Cesium");
const page = path.join(path.dirname(new URL(import.meta.url).pathname), "cesium_page.html");
const types = { ".js": "text/javascript", ".css": "text/css", ".json": "application/json", ".html": "text/html",
                ".wasm": "application/wasm", ".png": "image/png", ".jpg": "image/jpeg", ".glb": "model/gltf-binary",
                ".terrain": "application/vnd.quantized-mesh" };
const failed = [];
let asked = 0, finish;
const result = new Promise((resolve) => { finish = resolve; });
const server = http.createServer((request, response) => {
  const url = decodeURIComponent(request.url.split("?")[0]);
  if (url === "/task") return response.end(JSON.stringify(task));
  if (url === "/result") {
    let body = "";
    request.on("data", (d) => (body += d));
    request.on("end", () => { response.end(); finish(JSON.parse(body)); });
    return;
  }
  const file = url === "/" ? page : url.startsWith("/cesium/") ? path.join(cesium, url.slice(8))
    : url.startsWith("/export/") ? path.join(folder, url.slice(8)) : "";
  if (url.startsWith("/export/")) ++asked;
  fs.readFile(file || "/nonexistent", (error, data) => {
    if (error) {
      if (url !== "/favicon.ico") failed.push(url);
      response.statusCode = 404;
      return response.end();
    }
    response.setHeader("Content-Type", types[path.extname(file)] ?? "application/octet-stream");
    response.end(data);
  });
});
await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
const profile = fs.mkdtempSync(path.join(os.tmpdir(), "cairn-chromium-"));
const browser = spawn(chromium, ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                                 "--window-size=960,540", `--user-data-dir=${profile}`,
                                 `http://127.0.0.1:${server.address().port}/`], { stdio: "ignore", detached: true });
const timer = setTimeout(() => finish({ error: "no answer after 480 s" }), 480000);
const found = await result;
clearTimeout(timer);
try { process.kill(-browser.pid); } catch { /* it has ended */ }
server.close();
server.closeAllConnections?.();
setTimeout(() => fs.rmSync(profile, { recursive: true, force: true }), 500);

const faults = failed.slice(0, 10).map((url) => `404: ${url}`);
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
if (picture && found.picture) fs.writeFileSync(picture, Buffer.from(found.picture.split(",")[1], "base64"));
console.log(JSON.stringify({ kind, asked, failed: failed.length, frames: found.frames, places: places.length, above,
                             largest_m: largest, faults }));
process.exit(faults.length ? 1 : 0);
