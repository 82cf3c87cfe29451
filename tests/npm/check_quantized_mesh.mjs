// Reads a quantized-mesh export with @here/quantized-mesh-decoder and checks it as a whole.
//
// usage: node check_quantized_mesh.mjs FOLDER [FILE.hgt ...]
//   Every tile decodes, layer.json lists exactly the tiles that there are, edges lie on 0 and 32767, tiles of one level have
//   the same vertices, heights and normals on common edges, and the stated error is at most what clients take for a level's.
//   FILE.hgt: a cell of source posts above the exported datum. Every post is measured in every tile that covers it: none may
//   be farther from the mesh than the tile states.
// Prints one JSON line with what was counted; exits 1 where something is wrong.
import fs from "node:fs";
import path from "node:path";
import { createRequire } from "node:module";
const require = createRequire(import.meta.url);
const decoder = require("@here/quantized-mesh-decoder");
const decode = decoder.default ?? decoder;

const LARGEST = 32767;
const ROOT_ERROR = 77067.34;
const faults = [];
const fault = (text) => { if (faults.length < 20) faults.push(text); };

function readTile(folder, level, x, y) {
  const bytes = fs.readFileSync(path.join(folder, `${level}/${x}/${y}.terrain`));
  const tile = decode(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
  const count = tile.vertexData.length / 3;
  const { minHeight, maxHeight } = tile.header;
  const vertices = { count, u: tile.vertexData.subarray(0, count), v: tile.vertexData.subarray(count, 2 * count) };
  vertices.metres = Float64Array.from(tile.vertexData.subarray(2 * count),
                                      (q) => minHeight + (q * (maxHeight - minHeight)) / LARGEST);
  return { level, x, y, name: `${level}/${x}/${y}`, tile, vertices, width: 180 / 2 ** level,
           error: tile.extensions.metadata?.geometricerror };
}

function listTiles(folder) {
  const tiles = [];
  for (const level of fs.readdirSync(folder).filter((n) => /^\d+$/.test(n)).map(Number).sort((a, b) => a - b))
    for (const x of fs.readdirSync(path.join(folder, `${level}`)).map(Number).sort((a, b) => a - b))
      for (const y of fs.readdirSync(path.join(folder, `${level}/${x}`)).map((n) => parseInt(n)).sort((a, b) => a - b))
        tiles.push([level, x, y]);
  return tiles;
}

function checkAvailable(layer, tiles) {
  const there = new Set(tiles.map((t) => t.join("/")));
  let stated = 0;
  layer.available.forEach((ranges, level) => {
    for (const r of ranges)
      for (let x = r.startX; x <= r.endX; ++x)
        for (let y = r.startY; y <= r.endY; ++y) {
          ++stated;
          if (!there.has(`${level}/${x}/${y}`)) fault(`available: ${level}/${x}/${y} is stated and not there`);
        }
  });
  if (stated !== there.size) fault(`available: ${stated} tiles stated, ${there.size} there`);
  for (const [level, x, y] of tiles)
    if (level > 0 && !there.has(`${level - 1}/${x >> 1}/${y >> 1}`)) fault(`${level}/${x}/${y}: no parent`);
  for (const x of [0, 1]) if (!there.has(`0/${x}/0`)) fault(`0/${x}/0: no root`);
}

function checkHeader(t) {
  for (const [key, value] of Object.entries(t.tile.header)) if (!Number.isFinite(value)) fault(`${t.name}: ${key} is ${value}`);
  if (!(t.error <= ROOT_ERROR / 2 ** t.level)) fault(`${t.name}: error ${t.error} above the level's`);
  const { u, v, count } = t.vertices;
  const isOn = { west: u, south: v, east: u, north: v };
  for (const side of ["west", "south", "east", "north"]) {
    const value = side === "west" || side === "south" ? 0 : LARGEST;
    const listed = new Set(t.tile[`${side}Indices`]);
    for (let i = 0; i < count; ++i)
      if ((isOn[side][i] === value) !== listed.has(i)) fault(`${t.name}: vertex ${i} and the list of the ${side} edge`);
  }
  const corners = new Set();
  for (let i = 0; i < count; ++i) if (u[i] % LARGEST === 0 && v[i] % LARGEST === 0) corners.add(`${u[i]} ${v[i]}`);
  if (corners.size !== 4) fault(`${t.name}: ${corners.size} corners`);
  if (t.tile.extensions.vertexNormals?.length !== 2 * count) fault(`${t.name}: normals`);
}

/// The vertices of an edge as text: where, how high, and the normal.
function edgeText(t, side) {
  const along = side === "west" || side === "east" ? t.vertices.v : t.vertices.u;
  const normals = t.tile.extensions.vertexNormals;
  return [...t.tile[`${side}Indices`]].sort((a, b) => along[a] - along[b])
    .map((i) => `${along[i]}:${t.vertices.metres[i]}:${normals[2 * i]},${normals[2 * i + 1]}`).join(" ");
}

function readHgt(file) {
  const name = /([NS])(\d\d)([EW])(\d\d\d)/.exec(path.basename(file));
  const bytes = fs.readFileSync(file);
  const size = Math.sqrt(bytes.length / 2);
  return { south: (name[1] === "N" ? 1 : -1) * +name[2], west: (name[3] === "E" ? 1 : -1) * +name[4], size,
           at: (column, rowFromSouth) => bytes.readInt16BE(2 * ((size - 1 - rowFromSouth) * size + column)) };
}

/// Every post of the cell that lies in the tile, by the triangle that has it.
function measure(t, cell, sums) {
  const west = t.x * t.width - 180, south = t.y * t.width - 90, per = cell.size - 1;
  const { u, v, metres } = t.vertices;
  const range = (low, high, origin) => [Math.max(0, Math.ceil((low - origin) * per - 1e-7)),
                                        Math.min(per, Math.floor((high - origin) * per + 1e-7))];
  const [c0, c1] = range(west, west + t.width, cell.west), [r0, r1] = range(south, south + t.width, cell.south);
  if (c0 > c1 || r0 > r1) return;
  const seen = new Uint8Array((c1 - c0 + 1) * (r1 - r0 + 1));
  const x = (i) => (west + (t.width * u[i]) / LARGEST - cell.west) * per;
  const y = (i) => (south + (t.width * v[i]) / LARGEST - cell.south) * per;
  const index = t.tile.triangleIndices;
  for (let k = 0; k < index.length; k += 3) {
    const [a, b, c] = [index[k], index[k + 1], index[k + 2]];
    const xs = [x(a), x(b), x(c)], ys = [y(a), y(b), y(c)];
    const area = (xs[1] - xs[0]) * (ys[2] - ys[0]) - (xs[2] - xs[0]) * (ys[1] - ys[0]);
    if (area < 0) ++sums.turned;
    if (!(area > 0)) continue;
    const top = Math.min(r1, Math.floor(Math.max(...ys) + 1e-7)), right = Math.min(c1, Math.floor(Math.max(...xs) + 1e-7));
    for (let r = Math.max(r0, Math.ceil(Math.min(...ys) - 1e-7)); r <= top; ++r)
      for (let q = Math.max(c0, Math.ceil(Math.min(...xs) - 1e-7)); q <= right; ++q) {
        const wb = ((q - xs[0]) * (ys[2] - ys[0]) - (xs[2] - xs[0]) * (r - ys[0])) / area;
        const wc = ((xs[1] - xs[0]) * (r - ys[0]) - (q - xs[0]) * (ys[1] - ys[0])) / area;
        if (wb < -1e-9 || wc < -1e-9 || wb + wc > 1 + 1e-9) continue;
        const post = cell.at(q, r);
        seen[(r - r0) * (c1 - c0 + 1) + q - c0] = 1;
        if (post <= -9999) continue;
        const off = Math.abs(metres[a] + wb * (metres[b] - metres[a]) + wc * (metres[c] - metres[a]) - post);
        ++sums.measured;
        const level = (sums.levels[t.level] ??= { largest: 0, share: 0 });
        level.largest = Math.max(level.largest, off);
        level.share = Math.max(level.share, off / t.error);
        if (off > t.error) { ++sums.above; fault(`${t.name}: post ${q} ${r}: ${off} m off, stated ${t.error}`); }
      }
  }
  sums.missed += seen.reduce((n, s) => n + (s ? 0 : 1), 0);
}

const [folder, ...files] = process.argv.slice(2);
const layer = JSON.parse(fs.readFileSync(path.join(folder, "layer.json")));
const tiles = listTiles(folder), cells = files.map(readHgt);
checkAvailable(layer, tiles);
const sums = { tiles: tiles.length, edge_pairs: 0, unlike_pairs: 0, measured: 0, missed: 0, above: 0, turned: 0, levels: {} };
let east = new Map(), north = new Map(), now = -1, west = new Map();
const pair = (a, b, where) => {
  ++sums.edge_pairs;
  if (a !== b) { ++sums.unlike_pairs; fault(`${where}: the edges of two tiles differ:\n  ${a}\n  ${b}`); }
};
for (const [level, x, y] of tiles) {
  if (level !== now) { now = level; east = new Map(); north = new Map(); west = new Map(); }
  const t = readTile(folder, level, x, y);
  checkHeader(t);
  const around = 2 ** (level + 1);
  if (x === 0) west.set(y, edgeText(t, "west"));
  if (east.has(`${x - 1}/${y}`)) pair(east.get(`${x - 1}/${y}`), edgeText(t, "west"), `${t.name} west`);
  if (x === around - 1 && west.has(y)) pair(edgeText(t, "east"), west.get(y), `${t.name} over the antimeridian`);
  if (north.has(`${x}/${y - 1}`)) pair(north.get(`${x}/${y - 1}`), edgeText(t, "south"), `${t.name} south`);
  east.set(`${x}/${y}`, edgeText(t, "east"));
  north.set(`${x}/${y}`, edgeText(t, "north"));
  for (const cell of cells) measure(t, cell, sums);
}
if (sums.missed > 0) fault(`${sums.missed} posts are in no triangle of a tile that has them`);
console.log(JSON.stringify({ ...sums, faults }, null, 1));
process.exit(faults.length ? 1 : 0);
