import type { Entry, TextureTile } from "../pack/index.js";

/** Bytes of a block of 4×4 texels. */
export function blockBytes(format: number): number {
  return format === 1 ? 8 : 16;
}

/** A transparent block, for places without imagery: BC1 with holes, BC3, BC7 of mode 6. */
export function emptyBlock(format: number): Uint8Array {
  const block = new Uint8Array(blockBytes(format));
  if (format === 1) block.fill(0xff, 4);
  if (format === 7) block[0] = 0x40;
  return block;
}

/** The blocks of one colour that is opaque, as a constant tile has it. */
export function colourBlock(format: 1 | 3, rgba: number): Uint8Array {
  const [r, g, b] = [rgba & 255, (rgba >> 8) & 255, (rgba >> 16) & 255];
  const colour = (Math.round((r * 31) / 255) << 11) | (Math.round((g * 63) / 255) << 5) | Math.round((b * 31) / 255);
  const block = new Uint8Array(blockBytes(format));
  const at = format === 1 ? 0 : 8;
  block[at] = block[at + 2] = colour & 255;
  block[at + 1] = block[at + 3] = colour >> 8;
  if (format === 3) block[0] = block[1] = 255;
  return block;
}

/**
 * Turns a BC1 block with four colours into BC3, opaque: its bytes stay as they are. A block with three colours and
 * holes has no counterpart; undefined then.
 */
export function bc1AsBc3(block: Uint8Array): Uint8Array | undefined {
  const [first, second] = [block[0]! | (block[1]! << 8), block[2]! | (block[3]! << 8)];
  const indices = block[4]! | block[5]! | block[6]! | block[7]!;
  if (first <= second && indices !== 0) return undefined;
  const out = new Uint8Array(16);
  out[0] = out[1] = 255;
  out.set(block, 8);
  return out;
}

/** Turns a block of BC1 or BC3 upside down. The blocks of BC7 have no rows. */
export function flipBlock(format: number, block: Uint8Array, out: Uint8Array): void {
  const colours = format === 1 ? 0 : 8;
  out.set(block);
  for (let row = 0; row < 4; ++row) out[colours + 4 + row] = block[colours + 7 - row]!;
  if (format !== 3) return;
  // Alpha has three bits a texel, twelve a row.
  let bits = 0n;
  for (let i = 0; i < 6; ++i) bits |= BigInt(block[2 + i]!) << BigInt(8 * i);
  let flipped = 0n;
  for (let row = 0n; row < 4n; ++row) flipped |= ((bits >> (12n * row)) & 0xfffn) << (12n * (3n - row));
  for (let i = 0; i < 6; ++i) out[2 + i] = Number((flipped >> BigInt(8 * i)) & 255n);
}

/** A tile of imagery where it lies in a window: texels from the window's north-western corner to the tile's. */
export interface PlacedTexture {
  entry: Entry;
  texture: TextureTile | undefined; // undefined for a constant tile
  x: number;
  y: number;
  /** Texels along the tile's side, and which mip has as many. */
  side: number;
  mip: number;
}

/**
 * Copies the blocks of tiles into one image of `side`² texels, rows from the south, as WebGL has them. Returns undefined
 * where blocks of these kinds do not go together.
 */
export function copyBlocks(tiles: PlacedTexture[], side: number): { format: 1 | 3; blocks: Uint8Array } | undefined {
  if (tiles.some((one) => one.texture?.format === 7)) return undefined;
  const format = tiles.some((one) => one.texture?.format === 3) ? 3 : 1;
  const bytes = blockBytes(format);
  const across = side / 4;
  const out = new Uint8Array(across * across * bytes);
  const empty = emptyBlock(format);
  for (let i = 0; i < across * across; ++i) out.set(empty, i * bytes);
  for (const tile of tiles) {
    const from = tile.texture?.format ?? format;
    const blocks = tile.texture?.mips[tile.mip];
    const solid = blocks ? undefined : colourBlock(format, tile.entry.minimum);
    const inTile = tile.side / 4;
    for (let j = 0; j < inTile; ++j) {
      const row = tile.y / 4 + j;
      if (row < 0 || row >= across) continue;
      for (let i = 0; i < inTile; ++i) {
        const column = tile.x / 4 + i;
        if (column < 0 || column >= across) continue;
        const at = (j * inTile + i) * blockBytes(from);
        let block = solid ?? blocks!.subarray(at, at + blockBytes(from));
        if (!solid && from !== format) {
          const turned = bc1AsBc3(block);
          if (!turned) return undefined;
          block = turned;
        }
        const to = ((across - 1 - row) * across + column) * bytes;
        flipBlock(format, block, out.subarray(to, to + bytes));
      }
    }
  }
  return { format, blocks: out };
}
