// Opens a PMTiles archive with the reader of npm's `pmtiles` and gets every tile.
//
// usage: node check_pmtiles.mjs FILE
// Prints one JSON line; exits 1 where something is wrong.
import fs from "node:fs";
import { PMTiles, zxyToTileId } from "pmtiles";

const file = process.argv[2];
const handle = fs.openSync(file);
const source = {
  getKey: () => file,
  getBytes: async (offset, length) => {
    const data = new ArrayBuffer(length);
    const read = fs.readSync(handle, new Uint8Array(data), 0, length, offset);
    return { data: data.slice(0, read) };
  },
};
const archive = new PMTiles(source);
const header = await archive.getHeader(), metadata = await archive.getMetadata();
const faults = [];
const kinds = { 2: { name: "PNG", head: [0x89, 0x50] }, 4: { name: "WebP", head: [0x52, 0x49] } };
const kind = kinds[header.tileType];
if (!kind) faults.push(`tile type ${header.tileType}`);
if (!(header.minLon < header.maxLon && header.minLat < header.maxLat)) faults.push("bounds without area");
if (header.tileType === 2 && !["terrarium", "custom"].includes(metadata.encoding)) faults.push(`encoding ${metadata.encoding}`);
let tiles = 0, bytes = 0;
for (let z = header.minZoom; z <= header.maxZoom; ++z) {
  const side = 2 ** z, row = (lat) => ((1 - Math.asinh(Math.tan((lat * Math.PI) / 180)) / Math.PI) / 2) * side;
  const column = (lon) => ((lon + 180) / 360) * side;
  for (let x = Math.floor(column(header.minLon)); x < Math.min(side, column(header.maxLon)); ++x)
    for (let y = Math.floor(row(header.maxLat)); y < Math.min(side, row(header.minLat)); ++y) {
      const tile = await archive.getZxy(z, x, y);
      if (!tile) continue;
      ++tiles;
      bytes += tile.data.byteLength;
      const head = new Uint8Array(tile.data, 0, 4);
      if (!kind || head[0] !== kind.head[0] || head[1] !== kind.head[1])
        faults.push(`${z}/${x}/${y} (${zxyToTileId(z, x, y)}): no ${kind?.name}`);
    }
}
if (tiles !== header.numAddressedTiles) faults.push(`${tiles} tiles found, ${header.numAddressedTiles} stated`);
console.log(JSON.stringify({ tiles, bytes, zooms: [header.minZoom, header.maxZoom], faults }));
process.exit(faults.length ? 1 : 0);
