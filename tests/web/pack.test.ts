// What @cairn/pack reads, against `cairn sample` and `cairn extract`; damaged packs; servers that misbehave.
// Environment: CAIRN, the program; CAIRN_WASM, the folder of the modules; CAIRN_PACK, a pack with heights and imagery.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";
import { BlobSource, Decoder, hasSimd, heightAt, HttpSource, Layer, Pack, PackError } from "../../runtime/web/pack/index.js";

const cairn = process.env.CAIRN!;
const packPath = process.env.CAIRN_PACK!;
const folder = mkdtempSync(join(tmpdir(), "cairn-web-"));
after(() => rmSync(folder, { recursive: true }));

const decoder = await Decoder.create(readFileSync(join(process.env.CAIRN_WASM!, "cairn-pack-simd.wasm")));
const portable = await Decoder.create(readFileSync(join(process.env.CAIRN_WASM!, "cairn-pack.wasm")));
const bytes = readFileSync(packPath);

function open(data: Uint8Array = bytes, with_: Decoder = decoder): Promise<Pack> {
  return Pack.open(new BlobSource(new Blob([data as Uint8Array<ArrayBuffer>]), "test.cairn"), with_);
}

/** A sequence of numbers from 0 to 1, equal in each run. */
function dice(seed: number): () => number {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

async function everyEntry(pack: Pack) {
  const out = [];
  for (const { layer, level } of pack.levels)
    if (layer === Layer.heights || layer === Layer.imagery) out.push(...(await pack.entriesOfLevel(layer, level, 1e6)));
  return out;
}

async function readAll(pack: Pack): Promise<void> {
  for (const entry of await everyEntry(pack)) {
    if (entry.layer === Layer.heights) await pack.readHeights(entry);
    else if (!entry.constant) await pack.readTexture(entry);
  }
}

test("this engine has SIMD", () => assert.ok(hasSimd()));

test("header, levels and metadata are those of cairn info", async () => {
  const pack = await open();
  const info = JSON.parse(execFileSync(cairn, ["info", packPath, "--json"], { encoding: "utf8" }));
  assert.ok(JSON.stringify(info).includes(pack.header.id));
  assert.equal(pack.header.body, "Earth");
  const entries = await everyEntry(pack);
  const expected = pack.levels.filter((l) => l.layer <= 1).reduce((sum, l) => sum + l.tiles, 0);
  assert.equal(entries.length, expected);
  for (const entry of entries) {
    const found = await pack.find(entry.layer, entry.id);
    assert.deepEqual(found, entry);
  }
});

test("heights at 1,000 places equal those of cairn sample bit for bit", async () => {
  const random = dice(7);
  const pack = await open();
  const b = pack.metadata.bounds as { west: number; south: number; east: number; north: number };
  const places: [number, number][] = [];
  for (let i = 0; i < 800; ++i)
    places.push([
      b.west - 0.1 + random() * (b.east - b.west + 0.2),
      Math.max(-90, Math.min(90, b.south - 0.1 + random() * (b.north - b.south + 0.2))),
    ]);
  // On samples, on tiles' edges and corners, and with turns of the Earth.
  const snapTo = (value: number, steps: number) => Math.round(value * steps) / steps;
  for (let i = 0; i < 100; ++i) {
    const [lon, lat] = places[i]!;
    places.push([snapTo(lon, 512), snapTo(lat, 2)], [snapTo(lon, 4) + 360, snapTo(lat, 4)]);
  }
  const table = "lon,lat\n" + places.map(([lon, lat]) => `${lon},${lat}\n`).join("");
  const printed = execFileSync(cairn, ["sample", packPath, "--points", "-", "--json"], { input: table, encoding: "utf8", maxBuffer: 1 << 26 });
  const expected = JSON.parse(printed) as { height: number | null; level: number | null }[];
  assert.equal(expected.length, 1000);
  let found = 0;
  for (const [i, [lon, lat]] of places.entries()) {
    const height = await heightAt(pack, lon, lat);
    assert.equal(height?.metres ?? null, expected[i]!.height, `${lon} ${lat}`);
    assert.equal(height?.level ?? null, expected[i]!.level);
    if (height) ++found;
  }
  assert.ok(found > 300, `${found} of the places have heights`);
});

test("both modules decode every tile alike", async () => {
  const [a, b] = [await open(), await open(bytes, portable)];
  for (const entry of await everyEntry(a)) {
    if (entry.layer !== Layer.heights) continue;
    const [one, other] = [await a.readHeights(entry), await b.readHeights(entry)];
    assert.deepEqual(one, other);
    let low = Infinity;
    for (const [i, sample] of one.samples.entries()) if (!one.voids || one.voids[i] === 0) low = Math.min(low, sample);
    if (low !== Infinity) assert.equal(low, entry.minimum);
  }
});

test("textures are the blocks of cairn extract", async () => {
  const pack = await open();
  const entries = (await everyEntry(pack)).filter((e) => e.layer === Layer.imagery && !e.constant);
  for (const entry of entries.slice(0, 5).concat(entries.slice(-5))) {
    const file = join(folder, "tile.dds");
    rmSync(file, { force: true });
    const { level, x, y } = entry.id;
    execFileSync(cairn, ["extract", packPath, `${level}/${x}/${y}`, "-o", file, "--layer", "imagery"]);
    const texture = await pack.readTexture(entry);
    const dds = readFileSync(file);
    const texels = Buffer.concat(texture.mips);
    assert.ok(dds.subarray(dds.length - texels.length).equals(texels));
    const rgba = decoder.decodeImage(texture.format, texture.mips[0]!, texture.size, texture.size);
    assert.equal(rgba.length, 4 * texture.size * texture.size);
  }
});

test("a pack that is cut short is an error that says so", async () => {
  const random = dice(11);
  const lengths = [0, 1, 255, 256, 16383, 16384, bytes.length - 1];
  for (let i = 0; i < 100; ++i) lengths.push(Math.floor(random() * bytes.length));
  for (const length of lengths)
    await assert.rejects(open(bytes.subarray(0, length)), (error) => error instanceof PackError && error.kind === "damaged" && error.message.startsWith("test.cairn: "));
  await assert.rejects(open(Buffer.concat([bytes, Buffer.from([0])])), PackError);
});

test("each flipped bit is found before its bytes are used", async () => {
  const random = dice(13);
  const header = JSON.parse(JSON.stringify((await open()).header)) as { indexOffset: number };
  const places: number[] = [];
  for (let i = 0; i < 60; ++i) places.push(Math.floor(random() * 16384)); // header and root
  for (let i = 0; i < 60; ++i) places.push(header.indexOffset + Math.floor(random() * (bytes.length - header.indexOffset)));
  for (let i = 0; i < 20; ++i) places.push(16384 + Math.floor(random() * (header.indexOffset - 16384)));
  for (const place of places) {
    const copy = Buffer.from(bytes);
    copy[place]! ^= 1 << Math.floor(random() * 8);
    // A block of the rqt layer is not read here.
    await assert.rejects(
      open(copy).then(readAll),
      (error) => error instanceof PackError && error.kind === "damaged",
      `byte ${place}`,
    );
  }
});

// --- Servers. ---

type Answer = (offset: number, last: number, n: number) => Response;

function ranged(data: Uint8Array, etag = '"a"'): Answer {
  return (offset, last) =>
    new Response(data.slice(offset, last + 1), {
      status: 206,
      headers: { "Content-Range": `bytes ${offset}-${Math.min(last, data.length - 1)}/${data.length}`, ETag: etag },
    });
}

function source(answer: Answer): HttpSource {
  let n = 0;
  return new HttpSource("http://test/x.cairn", {
    firstPauseS: 0.001,
    fetch: async (_url, init) => {
      const range = /^bytes=(\d+)-(\d+)$/.exec((init!.headers as Record<string, string>).Range!)!;
      return answer(Number(range[1]), Number(range[2]), ++n);
    },
  });
}

const kind = (expected: string) => (error: unknown) => error instanceof PackError && error.kind === expected;

test("ranges that lie near each other are one request", async () => {
  const http = source(ranged(bytes));
  const parts = await Promise.all([http.read(100, 10), http.read(0, 50), http.read(120, 1000), http.read(200000, 5)]);
  assert.deepEqual(parts.map((p) => Buffer.from(p)), [bytes.subarray(100, 110), bytes.subarray(0, 50), bytes.subarray(120, 1120), bytes.subarray(200000, 200005)]);
  assert.equal(http.counts.requests, 2);
});

test("a pack over HTTP is the pack", async () => {
  const http = source(ranged(bytes));
  const pack = await Pack.open(http, decoder);
  assert.equal(http.counts.requests, 2);
  await readAll(pack);
});

test("what may pass is tried again, what cannot is an error at once", async () => {
  const good = ranged(bytes);
  const late = source((o, l, n) => (n < 4 ? new Response("", { status: n === 1 ? 503 : 429 }) : good(o, l, n)));
  assert.equal((await late.read(0, 8)).length, 8);
  assert.equal(late.counts.retries, 3);
  const broken = source((o, l, n) => {
    if (n < 3) throw new TypeError("connection refused");
    return good(o, l, n);
  });
  assert.equal((await broken.read(0, 8)).length, 8);
  const dead = source(() => { throw new TypeError("connection refused"); });
  await assert.rejects(dead.read(0, 8), kind("network"));
  assert.equal(dead.counts.requests, 5);
  const short = source((o, l, n) => (n === 1 ? new Response(bytes.slice(o, o + 3), { status: 206 }) : good(o, l, n)));
  assert.equal((await short.read(0, 8)).length, 8);
  for (const status of [404, 403, 301]) {
    const refused = source(() => new Response("", { status }));
    await assert.rejects(refused.read(0, 8), kind("refused"));
    assert.equal(refused.counts.requests, 1);
  }
  await assert.rejects(source(() => new Response(bytes, { status: 200 })).read(0, 8), kind("refused"));
  await assert.rejects(source(() => new Response(bytes.slice(8, 16), { status: 206, headers: { "Content-Range": `bytes 8-15/${bytes.length}` } })).read(0, 8), kind("refused"));
});

test("a file that is replaced is told, and never mixed", async () => {
  const tagged = source((o, l, n) => ranged(bytes, n < 3 ? '"a"' : '"b"')(o, l, n));
  await Pack.open(tagged, decoder);
  await assert.rejects(tagged.read(20000, 10), kind("replaced"));
  const longer = Buffer.concat([bytes, bytes]);
  const grown = source((o, l, n) => ranged(n < 3 ? bytes : longer, "")(o, l, n));
  await Pack.open(grown, decoder);
  await assert.rejects(grown.read(20000, 10), kind("replaced"));
});

test("a damaged answer is asked for again; a damaged block is an error", async () => {
  const flip = (o: number, l: number, n: number) => {
    const data = Buffer.from(bytes);
    if (n === 3) data[o]! ^= 1;
    return ranged(data)(o, l, n);
  };
  const once = await Pack.open(source(flip), decoder);
  const range = once.levelRange(Layer.heights)!;
  const entry = (await once.entriesOfLevel(Layer.heights, range.finest, 1e6)).find((e) => !e.constant)!;
  await once.readHeights(entry);
  const copy = Buffer.from(bytes);
  copy[entry.offset + 9]! ^= 4;
  const damaged = await Pack.open(source(ranged(copy)), decoder);
  await assert.rejects(damaged.readHeights(entry), kind("damaged"));
});
