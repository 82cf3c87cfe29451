/** The address of a tile, as in docs/pack-format.md: level, column from 180° W, row from 90° S. */
export interface TileId {
  level: number;
  x: number;
  y: number;
}

export const MIN_LEVEL = -9;
export const MAX_LEVEL = 20;

export const Layer = { heights: 0, imagery: 1 } as const;
export type LayerNumber = (typeof Layer)[keyof typeof Layer];

export function tilesAround(level: number): number {
  return Math.ceil(360 * 2 ** level);
}

export function tilesPoleToPole(level: number): number {
  return Math.ceil(180 * 2 ** level);
}

/** Bit i of a number below 2^15 becomes bit 2i. */
function spread(value: number): number {
  let v = value & 0x7fff;
  v = (v | (v << 8)) & 0x00ff00ff;
  v = (v | (v << 4)) & 0x0f0f0f0f;
  v = (v | (v << 2)) & 0x33333333;
  return (v | (v << 1)) & 0x55555555;
}

/** What the index is sorted by. */
export function keyOf(layer: LayerNumber, id: TileId): bigint {
  const first = ((1n << BigInt(2 * (id.level - MIN_LEVEL))) - 1n) / 3n;
  const low = spread(id.x) | (spread(id.y) << 1);
  const high = spread(id.x >>> 15) | (spread(id.y >>> 15) << 1);
  return (BigInt(layer) << 59n) + first + (BigInt(high) << 30n) + BigInt(low);
}

/** The number of keys of a level: all from keyOf(layer, {level, 0, 0}) on. */
export function keysOfLevel(level: number): bigint {
  return 1n << BigInt(2 * (level - MIN_LEVEL));
}

function gather(value: bigint): number {
  let out = 0;
  for (let bit = 0n; bit < 30n; ++bit) if ((value >> (2n * bit)) & 1n) out += 2 ** Number(bit);
  return out;
}

/** The tile of a key of this level of a layer. */
export function tileOfKey(layer: LayerNumber, level: number, key: bigint): TileId {
  const place = key - keyOf(layer, { level, x: 0, y: 0 });
  return { level, x: gather(place), y: gather(place >> 1n) };
}

export function parentOf(id: TileId): TileId {
  return { level: id.level - 1, x: id.x >> 1, y: id.y >> 1 };
}

/** The tile of a level that contains a place; on a shared edge the one east and north of it. */
export function tileAt(lon: number, lat: number, level: number): TileId {
  const scale = 2 ** level;
  let east = (lon + 180) % 360;
  if (east < 0) east += 360;
  const x = Math.min(Math.floor(east * scale), tilesAround(level) - 1);
  const y = Math.min(Math.floor((lat + 90) * scale), tilesPoleToPole(level) - 1);
  return { level, x, y };
}
