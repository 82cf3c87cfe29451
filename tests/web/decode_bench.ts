// How fast a module decodes a pack's finest height tiles: decode_bench.mjs PACK MODULE.
import { readFileSync } from "node:fs";
import { BlobSource, Decoder, Layer, Pack } from "../../runtime/web/pack/index.js";

const MOST_TILES = 36;
const [path, module] = process.argv.slice(2) as [string, string];
const decoder = await Decoder.create(readFileSync(module));
const pack = await Pack.open(new BlobSource(new Blob([readFileSync(path)]), path), decoder, { cacheBytes: 0 });
const level = pack.levelRange(Layer.heights)!.finest;
const entries = (await pack.entriesOfLevel(Layer.heights, level, 1e6)).filter((entry) => !entry.constant && !entry.hasVoids);
const step = Math.max(1, Math.ceil(entries.length / MOST_TILES));
const blocks: Uint8Array[] = [];
for (let i = 0; i < entries.length; i += step)
  blocks.push((await pack.source.read(entries[i]!.offset, entries[i]!.bytes)).slice());
const size = pack.header.tileSize;
const decodeAll = () => blocks.forEach((block) => decoder.decodeHeights(block, size));
for (let warm = 0; warm < 3; ++warm) decodeAll(); // until the engine has compiled the module for speed
let best = Infinity;
for (let run = 0; run < 5; ++run) {
  const before = process.cpuUsage();
  decodeAll();
  const { user, system } = process.cpuUsage(before);
  best = Math.min(best, (user + system) / 1e6);
}
const gigabytes = (blocks.length * size * size * 2) / 1e9;
console.log(`${module.split("/").pop()}: ${blocks.length} tiles, ${(gigabytes / best).toFixed(2)} GB/s of int16`);
