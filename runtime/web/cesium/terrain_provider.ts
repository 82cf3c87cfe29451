import * as Cesium from "cesium";
import { type Entry, Layer, Pack } from "../pack/index.js";
import { readWindow, type WindowPlace } from "./sample_window.js";
import { tilingSchemeOf } from "./tiling_scheme.js";

/** Intervals along a side of a tile of CesiumJS: 180° / 2^L hold 90 of the pack's level L - 10. */
const INTERVALS = 90;
const SIDE = INTERVALS + 1;
const QUANTA = 32767;
/** Tiles of the pack that one of CesiumJS's coarsest tiles is put together from. */
const MOST_TILES = 16;
const HIGHEST_M = 9000;
const MOST_OVER_ESTIMATE = 2;

/** What CesiumJS exports and its types leave out. */
const { AttributeCompression, EllipsoidalOccluder } = Cesium as unknown as {
  AttributeCompression: { octEncode(vector: Cesium.Cartesian3, result: Cesium.Cartesian2): void };
  EllipsoidalOccluder: new (ellipsoid: Cesium.Ellipsoid) => {
    computeHorizonCullingPointPossiblyUnderEllipsoid(
      towards: Cesium.Cartesian3,
      positions: Cesium.Cartesian3[],
      lowest: number,
    ): Cesium.Cartesian3 | undefined;
  };
};

/**
 * Terrain of a pack for CesiumJS. The vertices of a tile are samples of the pack: tile level L has those of the level
 * of the lattice whose 90 intervals are its width, so nothing is resampled. Heights are drawn as they are stored,
 * above the ellipsoid; where the pack has none they are 0.
 */
export class CairnTerrainProvider {
  readonly errorEvent = new Cesium.Event();
  readonly tilingScheme: Cesium.GeographicTilingScheme;
  readonly credit: Cesium.Credit | undefined = undefined;
  readonly hasWaterMask = false;
  readonly hasVertexNormals = true;
  readonly availability = undefined;
  /** The finest level of CesiumJS's tiles. */
  readonly maximumLevel: number;
  private readonly available = new Map<string, boolean>();
  private readonly levelOffset: number;

  private constructor(
    readonly pack: Pack,
    private readonly coarsest: number,
    private readonly finest: number,
    /** All tiles of the coarsest level, where they are few. */
    private readonly coarseTiles: Entry[] | undefined,
    /** The lowest and highest sample of the coarsest level's tiles, in metres. */
    readonly heightRangeM: { low: number; high: number },
  ) {
    const { tileSize } = pack.header;
    this.tilingScheme = tilingSchemeOf(pack);
    // 512 intervals per tile; packs of tile size 257 have half as many at a level.
    this.levelOffset = tileSize === 513 ? 10 : 9;
    this.maximumLevel = finest + this.levelOffset;
  }

  /** Returns the provider; undefined where the pack has no heights. */
  static async create(pack: Pack): Promise<CairnTerrainProvider | undefined> {
    const range = pack.levelRange(Layer.heights);
    if (!range) return undefined;
    const few = await pack.entriesOfLevel(Layer.heights, range.coarsest, 4 * MOST_TILES + 1);
    const known = few.length <= 4 * MOST_TILES;
    const quantum = pack.header.quantumM;
    const low = Math.min(...few.map((e) => e.minimum)) * quantum;
    const high = Math.max(...few.map((e) => e.maximum)) * quantum;
    return new CairnTerrainProvider(
      pack,
      range.coarsest,
      range.finest,
      known ? few : undefined,
      known ? { low, high } : { low: -HIGHEST_M, high: HIGHEST_M },
    );
  }

  /** The pack's level whose lattice a tile of this level has; below the coarsest it has every 2^n-th sample. */
  packLevel(level: number): number {
    return level - this.levelOffset;
  }

  /**
   * What CesiumJS takes a level's surface to be off: the largest distance from the source posts that the bake measured,
   * but no less than CesiumJS's own estimate, by which it also chooses the imagery's level, and no more than twice
   * that. The error of a level is that of its worst tile, and CesiumJS knows no tile's own: without the upper limit one
   * cliff would make all tiles of a view four or five levels finer. levelErrorM() is the measured one.
   */
  getLevelMaximumGeometricError(level: number): number {
    const levelZero = Cesium.TerrainProvider.getEstimatedLevelZeroGeometricErrorForAHeightmap(
      this.tilingScheme.ellipsoid,
      SIDE,
      this.tilingScheme.getNumberOfXTilesAtLevel(0),
    );
    const estimate = levelZero / 2 ** level;
    return Math.min(Math.max(estimate, this.levelErrorM(level)), MOST_OVER_ESTIMATE * estimate);
  }

  /**
   * The largest distance of a level's surface from the source posts in metres. A level that is coarser than the pack's
   * coarsest is off by no more than its heights differ.
   */
  levelErrorM(level: number): number {
    const at = Math.min(this.packLevel(level), this.finest);
    return at >= this.coarsest ? (this.pack.levelErrorM(at) ?? 0) : this.coarseErrorM();
  }

  /** Of levels that have only every 2^n-th sample, or none: no farther than heights are from each other and from 0. */
  private coarseErrorM(): number {
    const { low, high } = this.heightRangeM;
    return Math.max(Math.abs(low), Math.abs(high), high - low);
  }

  getTileDataAvailable(x: number, y: number, level: number): boolean | undefined {
    if (level > this.maximumLevel) return false;
    if (this.packLevel(level) <= this.coarsest) return true;
    return this.available.get(`${level}/${x}/${y}`);
  }

  loadTileDataAvailability(): undefined {
    return undefined;
  }

  async requestTileGeometry(x: number, y: number, level: number): Promise<Cesium.TerrainData> {
    const rectangle = this.tilingScheme.tileXYToRectangle(x, y, level);
    const place = this.placeOf(x, y, level);
    // A sample more on each side, for normals.
    const margin = { ...place, column: place.column - place.stride, row: place.row - place.stride, side: SIDE + 2 };
    const [metres, mask] = await Promise.all([this.heights(margin), this.childMask(x, y, level)]);
    return makeMesh(metres, rectangle, this.tilingScheme.ellipsoid, this.levelErrorM(level), mask);
  }

  private placeOf(x: number, y: number, level: number): WindowPlace {
    const wanted = this.packLevel(level);
    const at = Math.max(wanted, this.coarsest);
    const stride = 2 ** (at - wanted);
    const rowFromSouth = this.tilingScheme.getNumberOfYTilesAtLevel(level) - 1 - y;
    return {
      level: at,
      column: x * INTERVALS * stride,
      row: rowFromSouth * INTERVALS * stride,
      side: SIDE,
      stride,
    };
  }

  /** Heights of a window of SIDE + 2; 0 where there are none. */
  private async heights(place: WindowPlace): Promise<Float64Array> {
    const flat = () => new Float64Array(place.side * place.side);
    const intervals = this.pack.header.tileSize - 1;
    const across = Math.ceil(((place.side - 1) * place.stride) / intervals) + 1;
    let within: Entry[] | undefined;
    if (across * across > MOST_TILES) {
      if (!this.coarseTiles) return flat();
      within = this.coarseTiles;
      if (within.length > MOST_TILES) return flat();
    }
    const { metres } = await readWindow(this.pack, place, within);
    return metres.map((height) => (Number.isNaN(height) ? 0 : height));
  }

  /** Which children have samples of their own: bits south-west, south-east, north-west, north-east. */
  private async childMask(x: number, y: number, level: number): Promise<number> {
    if (level >= this.maximumLevel) return 0;
    if (this.packLevel(level + 1) <= this.coarsest) return 15;
    let mask = 0;
    const children = [0, 1, 2, 3].map(async (bit) => {
      const [cx, cy] = [2 * x + (bit & 1), 2 * y + (bit < 2 ? 1 : 0)];
      const there = await this.hasTiles(this.placeOf(cx, cy, level + 1));
      this.available.set(`${level + 1}/${cx}/${cy}`, there);
      if (there) mask |= 1 << bit;
    });
    await Promise.all(children);
    return mask;
  }

  /** Returns whether some tile of the window's own level lies in it. */
  private async hasTiles(place: WindowPlace): Promise<boolean> {
    const intervals = this.pack.header.tileSize - 1;
    const end = (from: number) => Math.floor((from + INTERVALS - 1) / intervals);
    for (let y = Math.floor(place.row / intervals); y <= end(place.row); ++y)
      for (let x = Math.floor(place.column / intervals); x <= end(place.column); ++x)
        if (await this.pack.find(Layer.heights, { level: place.level, x, y })) return true;
    return false;
  }
}

const INDICES = gridIndices();

function gridIndices(): Uint16Array {
  const out = new Uint16Array(6 * INTERVALS * INTERVALS);
  let at = 0;
  for (let j = 0; j < INTERVALS; ++j) {
    for (let i = 0; i < INTERVALS; ++i) {
      const sw = j * SIDE + i;
      const nw = sw + SIDE;
      out.set([sw, sw + 1, nw, nw, sw + 1, nw + 1], at);
      at += 6;
    }
  }
  return out;
}

const edge = (place: (n: number) => number) => Array.from({ length: SIDE }, (_, n) => place(n));
const WEST = edge((n) => n * SIDE);
const SOUTH = edge((n) => n);
const EAST = edge((n) => n * SIDE + INTERVALS);
const NORTH = edge((n) => INTERVALS * SIDE + n);

/** A mesh of a window's inner samples, rows from the south. Normals are those of the lattice, equal in all tiles of a level. */
function makeMesh(
  metres: Float64Array,
  rectangle: Cesium.Rectangle,
  ellipsoid: Cesium.Ellipsoid,
  errorM: number,
  childTileMask: number,
): Cesium.QuantizedMeshTerrainData {
  const wide = SIDE + 2;
  const heightAt = (i: number, j: number) => metres[(j + 1) * wide + i + 1]!;
  let [low, high] = [Infinity, -Infinity];
  for (let j = 0; j < SIDE; ++j)
    for (let i = 0; i < SIDE; ++i) {
      low = Math.min(low, heightAt(i, j));
      high = Math.max(high, heightAt(i, j));
    }
  const count = SIDE * SIDE;
  const vertices = new Uint16Array(3 * count);
  const normals = new Uint8Array(2 * count);
  const positions: Cesium.Cartesian3[] = [];
  const step = { lon: rectangle.width / INTERVALS, lat: rectangle.height / INTERVALS };
  const scale = high > low ? QUANTA / (high - low) : 0;
  const encoded = new Cesium.Cartesian2();
  const normal = new Cesium.Cartesian3();
  for (let j = 0; j < SIDE; ++j) {
    const lat = rectangle.south + j * step.lat;
    const [sinLat, cosLat] = [Math.sin(lat), Math.cos(lat)];
    const northM = 2 * step.lat * ellipsoid.maximumRadius;
    const eastM = Math.max(2 * step.lon * ellipsoid.maximumRadius * cosLat, 1e-3);
    for (let i = 0; i < SIDE; ++i) {
      const at = j * SIDE + i;
      const height = heightAt(i, j);
      vertices[at] = Math.round((i / INTERVALS) * QUANTA);
      vertices[count + at] = Math.round((j / INTERVALS) * QUANTA);
      vertices[2 * count + at] = Math.round((height - low) * scale);
      const lon = rectangle.west + i * step.lon;
      const [sinLon, cosLon] = [Math.sin(lon), Math.cos(lon)];
      const e = -(heightAt(i + 1, j) - heightAt(i - 1, j)) / eastM;
      const n = -(heightAt(i, j + 1) - heightAt(i, j - 1)) / northM;
      normal.x = -sinLon * e - sinLat * cosLon * n + cosLat * cosLon;
      normal.y = cosLon * e - sinLat * sinLon * n + cosLat * sinLon;
      normal.z = cosLat * n + sinLat;
      Cesium.Cartesian3.normalize(normal, normal);
      AttributeCompression.octEncode(normal, encoded);
      normals[2 * at] = encoded.x;
      normals[2 * at + 1] = encoded.y;
      if (i % 15 === 0 && j % 15 === 0) positions.push(Cesium.Cartesian3.fromRadians(lon, lat, height, ellipsoid));
    }
  }
  const box = Cesium.OrientedBoundingBox.fromRectangle(rectangle, low, high, ellipsoid);
  const sphere = Cesium.BoundingSphere.fromOrientedBoundingBox(box);
  const occluder = new EllipsoidalOccluder(ellipsoid);
  // A neighbour that is a level coarser is off by its own error, which may be larger.
  const skirt = 5 * errorM;
  const hidden = occluder.computeHorizonCullingPointPossiblyUnderEllipsoid(sphere.center, positions, low);
  const data = new Cesium.QuantizedMeshTerrainData({
    quantizedVertices: vertices,
    encodedNormals: normals,
    indices: INDICES,
    minimumHeight: low,
    maximumHeight: high,
    boundingSphere: sphere,
    orientedBoundingBox: box,
    horizonOcclusionPoint: hidden ?? new Cesium.Cartesian3(),
    westIndices: WEST,
    southIndices: SOUTH,
    eastIndices: EAST,
    northIndices: NORTH,
    westSkirtHeight: skirt,
    southSkirtHeight: skirt,
    eastSkirtHeight: skirt,
    northSkirtHeight: skirt,
    childTileMask,
  });
  // A tile that is too large to be hidden as a whole has no such point, but the constructor insists on one.
  if (!hidden) (data as unknown as { _horizonOcclusionPoint: undefined })._horizonOcclusionPoint = undefined;
  return data;
}
