import type { ByteSource } from "./byte_source.js";
import type { DecodedHeights, Decoder, Page, PageRow } from "./decoder.js";
import { PackError } from "./errors.js";
import { keyOf, keysOfLevel, Layer, type LayerNumber, parentOf, type TileId, tileOfKey } from "./grid.js";
import { Lru } from "./lru.js";

const START_BYTES = 16384;
const HEADER_BYTES = 256;
const LEVEL_BYTES = 32;
const TEXTURE_START_BYTES = 4;
/** An index of at most so many bytes is read whole, with the metadata, when the pack is opened. */
const SMALL_INDEX_BYTES = 128 << 10;
const PAGES_BYTES = 64 << 20;
const READ_TRIES = 3;

const CONSTANT = 1;

export interface PackHeader {
  tileSize: number;
  quantumM: number;
  body: string;
  semiMajorM: number;
  semiMinorM: number;
  verticalDatum: string;
  entries: number;
  indexOffset: number;
  metadataOffset: number;
  metadataBytes: number;
  /** 32 hexadecimal digits, a hash of all bytes of the pack. */
  id: string;
}

/** The sums over one level of a layer. */
export interface PackLevel {
  layer: number;
  level: number;
  /** The largest geometric error of its tiles in metres. */
  errorM: number;
  tiles: number;
}

/** A tile of the index. */
export interface Entry {
  layer: LayerNumber;
  id: TileId;
  /** Whether all samples are `minimum`, or all texels that colour; there is no block then. */
  constant: boolean;
  hasVoids: boolean;
  hasAlpha: boolean;
  offset: number;
  bytes: number;
  checksum: Uint8Array;
  /** Of heights in quanta; of imagery a colour as RGBA bytes. */
  minimum: number;
  maximum: number;
  /** Of heights: no source post is farther from the tile's surface, in metres. */
  errorM: number;
}

/** Heights of a tile, by row from the south. */
export interface HeightTile extends DecodedHeights {
  id: TileId;
  size: number;
}

/** A texture as a pack stores it: mips of blocks of 4×4 texels, the largest first, rows from the north. */
export interface TextureTile {
  id: TileId;
  /** Texels along a side of the largest mip. */
  size: number;
  /** BC1, BC3 or BC7, sRGB. */
  format: 1 | 3 | 7;
  mips: Uint8Array[];
}

export interface PackOptions {
  /** Of decoded tiles that are kept, in bytes. */
  cacheBytes?: number;
}

interface PageRef {
  offset: number;
  bytes: number;
  checksum: Uint8Array;
}

/**
 * An open pack. Every part that is read is compared with its checksum in the part that leads to it; one that is wrong
 * is read twice more, past any cache, before it is an error.
 */
export class Pack {
  readonly levels: PackLevel[] = [];
  /** JSON of docs/pack-format.md. */
  metadata: Record<string, unknown> = {};
  private readonly pages = new Lru<number, Promise<Page>>(PAGES_BYTES);
  private readonly tiles: Lru<string, Promise<HeightTile | TextureTile>>;
  private small: { offset: number; bytes: Uint8Array } | undefined;

  private constructor(
    readonly source: ByteSource,
    readonly decoder: Decoder,
    readonly header: PackHeader,
    private readonly root: Page,
    cacheBytes: number,
  ) {
    this.tiles = new Lru(cacheBytes);
  }

  /** Opens a pack with two reads: header and root; then the metadata, and with it the index where that is small. */
  static async open(source: ByteSource, decoder: Decoder, options: PackOptions = {}): Promise<Pack> {
    const start = await source.read(0, START_BYTES);
    const size = await source.size();
    damagedIf(source.name, () => decoder.checkStart(start));
    const header = readHeader(start);
    const end = header.metadataOffset + header.metadataBytes;
    if (size !== undefined && size !== end)
      throw new PackError("damaged", `${source.name}: expected ${end} bytes, found ${size}`);
    const view = new DataView(start.buffer, start.byteOffset);
    const levelCount = view.getUint32(HEADER_BYTES, true);
    const rootBytes = view.getUint32(152, true);
    const pageAt = HEADER_BYTES + 4 + levelCount * LEVEL_BYTES;
    const root = damagedIf(source.name, () => decoder.decodePage(start.subarray(pageAt, HEADER_BYTES + rootBytes)));
    const pack = new Pack(source, decoder, header, root, options.cacheBytes ?? 192 << 20);
    for (let i = 0; i < levelCount; ++i) {
      const at = HEADER_BYTES + 4 + i * LEVEL_BYTES;
      pack.levels.push({
        layer: view.getUint8(at),
        level: view.getInt8(at + 1),
        errorM: view.getFloat32(at + 4, true),
        tiles: Number(view.getBigUint64(at + 8, true)),
      });
    }
    await pack.readTail(view);
    return pack;
  }

  /** Reads the metadata, and the pages where they are few. */
  private async readTail(start: DataView): Promise<void> {
    const { indexOffset, metadataOffset, metadataBytes } = this.header;
    const isSmall = metadataOffset - indexOffset <= SMALL_INDEX_BYTES;
    const from = isSmall ? indexOffset : metadataOffset;
    const sum = new Uint8Array(start.buffer, start.byteOffset + 144, 8);
    const tail = await this.source.read(from, metadataOffset + metadataBytes - from);
    let text = tail.subarray(metadataOffset - from);
    if (!this.decoder.hasChecksum(text, sum))
      text = await this.readChecked({ offset: metadataOffset, bytes: metadataBytes, checksum: sum }, "metadata");
    this.metadata = damagedIf(this.source.name, () => JSON.parse(new TextDecoder().decode(text)));
    if (isSmall) this.small = { offset: indexOffset, bytes: tail };
  }

  /** The coarsest and finest level of a layer; undefined where the pack has none of it. */
  levelRange(layer: LayerNumber): { coarsest: number; finest: number } | undefined {
    const levels = this.levels.filter((one) => one.layer === layer).map((one) => one.level);
    return levels.length === 0 ? undefined : { coarsest: levels[0]!, finest: levels[levels.length - 1]! };
  }

  /** The largest geometric error of a level of heights in metres; undefined where it has no tile. */
  levelErrorM(level: number): number | undefined {
    return this.levels.find((one) => one.layer === Layer.heights && one.level === level)?.errorM;
  }

  /** Returns the tile's entry, undefined where the layer has none. */
  async find(layer: LayerNumber, id: TileId): Promise<Entry | undefined> {
    const range = this.levelRange(layer);
    if (!range || id.level < range.coarsest || id.level > range.finest) return undefined;
    const key = keyOf(layer, id);
    let page = this.root;
    for (;;) {
      const at = rowOf(page, key);
      if (at < 0) return undefined;
      const row = page.rows[at]!;
      if (page.height === 0) return row.key === key ? entryOf(layer, id, row) : undefined;
      page = await this.page(row);
    }
  }

  /** Returns the entry of the tile or of its nearest ancestor. */
  async findNearest(layer: LayerNumber, id: TileId): Promise<Entry | undefined> {
    const range = this.levelRange(layer);
    if (!range) return undefined;
    for (let at = id; at.level >= range.coarsest; at = parentOf(at)) {
      const entry = await this.find(layer, at);
      if (entry) return entry;
      if (at.level === range.coarsest) return undefined;
    }
    return undefined;
  }

  /** Returns the entries of a level, the first `most` of them. */
  async entriesOfLevel(layer: LayerNumber, level: number, most: number): Promise<Entry[]> {
    const first = keyOf(layer, { level, x: 0, y: 0 });
    const end = first + keysOfLevel(level);
    const out: Entry[] = [];
    const visit = async (page: Page): Promise<void> => {
      for (let at = Math.max(rowOf(page, first), 0); at < page.rows.length && out.length < most; ++at) {
        const row = page.rows[at]!;
        if (row.key >= end) return;
        if (page.height > 0) await visit(await this.page(row));
        else if (row.key >= first) out.push(entryOf(layer, tileOfKey(layer, level, row.key), row));
      }
    };
    await visit(this.root);
    return out;
  }

  async readHeights(entry: Entry): Promise<HeightTile> {
    const size = this.header.tileSize;
    return this.cached(entry, 4 * size * size, async () => {
      if (entry.constant) return { id: entry.id, size, samples: new Int32Array(size * size).fill(entry.minimum) };
      const block = await this.readChecked(entry, placeOf(entry));
      return { id: entry.id, size, ...damagedIf(this.source.name, () => this.decoder.decodeHeights(block, size)) };
    }) as Promise<HeightTile>;
  }

  /** REQUIRES: the entry is not constant. */
  async readTexture(entry: Entry): Promise<TextureTile> {
    const size = this.header.tileSize - 1;
    return this.cached(entry, (size * size * 4) / 3, async () => {
      const block = await this.readChecked(entry, placeOf(entry));
      return damagedIf(this.source.name, () => decodeTexture(this.decoder, block, entry.id, size));
    }) as Promise<TextureTile>;
  }

  private cached(
    entry: Entry,
    bytes: number,
    make: () => Promise<HeightTile | TextureTile>,
  ): Promise<HeightTile | TextureTile> {
    const name = placeOf(entry);
    const known = this.tiles.get(name);
    if (known) return known;
    const made = make();
    this.tiles.set(name, made, bytes);
    made.catch(() => this.tiles.delete(name)); // another try may succeed
    return made;
  }

  private page(row: PageRow): Promise<Page> {
    const known = this.pages.get(row.offset);
    if (known) return known;
    const made = this.readChecked(row, `page at ${row.offset}`).then((bytes) =>
      damagedIf(this.source.name, () => this.decoder.decodePage(bytes)),
    );
    this.pages.set(row.offset, made, 1024 * 200);
    made.catch(() => this.pages.delete(row.offset));
    return made;
  }

  /** Returns bytes with their checksum; after wrong ones it asks past caches, and whether the file is another one. */
  private async readChecked(part: PageRef, place: string): Promise<Uint8Array> {
    const { offset, bytes, checksum } = part;
    if (this.small && offset >= this.small.offset && offset + bytes <= this.small.offset + this.small.bytes.length) {
      const at = offset - this.small.offset;
      const kept = this.small.bytes.subarray(at, at + bytes);
      if (this.decoder.hasChecksum(kept, checksum)) return kept;
    }
    for (let attempt = 0; attempt < READ_TRIES; ++attempt) {
      const read = await this.source.read(offset, bytes, attempt > 0);
      if (this.decoder.hasChecksum(read, checksum)) return read;
      await this.refuseAnother();
    }
    throw new PackError("damaged", `${this.source.name}: ${place}: expected its checksum, found another`);
  }

  /** Throws where the file's header is no longer that of this pack. */
  private async refuseAnother(): Promise<void> {
    const start = await this.source.read(0, START_BYTES, true);
    if (readHeader(start).id !== this.header.id)
      throw new PackError("replaced", `${this.source.name}: the file is another pack now`);
  }
}

/** Makes an error about the bytes one about the pack. */
function damagedIf<T>(name: string, use: () => T): T {
  try {
    return use();
  } catch (error) {
    throw new PackError("damaged", `${name}: ${error instanceof Error ? error.message : String(error)}`);
  }
}

function placeOf(entry: Entry): string {
  return `${entry.layer === Layer.heights ? "heights" : "imagery"} ${entry.id.level}/${entry.id.x}/${entry.id.y}`;
}

/** The last row whose key is not above, -1 where there is none. */
function rowOf(page: Page, key: bigint): number {
  let low = 0;
  let high = page.keys.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (page.keys[middle]! <= key) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

function entryOf(layer: LayerNumber, id: TileId, row: PageRow): Entry {
  return {
    layer,
    id,
    constant: (row.flags & CONSTANT) !== 0,
    hasVoids: (row.flags & 2) !== 0,
    hasAlpha: (row.flags & 4) !== 0,
    offset: row.offset,
    bytes: row.bytes,
    checksum: row.checksum,
    minimum: row.minimum,
    maximum: row.maximum,
    errorM: row.errorM,
  };
}

/** Reads the fields of a header. It is meaningful only after Decoder.checkStart(). */
function readHeader(start: Uint8Array): PackHeader {
  const view = new DataView(start.buffer, start.byteOffset, HEADER_BYTES);
  const number = (at: number) => Number(view.getBigUint64(at, true));
  const text = (at: number, bytes: number) =>
    new TextDecoder().decode(start.slice(at, at + bytes)).replace(/\0.*$/s, "");
  return {
    tileSize: view.getUint16(10, true),
    quantumM: view.getFloat64(16, true),
    body: text(24, 32),
    semiMajorM: view.getFloat64(56, true),
    semiMinorM: view.getFloat64(64, true),
    verticalDatum: text(72, 40),
    entries: number(112),
    indexOffset: number(120),
    metadataOffset: number(128),
    metadataBytes: number(136),
    id: Array.from(start.subarray(224, 240), (byte) => byte.toString(16).padStart(2, "0")).join(""),
  };
}

/** Bytes of an image of blocks. */
export function imageBytes(format: number, side: number): number {
  return Math.ceil(side / 4) ** 2 * (format === 1 ? 8 : 16);
}

function decodeTexture(decoder: Decoder, block: Uint8Array, id: TileId, size: number): TextureTile {
  const format = block[0];
  if (block.length < TEXTURE_START_BYTES || (format !== 1 && format !== 3 && format !== 7))
    throw new RangeError(`texture block: format: expected 1, 3 or 7, found ${format}`);
  if (block[1] !== 0 || block[2] !== 0 || block[3] !== 0)
    throw new RangeError("texture block: expected 0 in the reserved bytes, found others");
  const sides: number[] = [];
  for (let side = size; side > 0; side = side >> 1) sides.push(side);
  const total = sides.reduce((sum, side) => sum + imageBytes(format, side), 0);
  const texels = decoder.decodeFrame(block.subarray(TEXTURE_START_BYTES), total);
  let at = 0;
  const mips = sides.map((side) => texels.subarray(at, (at += imageBytes(format, side))));
  return { id, size, format, mips };
}
