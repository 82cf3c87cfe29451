import * as Cesium from "cesium";
import { CairnImageryProvider } from "../cesium/imagery_provider.js";
import { CairnTerrainProvider } from "../cesium/terrain_provider.js";
import { DetailProvider } from "../cesium/detail_provider.js";
import { heightAt, Pack } from "../pack/index.js";

export type Show = "imagery" | "relief" | "level" | "error";

/** What is known of a place. */
export interface PlaceInfo {
  lon: number;
  lat: number;
  metres?: number;
  errorM?: number;
  level?: number;
}

interface Bounds {
  west: number;
  south: number;
  east: number;
  north: number;
}

const SEA = ["#14365c", "#3a6ea5", "#8fbcd9"];
const LAND = ["#4f7d4f", "#8f9a58", "#b08d57", "#9c7a6b", "#f4f4f4"];

/** A pack on a globe. */
export class PackView {
  private imagery: Cesium.ImageryLayer | undefined;
  private detail: Cesium.ImageryLayer | undefined;

  private constructor(
    readonly pack: Pack,
    readonly widget: Cesium.CesiumWidget,
    readonly terrain: CairnTerrainProvider | undefined,
    readonly imageryProvider: CairnImageryProvider | undefined,
  ) {}

  /** Draws a pack in an element. `failed` is called with each tile that cannot be read. */
  static async create(pack: Pack, element: HTMLElement, credits: HTMLElement, failed: (error: unknown) => void): Promise<PackView> {
    const { semiMajorM, semiMinorM, body } = pack.header;
    const ellipsoid = new Cesium.Ellipsoid(semiMajorM, semiMajorM, semiMinorM);
    Cesium.Ellipsoid.default = ellipsoid;
    const terrain = await CairnTerrainProvider.create(pack);
    const widget = new Cesium.CesiumWidget(element, {
      ellipsoid,
      globe: new Cesium.Globe(ellipsoid),
      baseLayer: false,
      skyBox: false,
      ...(body === "Earth" ? {} : { skyAtmosphere: false as const }),
      creditContainer: credits,
      requestRenderMode: true,
      maximumRenderTimeChange: Infinity,
      msaaSamples: 1,
      ...(terrain ? { terrainProvider: terrain as unknown as Cesium.TerrainProvider } : {}),
    });
    const { scene } = widget;
    scene.moon = undefined as unknown as Cesium.Moon;
    scene.globe.baseColor = Cesium.Color.fromCssColorString("#6f7f8f");
    scene.globe.enableLighting = true;
    scene.globe.showGroundAtmosphere = false;
    scene.fog.renderable = false; // it still thins out tiles far away
    const hasBc = (scene as unknown as { context: { s3tc: boolean } }).context.s3tc;
    const imageryProvider = await CairnImageryProvider.create(pack, hasBc);
    const view = new PackView(pack, widget, terrain, imageryProvider);
    terrain?.errorEvent.addEventListener((error: Cesium.TileProviderError) => failed(error.error ?? error.message));
    imageryProvider?.errorEvent.addEventListener((error: Cesium.TileProviderError) => failed(error.error ?? error.message));
    if (imageryProvider)
      view.imagery = scene.imageryLayers.addImageryProvider(imageryProvider as unknown as Cesium.ImageryProvider);
    return view;
  }

  destroy(): void {
    this.widget.destroy();
  }

  get hasImagery(): boolean {
    return this.imagery !== undefined;
  }

  show(what: Show): void {
    const { scene } = this.widget;
    if (this.detail) scene.imageryLayers.remove(this.detail);
    this.detail = undefined;
    if (this.imagery) this.imagery.show = what === "imagery";
    scene.globe.material = what === "relief" ? this.reliefMaterial() : (undefined as unknown as Cesium.Material);
    if ((what === "level" || what === "error") && this.terrain)
      this.detail = scene.imageryLayers.addImageryProvider(
        new DetailProvider(this.pack, what) as unknown as Cesium.ImageryProvider,
      );
    scene.requestRender();
  }

  /** Sets the sun to an hour of local solar time where the camera is, at an equinox. */
  setHour(hour: number): void {
    const { longitude } = this.widget.camera.positionCartographic;
    const utc = hour - Cesium.Math.toDegrees(longitude) / 15;
    const noon = Cesium.JulianDate.fromIso8601("2026-03-20T00:00:00Z");
    this.widget.clock.currentTime = Cesium.JulianDate.addSeconds(noon, utc * 3600, new Cesium.JulianDate());
    this.widget.scene.requestRender();
  }

  /** Shows the whole pack, from the south and above. */
  goHome(): void {
    const bounds = (this.pack.metadata.bounds ?? { west: -180, south: -90, east: 180, north: 90 }) as Bounds;
    const wide = bounds.east - bounds.west > 90;
    const { camera } = this.widget;
    const { semiMajorM } = this.pack.header;
    if (wide) {
      const lon = (bounds.west + bounds.east) / 2;
      camera.setView({ destination: Cesium.Cartesian3.fromDegrees(lon, 20, 2.2 * semiMajorM) });
      return;
    }
    const lon = (bounds.west + bounds.east) / 2;
    const lat = (bounds.south + bounds.north) / 2;
    const rectangle = Cesium.Rectangle.fromDegrees(bounds.west, bounds.south, bounds.east, bounds.north);
    const sphere = Cesium.BoundingSphere.fromRectangle3D(rectangle, this.widget.scene.globe.ellipsoid, 0);
    const centre = Cesium.Cartesian3.fromDegrees(lon, lat, 0);
    camera.lookAt(centre, new Cesium.HeadingPitchRange(0, Cesium.Math.toRadians(-45), 2 * sphere.radius));
    camera.lookAtTransform(Cesium.Matrix4.IDENTITY);
  }

  /** Moves the camera so that a place is in the middle, at about the distance that it has now. */
  goTo(lon: number, lat: number): void {
    const { camera } = this.widget;
    const range = Math.min(Math.max(camera.positionCartographic.height, 5000), 200000);
    const offset = new Cesium.HeadingPitchRange(camera.heading, Cesium.Math.toRadians(-45), range);
    camera.lookAt(Cesium.Cartesian3.fromDegrees(lon, lat, 0), offset);
    camera.lookAtTransform(Cesium.Matrix4.IDENTITY);
    this.widget.scene.requestRender();
  }

  /** Returns the place that is seen at a pixel, with the pack's height there; undefined in the sky. */
  async placeAt(x: number, y: number): Promise<PlaceInfo | undefined> {
    const { scene, camera } = this.widget;
    const ray = camera.getPickRay(new Cesium.Cartesian2(x, y));
    const point = ray && scene.globe.pick(ray, scene);
    if (!point) return undefined;
    const place = Cesium.Cartographic.fromCartesian(point, scene.globe.ellipsoid);
    const [lon, lat] = [Cesium.Math.toDegrees(place.longitude), Cesium.Math.toDegrees(place.latitude)];
    return { lon, lat, ...(await heightAt(this.pack, lon, lat)) };
  }

  /** Colours by height: below 0 and above it, to the lowest and highest sample of the pack's coarsest tiles. */
  private reliefMaterial(): Cesium.Material {
    const range = this.terrain?.heightRangeM ?? { low: 0, high: 1 };
    const low = Math.min(range.low, range.high - 1);
    const sea = Math.min(Math.max(-low / (range.high - low), 0), 1);
    const canvas = document.createElement("canvas");
    canvas.width = 1024;
    canvas.height = 1;
    const context = canvas.getContext("2d")!;
    const ramp = context.createLinearGradient(0, 0, canvas.width, 0);
    if (sea > 0) SEA.forEach((colour, i) => ramp.addColorStop((sea * i) / (SEA.length - 1), colour));
    if (sea < 1) LAND.forEach((colour, i) => ramp.addColorStop(sea + ((1 - sea) * i) / (LAND.length - 1), colour));
    context.fillStyle = ramp;
    context.fillRect(0, 0, canvas.width, 1);
    return Cesium.Material.fromType("ElevationRamp", {
      image: canvas,
      minimumHeight: low,
      maximumHeight: range.high,
    });
  }
}
