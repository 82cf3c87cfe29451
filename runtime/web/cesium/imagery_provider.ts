import * as Cesium from "cesium";
import { type Entry, Layer, Pack, tilesAround, tilesPoleToPole } from "../pack/index.js";
import { copyBlocks, type PlacedTexture } from "./block_window.js";
import { tilingSchemeOf } from "./tiling_scheme.js";

/** Texels along a side of a tile of CesiumJS: 180° / 2^L hold 720 of the pack's level L - 7. */
const SIDE = 720;
const MOST_TILES = 16;
const SMALLEST_SIDE = 4; // of a tile's mip that is a whole block

/**
 * Imagery of a pack for CesiumJS. A tile of level L has 720² texels of the pack's level L - 7, whose edges lie on
 * blocks of 4×4 texels, so that BC1 and BC3 blocks are copied as they are stored and only turned upside down. Levels
 * coarser than the pack's coarsest come from its mips. Where the graphics card knows no BC, or blocks cannot be copied
 * (BC7; a tile that only an ancestor covers), they are decoded.
 */
export class CairnImageryProvider {
  readonly errorEvent = new Cesium.Event();
  readonly tilingScheme: Cesium.GeographicTilingScheme;
  readonly rectangle: Cesium.Rectangle;
  readonly tileWidth = SIDE;
  readonly tileHeight = SIDE;
  readonly minimumLevel = 0;
  readonly maximumLevel: number;
  readonly hasAlphaChannel = true;
  readonly tileDiscardPolicy = undefined;
  readonly credit = undefined;
  readonly proxy = undefined;
  /** Tiles by how they were made. */
  readonly counts = { copied: 0, decoded: 0 };
  private readonly levelOffset: number;

  private constructor(
    readonly pack: Pack,
    private readonly coarsest: number,
    finest: number,
    private readonly coarseTiles: Entry[],
    private readonly copiesBlocks: boolean,
  ) {
    const { tileSize } = pack.header;
    this.tilingScheme = tilingSchemeOf(pack);
    this.levelOffset = tileSize === 513 ? 7 : 6;
    this.maximumLevel = finest + this.levelOffset;
    const imagery = pack.metadata.imagery as { bounds?: Bounds } | undefined;
    const { west, south, east, north } = imagery?.bounds ?? { west: -180, south: -90, east: 180, north: 90 };
    this.rectangle =
      east > 180 ? Cesium.Rectangle.fromDegrees(-180, south, 180, north) : Cesium.Rectangle.fromDegrees(west, south, east, north);
  }

  /** Returns the provider; undefined where the pack has no imagery. `hasBc` is whether WebGL has S3TC textures. */
  static async create(pack: Pack, hasBc: boolean): Promise<CairnImageryProvider | undefined> {
    const range = pack.levelRange(Layer.imagery);
    if (!range) return undefined;
    const few = await pack.entriesOfLevel(Layer.imagery, range.coarsest, 4 * MOST_TILES);
    return new CairnImageryProvider(pack, range.coarsest, range.finest, few, hasBc);
  }

  getTileCredits(): undefined {
    return undefined;
  }

  pickFeatures(): undefined {
    return undefined;
  }

  async requestImage(x: number, y: number, level: number): Promise<Cesium.ImageryTypes> {
    const tiles = await this.tilesOf(x, y, level);
    const ancestors = tiles.some((one) => one.mip < 0);
    const copied = this.copiesBlocks && !ancestors ? copyBlocks(tiles, SIDE) : undefined;
    if (!copied) {
      ++this.counts.decoded;
      return this.draw(tiles);
    }
    ++this.counts.copied;
    const format = copied.format === 1 ? Cesium.PixelFormat.RGBA_DXT1 : Cesium.PixelFormat.RGBA_DXT5;
    return new Cesium.CompressedTextureBuffer(
      format,
      Cesium.PixelDatatype.UNSIGNED_BYTE,
      SIDE,
      SIDE,
      copied.blocks,
    ) as unknown as Cesium.ImageryTypes;
  }

  /** Texels along a side of a pack's tile in a tile of CesiumJS. */
  private sideAt(level: number, packLevel: number): number {
    return (this.pack.header.tileSize - 1) * 2 ** (level - this.levelOffset - packLevel);
  }

  private async tilesOf(x: number, y: number, level: number): Promise<PlacedTexture[]> {
    const at = Math.max(level - this.levelOffset, this.coarsest);
    const side = this.sideAt(level, at);
    const rowsOfTiles = this.tilingScheme.getNumberOfYTilesAtLevel(level);
    const [west, south] = [x * SIDE, (rowsOfTiles - 1 - y) * SIDE];
    const out = new Map<string, Promise<PlacedTexture>>();
    const add = (entry: Entry) => {
      const { id } = entry;
      const own = this.sideAt(level, id.level);
      const mip = id.level === at ? Math.round(Math.log2((this.pack.header.tileSize - 1) / own)) : -1;
      const placed = { entry, x: id.x * own - west, y: SIDE - (id.y * own - south) - own, side: own, mip };
      const texture = entry.constant ? Promise.resolve(undefined) : this.pack.readTexture(entry);
      out.set(`${id.level}/${id.x}/${id.y}`, texture.then((found) => ({ ...placed, texture: found })));
    };
    const overlaps = (from: number, start: number) => from < start + SIDE && from + side > start;
    if (side < SMALLEST_SIDE) return [];
    const across = Math.ceil(SIDE / side) + 1;
    if (across * across > MOST_TILES) {
      if (this.coarseTiles.length <= MOST_TILES)
        for (const entry of this.coarseTiles)
          if (overlaps(entry.id.x * side, west) && overlaps(entry.id.y * side, south)) add(entry);
    } else {
      const finds: Promise<void>[] = [];
      for (let ty = Math.floor(south / side); ty * side < south + SIDE && ty < tilesPoleToPole(at); ++ty)
        for (let tx = Math.floor(west / side); tx * side < west + SIDE && tx < tilesAround(at); ++tx)
          finds.push(
            this.pack.findNearest(Layer.imagery, { level: at, x: tx, y: ty }).then((entry) => (entry ? add(entry) : undefined)),
          );
      await Promise.all(finds);
    }
    return Promise.all(out.values());
  }

  /** Draws tiles as they are seen, the coarser ones beneath. */
  private draw(tiles: PlacedTexture[]): HTMLCanvasElement {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = SIDE;
    const context = canvas.getContext("2d")!;
    for (const tile of [...tiles].sort((a, b) => a.entry.id.level - b.entry.id.level)) {
      if (!tile.texture) {
        const rgba = tile.entry.minimum;
        context.fillStyle = `rgba(${rgba & 255},${(rgba >> 8) & 255},${(rgba >> 16) & 255},${((rgba >>> 24) & 255) / 255})`;
        context.fillRect(tile.x, tile.y, tile.side, tile.side);
        continue;
      }
      const mip = Math.max(tile.mip, 0);
      const width = this.pack.header.tileSize - 1 >> mip;
      const pixels = this.pack.decoder.decodeImage(tile.texture.format, tile.texture.mips[mip]!, width, width);
      const part = document.createElement("canvas");
      part.width = part.height = width;
      part.getContext("2d")!.putImageData(new ImageData(pixels as Uint8ClampedArray<ArrayBuffer>, width, width), 0, 0);
      context.drawImage(part, tile.x, tile.y, tile.side, tile.side);
    }
    return canvas;
  }
}

interface Bounds {
  west: number;
  south: number;
  east: number;
  north: number;
}
