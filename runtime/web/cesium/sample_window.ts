import { type Entry, type HeightTile, Layer, Pack, tilesPoleToPole, tilesAround } from "../pack/index.js";

/** A square of samples of the lattice of one level, in metres; NaN where the pack has none. */
export interface SampleWindow {
  metres: Float64Array;
  /** Samples along a side. */
  side: number;
  /** Whether any sample is there. */
  hasData: boolean;
}

/** Which samples: columns from 180° W and rows from 90° S of a level's lattice, each `stride` apart. */
export interface WindowPlace {
  level: number;
  column: number;
  row: number;
  side: number;
  stride: number;
}

/**
 * Reads a window. Where the level has no tile, the samples are those of the nearest ancestor's surface, bilinear.
 * `within` are the only tiles to look at where the caller knows them.
 */
export async function readWindow(pack: Pack, place: WindowPlace, within?: Entry[]): Promise<SampleWindow> {
  const { level, side, stride } = place;
  const intervals = pack.header.tileSize - 1;
  const metres = new Float64Array(side * side).fill(NaN);
  const last = (side - 1) * stride;
  const tileOf = (sample: number) => Math.floor(sample / intervals);
  const rows = tilesPoleToPole(level);
  const around = tilesAround(level);
  const jobs: Promise<void>[] = [];
  let hasData = false;
  const fill = async (x: number, y: number, entry: Entry): Promise<void> => {
    const tile = await pack.readHeights(entry);
    hasData = fillFrom(tile, place, x * intervals, y * intervals, intervals, pack.header.quantumM, metres) || hasData;
  };
  // One tile more to the west and south: a sample on an edge belongs to both sides.
  for (let y = tileOf(place.row - 1); y <= tileOf(place.row + last); ++y) {
    if (y < 0 || y >= rows) continue;
    for (let x = tileOf(place.column - 1); x <= tileOf(place.column + last); ++x) {
      const wrapped = ((x % around) + around) % around;
      const id = { level, x: wrapped, y };
      if (within) {
        const entry = within.find((one) => one.id.x === wrapped && one.id.y === y);
        if (entry) jobs.push(fill(x, y, entry));
      } else {
        jobs.push(pack.findNearest(Layer.heights, id).then((entry) => (entry ? fill(x, y, entry) : undefined)));
      }
    }
  }
  await Promise.all(jobs);
  return { metres, side, hasData };
}

/** Fills those samples that lie in a tile of the window's level, from that tile or an ancestor. */
function fillFrom(
  tile: HeightTile,
  place: WindowPlace,
  west: number,
  south: number,
  intervals: number,
  quantumM: number,
  out: Float64Array,
): boolean {
  const { side, stride, column, row } = place;
  const coarser = 2 ** (place.level - tile.id.level);
  // The tile's first sample, in intervals of the window's level; x may be turns of the Earth away.
  const tileWest = Math.floor(west / intervals / coarser) * intervals * coarser;
  const tileSouth = tile.id.y * intervals * coarser;
  const first = (from: number, start: number) => Math.max(0, Math.ceil((from - start) / stride));
  const end = (to: number, start: number) => Math.min(side - 1, Math.floor((to - start) / stride));
  let any = false;
  for (let j = first(south, row); j <= end(south + intervals, row); ++j) {
    const v = (row + j * stride - tileSouth) / coarser;
    for (let i = first(west, column); i <= end(west + intervals, column); ++i) {
      const u = (column + i * stride - tileWest) / coarser;
      const value = coarser === 1 ? sampleAt(tile, u, v) : between(tile, u, v);
      if (value === undefined) continue;
      out[j * side + i] = value * quantumM;
      any = true;
    }
  }
  return any;
}

function sampleAt(tile: HeightTile, column: number, row: number): number | undefined {
  const at = row * tile.size + column;
  return tile.voids && tile.voids[at] !== 0 ? undefined : tile.samples[at];
}

function between(tile: HeightTile, u: number, v: number): number | undefined {
  const column = Math.min(Math.floor(u), tile.size - 2);
  const row = Math.min(Math.floor(v), tile.size - 2);
  let sum = 0;
  for (let corner = 0; corner < 4; ++corner) {
    const c = corner & 1;
    const r = corner >> 1;
    const weight = (c ? u - column : 1 - (u - column)) * (r ? v - row : 1 - (v - row));
    if (weight === 0) continue;
    const value = sampleAt(tile, column + c, row + r);
    if (value === undefined) return undefined;
    sum += weight * value;
  }
  return sum;
}
