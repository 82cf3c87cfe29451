import { type Entry, type HeightTile, Pack } from "./pack.js";
import { Layer, type TileId, tileAt, tilesAround, tilesPoleToPole } from "./grid.js";

export interface Height {
  /** Above the pack's datum. */
  metres: number;
  /** Of the tile that it comes from. */
  level: number;
  /** Geometric error of that tile in metres. */
  errorM: number;
}

/** Where a place lies in a tile, in intervals from its south-west corner. */
interface TilePlace {
  id: TileId;
  column: number;
  row: number;
}

/** A position that is a sample's but for the arithmetic becomes it exactly, as in format/pack_sampler.cpp. */
function snap(position: number, intervalsPerDegree: number): number {
  const slack = Math.max(1e-6, 1e-13 * intervalsPerDegree);
  const nearest = roundAway(position);
  return Math.abs(position - nearest) <= slack ? nearest : position;
}

/** C's round(): halves away from zero. */
function roundAway(value: number): number {
  return Math.sign(value) * Math.floor(Math.abs(value) + 0.5);
}

function placeIn(id: TileId, lon: number, lat: number, intervals: number): TilePlace {
  const width = 2 ** -id.level;
  const scale = intervals / width;
  let east = (lon - (id.x * width - 180)) % 360;
  if (east < -1e-9) east += 360;
  if (east > 360 - 1e-9) east -= 360;
  const inside = (at: number) => Math.min(Math.max(at, 0), intervals);
  return {
    id,
    column: inside(snap(east * scale, scale)),
    row: inside(snap((lat - (id.y * width - 90)) * scale, scale)),
  };
}

/** The tile that holds the place, then the neighbours that share it on an edge or a corner. */
function candidatesAt(lon: number, lat: number, level: number, intervals: number): TilePlace[] {
  const first = placeIn(tileAt(lon, lat, level), lon, lat, intervals);
  const { id } = first;
  const width = 2 ** -level;
  const lastInside = (worldEnd: number, start: number) => Math.min(((worldEnd - start) / width) * intervals, intervals);
  const step = (at: number, last: number) => (at === 0 ? -1 : at >= last ? 1 : 0);
  const dx = step(first.column, Math.floor(lastInside(180, id.x * width - 180)));
  const dy = step(first.row, Math.floor(lastInside(90, id.y * width - 90)));
  const out = [first];
  const add = (stepX: number, stepY: number) => {
    const around = tilesAround(level);
    const y = id.y + stepY;
    if (y < 0 || y >= tilesPoleToPole(level)) return;
    out.push(placeIn({ level, x: (id.x + stepX + around) % around, y }, lon, lat, intervals));
  };
  if (dx !== 0) add(dx, 0);
  if (dy !== 0) add(0, dy);
  if (dx !== 0 && dy !== 0) add(dx, dy);
  return out;
}

/** Bilinear, in quanta; undefined where a sample with weight is void. */
function interpolate(tile: HeightTile, place: TilePlace): number | undefined {
  const column = Math.min(Math.floor(place.column), tile.size - 2);
  const row = Math.min(Math.floor(place.row), tile.size - 2);
  const t = place.column - column;
  const u = place.row - row;
  const weights = [(1 - t) * (1 - u), t * (1 - u), (1 - t) * u, t * u];
  let sum = 0;
  for (let corner = 0; corner < 4; ++corner) {
    const weight = weights[corner]!;
    if (weight === 0) continue;
    const at = (row + (corner >> 1)) * tile.size + column + (corner & 1);
    if (tile.voids && tile.voids[at] !== 0) return undefined;
    sum += weight * tile.samples[at]!;
  }
  return sum;
}

/**
 * Returns the height at a place, bilinear between the samples of the finest tile that covers it: the number of
 * `cairn sample`, bit for bit. Undefined where no tile covers the place or a sample that it needs is void. Only
 * levels up to `finest` are used.
 */
export async function heightAt(pack: Pack, lon: number, lat: number, finest = Infinity): Promise<Height | undefined> {
  const range = pack.levelRange(Layer.heights);
  if (!range || !Number.isFinite(lon) || !(Math.abs(lat) <= 90)) return undefined;
  const intervals = pack.header.tileSize - 1;
  for (let level = Math.min(finest, range.finest); level >= range.coarsest; --level) {
    for (const place of candidatesAt(lon, lat, level, intervals)) {
      const entry: Entry | undefined = await pack.find(Layer.heights, place.id);
      if (!entry) continue;
      const quanta = interpolate(await pack.readHeights(entry), place);
      if (quanta === undefined) return undefined;
      return { metres: quanta * pack.header.quantumM, level, errorM: entry.errorM };
    }
  }
  return undefined;
}
