// Reads a 3D Tiles export with gltf-validator and 3d-tiles-tools and checks it as a whole.
//
// usage: node check_3d_tiles.mjs FOLDER
//   Every tileset file parses, every content is there and once in the tree, no GLB has an error of gltf-validator, errors do
//   not grow downwards, every region holds those below it and every vertex and every object of the contents, and 3d-tiles-tools converts the
//   tileset to one archive.
// Prints one JSON line with what was counted; exits 1 where something is wrong.
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import validator from "gltf-validator";

const folder = process.argv[2];
const faults = [];
const fault = (text) => { if (faults.length < 20) faults.push(text); };
const counts = { tilesets: 0, contents: 0, gltf_errors: 0, gltf_warnings: 0, vertices: 0, objects: 0, outside: 0, deepest: 0 };
const seen = new Set();

/// Longitude, latitude in radians and metres above WGS84 (Bowring 1976, iterated).
function geodetic(x, y, z) {
  const a = 6378137, b = 6356752.314245179, e2 = 1 - (b * b) / (a * a);
  const p = Math.hypot(x, y);
  let lat = Math.atan2(z, p * (1 - e2)), n = a;
  for (let i = 0; i < 6; ++i) {
    n = a / Math.sqrt(1 - e2 * Math.sin(lat) ** 2);
    lat = Math.atan2(z + e2 * n * Math.sin(lat), p);
  }
  const high = Math.abs(Math.cos(lat)) > 0.1 ? p / Math.cos(lat) - n : z / Math.sin(lat) - n * (1 - e2);
  return [Math.atan2(y, x), lat, high];
}

/// Instances have their feet in the chunk of the GLB; the vertices lie beside it, in files that tiles share.
function checkInstances(file, bytes, length, gltf, region) {
  for (const node of gltf.nodes) {
    const { TRANSLATION, ROTATION, SCALE } = node.extensions.EXT_mesh_gpu_instancing.attributes;
    const at = (number) => gltf.accessors[number];
    if (at(TRANSLATION).count !== at(ROTATION).count || at(TRANSLATION).count !== at(SCALE).count) fault(`${file}: counts of attributes`);
    const start = 20 + length + 8 + (gltf.bufferViews[at(TRANSLATION).bufferView].byteOffset ?? 0);
    for (let i = 0; i < at(TRANSLATION).count; ++i) {
      const [x, y, z] = node.translation.map((t, k) => t + bytes.readFloatLE(start + 12 * i + 4 * k));
      const [lon, lat, high] = geodetic(x, -z, y);
      ++counts.objects;
      const inside = lon >= region[0] - 1e-7 && lon <= region[2] + 1e-7 && lat >= region[1] - 1e-7 && lat <= region[3] + 1e-7 &&
        high >= region[4] - 0.5 && high <= region[5] + 0.5;
      if (!inside && ++counts.outside < 5) fault(`${file}: an object at ${lon} ${lat} ${high} outside ${region}`);
    }
  }
}

function checkVertices(file, region) {
  const bytes = fs.readFileSync(file);
  const length = bytes.readUInt32LE(12), gltf = JSON.parse(bytes.subarray(20, 20 + length).toString());
  if (gltf.extensionsUsed) return checkInstances(file, bytes, length, gltf, region);
  const accessor = gltf.accessors[gltf.meshes[0].primitives[0].attributes.POSITION];
  const start = 20 + length + 8 + (gltf.bufferViews[accessor.bufferView].byteOffset ?? 0);
  const [tx, ty, tz] = gltf.nodes[0].translation ?? [0, 0, 0];
  for (let i = 0; i < accessor.count; ++i) {
    const at = start + 12 * i;
    const x = bytes.readFloatLE(at) + tx, y = bytes.readFloatLE(at + 4) + ty, z = bytes.readFloatLE(at + 8) + tz;
    const [lon, lat, high] = geodetic(x, -z, y); // 3D Tiles turns glTF's y axis up
    ++counts.vertices;
    const turned = lon < region[0] - 1e-6 ? lon + 2 * Math.PI : lon;
    const inside = (turned >= region[0] - 1e-7 || Math.abs(lat) > 1.57) && (turned <= region[2] + 1e-7 || Math.abs(lat) > 1.57) &&
      lat >= region[1] - 1e-7 && lat <= region[3] + 1e-7 && high >= region[4] - 0.5 && high <= region[5] + 0.5;
    if (!inside && ++counts.outside < 5) fault(`${file}: a vertex at ${turned} ${lat} ${high} outside ${region}`);
  }
}

async function walk(file, error, outer) {
  ++counts.tilesets;
  const tileset = JSON.parse(fs.readFileSync(file));
  if (tileset.asset.version !== "1.1") fault(`${file}: version ${tileset.asset.version}`);
  const visit = async (node, above, around, depth) => {
    counts.deepest = Math.max(counts.deepest, depth);
    const region = node.boundingVolume.region;
    if (!(node.geometricError >= 0) || node.geometricError > above + 1e-9) fault(`${file}: error ${node.geometricError} below ${above}`);
    if (around && !(region[0] >= around[0] - 1e-9 && region[1] >= around[1] - 1e-9 && region[2] <= around[2] + 1e-9 &&
                    region[3] <= around[3] + 1e-9 && region[4] >= around[4] - 1e-6 && region[5] <= around[5] + 1e-6))
      fault(`${file}: a region outside the one above`);
    if (node.content) {
      const content = path.normalize(path.join(path.dirname(file), node.content.uri));
      if (seen.has(content)) fault(`${content}: twice in the tree`);
      seen.add(content);
      if (!fs.existsSync(content)) { fault(`${content}: is not there`); return; }
      if (content.endsWith(".json")) await walk(content, node.geometricError, region);
      else {
        ++counts.contents;
        const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(content)), {
          externalResourceFunction: async (uri) => new Uint8Array(fs.readFileSync(path.join(path.dirname(content), decodeURIComponent(uri)))),
        });
        counts.gltf_errors += report.issues.numErrors;
        counts.gltf_warnings += report.issues.numWarnings;
        if (report.issues.numErrors) fault(`${content}: ${JSON.stringify(report.issues.messages[0])}`);
        checkVertices(content, region);
      }
    }
    for (const child of node.children ?? []) await visit(child, node.geometricError, region, depth + 1);
  };
  await visit(tileset.root, Math.min(error, tileset.geometricError), outer, 0);
}

await walk(path.join(folder, "tileset.json"), Infinity, null);
const there = fs.readdirSync(folder, { recursive: true }).filter((f) => f.endsWith(".glb")).length;
if (there !== counts.contents) fault(`${there} contents in the folder, ${counts.contents} in the tree`);
const tools = path.join(path.dirname(new URL(import.meta.url).pathname), "node_modules/.bin/3d-tiles-tools");
const archive = path.join(fs.mkdtempSync(path.join(os.tmpdir(), "cairn-3tz-")), "all.3tz");
try {
  execFileSync(tools, ["convert", "-i", path.join(folder, "tileset.json"), "-o", archive, "-f"], { stdio: "pipe" });
  counts.archive_bytes = fs.statSync(archive).size;
} catch (error) { fault(`3d-tiles-tools: ${error.stderr ?? error}`); }
fs.rmSync(path.dirname(archive), { recursive: true, force: true });
console.log(JSON.stringify({ ...counts, faults }));
process.exit(faults.length ? 1 : 0);
