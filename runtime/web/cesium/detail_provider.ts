import * as Cesium from "cesium";
import { Layer, Pack, tileAt } from "../pack/index.js";
import { tilingSchemeOf } from "./tiling_scheme.js";

const SIDE = 64;
const CELLS = 8;

/** What the colours say of the finest heights at a place. */
export type Detail = "level" | "error";

/** Colours of levels in turn, and of errors from 0.1 m to 1000 m, each with a word for people. */
export const LEVEL_COLOURS = ["#4477aa", "#66ccee", "#228833", "#ccbb44", "#ee6677", "#aa3377"];
export const ERROR_COLOURS: [number, string][] = [
  [0.1, "#440154"],
  [1, "#3b528b"],
  [10, "#21918c"],
  [100, "#5ec962"],
  [Infinity, "#fde725"],
];

export function levelColour(level: number): string {
  return LEVEL_COLOURS[(level + 60) % LEVEL_COLOURS.length]!;
}

export function errorColour(errorM: number): string {
  return ERROR_COLOURS.find(([limit]) => errorM <= limit)![1];
}

/** An imagery layer that shows of which level the finest heights are, or how large their geometric error is. */
export class DetailProvider {
  readonly errorEvent = new Cesium.Event();
  readonly tilingScheme: Cesium.GeographicTilingScheme;
  readonly rectangle = Cesium.Rectangle.MAX_VALUE;
  readonly tileWidth = SIDE;
  readonly tileHeight = SIDE;
  readonly minimumLevel = 0;
  readonly maximumLevel: number;
  readonly hasAlphaChannel = true;
  readonly tileDiscardPolicy = undefined;
  readonly credit = undefined;
  readonly proxy = undefined;

  constructor(
    private readonly pack: Pack,
    private readonly detail: Detail,
  ) {
    this.tilingScheme = tilingSchemeOf(pack);
    this.maximumLevel = Math.max(0, (pack.levelRange(Layer.heights)?.finest ?? 0) + 8);
  }

  getTileCredits(): undefined {
    return undefined;
  }

  pickFeatures(): undefined {
    return undefined;
  }

  async requestImage(x: number, y: number, level: number): Promise<HTMLCanvasElement> {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = SIDE;
    const context = canvas.getContext("2d")!;
    const finest = this.pack.levelRange(Layer.heights)!.finest;
    const { west, north, width, height } = this.tilingScheme.tileXYToRectangle(x, y, level);
    for (let j = 0; j < CELLS; ++j) {
      for (let i = 0; i < CELLS; ++i) {
        const lon = Cesium.Math.toDegrees(west + ((i + 0.5) / CELLS) * width);
        const lat = Cesium.Math.toDegrees(north - ((j + 0.5) / CELLS) * height);
        const entry = await this.pack.findNearest(Layer.heights, tileAt(lon, lat, finest));
        if (!entry) continue;
        context.fillStyle = this.detail === "level" ? levelColour(entry.id.level) : errorColour(entry.errorM);
        context.fillRect((i * SIDE) / CELLS, (j * SIDE) / CELLS, SIDE / CELLS, SIDE / CELLS);
      }
    }
    return canvas;
  }
}
