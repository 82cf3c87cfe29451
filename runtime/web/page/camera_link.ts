import * as Cesium from "cesium";

/** What a link of the page holds. */
export interface Link {
  pack?: string;
  /** Degrees, metres above the ellipsoid, and degrees of heading and pitch. */
  camera?: [lon: number, lat: number, height: number, heading: number, pitch: number];
  hour?: number;
  show?: string;
  /** Whether the server draws. */
  stream?: boolean;
}

/** Reads the part of an address after its #; fields that are malformed are left out. */
export function readLink(hash: string): Link {
  const fields = new URLSearchParams(hash.replace(/^#/, ""));
  const link: Link = {};
  const pack = fields.get("pack");
  if (pack) link.pack = pack;
  const camera = (fields.get("camera") ?? "").split(",").map(Number);
  if (camera.length === 5 && camera.every(Number.isFinite) && Math.abs(camera[1]!) <= 90)
    link.camera = camera as [number, number, number, number, number];
  const hour = Number(fields.get("hour") ?? "x");
  if (hour >= 0 && hour <= 24) link.hour = hour;
  const show = fields.get("show");
  if (show) link.show = show;
  if (fields.get("draw") === "server") link.stream = true;
  return link;
}

export function writeLink(link: Link): string {
  const fields = new URLSearchParams();
  if (link.pack) fields.set("pack", link.pack);
  if (link.camera) fields.set("camera", link.camera.join(","));
  if (link.hour !== undefined) fields.set("hour", String(link.hour));
  if (link.show) fields.set("show", link.show);
  if (link.stream) fields.set("draw", "server");
  return "#" + fields.toString().replaceAll("%2C", ",").replaceAll("%2F", "/");
}

export function cameraOf(camera: Cesium.Camera): NonNullable<Link["camera"]> {
  const { longitude, latitude, height } = camera.positionCartographic;
  const round = (value: number, digits: number) => Number(value.toFixed(digits));
  const degrees = (radians: number, digits: number) => round(Cesium.Math.toDegrees(radians), digits);
  return [
    degrees(longitude, 6),
    degrees(latitude, 6),
    round(height, 1),
    degrees(camera.heading, 2) % 360, // a hair west of north rounds to 360
    degrees(camera.pitch, 2),
  ];
}

/** Reads a place that a person typed: latitude, then longitude, in degrees; letters N, S, E and W may follow. */
export function readPlace(text: string): { lon: number; lat: number } | undefined {
  const found = /^\s*([+-]?\d+(?:\.\d*)?)\s*°?\s*([NSEW])?\s*[,; ]\s*([+-]?\d+(?:\.\d*)?)\s*°?\s*([NSEW])?\s*$/i.exec(text);
  if (!found) return undefined;
  let [first, second] = [Number(found[1]), Number(found[3])];
  const [a, b] = [found[2]?.toUpperCase(), found[4]?.toUpperCase()];
  if (a === "S" || a === "W") first = -first;
  if (b === "S" || b === "W") second = -second;
  const swapped = a === "E" || a === "W" || b === "N" || b === "S";
  const [lat, lon] = swapped ? [second, first] : [first, second];
  return Math.abs(lat) <= 90 && Math.abs(lon) <= 360 ? { lon, lat } : undefined;
}
