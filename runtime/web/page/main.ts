import { BlobSource, type ByteSource, Decoder, hasSimd, heightAt, HttpSource, Pack, PackError } from "../pack/index.js";
import { ERROR_COLOURS, errorColour, levelColour } from "../cesium/detail_provider.js";
import { cameraOf, readLink, readPlace, writeLink } from "./camera_link.js";
import { moveByKey } from "./keyboard.js";
import { type StreamFigures, StreamView } from "./stream_view.js";
import { PackView, type PlaceInfo, type Show } from "./pack_view.js";
import * as Cesium from "cesium";

(globalThis as unknown as { CESIUM_BASE_URL: string }).CESIUM_BASE_URL = new URL("cesium/", location.href).href;

function element<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

const globe = element("globe");
const packs = element<HTMLSelectElement>("pack");
const show = element<HTMLSelectElement>("show");
const hour = element<HTMLInputElement>("hour");
const info = element<HTMLOutputElement>("place-info");
const progress = element<HTMLProgressElement>("progress");
const message = element("message");
const legend = element("legend");

let decoder: Promise<Decoder> | undefined;
let view: PackView | undefined;
let stream: StreamView | undefined;
let packUrl: string | undefined;
/** Of the packs that the server draws: where it does. */
const streamUrls = new Map<string, string>();
const streaming = element("streaming");
const streams = element<HTMLInputElement>("stream");

/** Says what failed and what a person can do. */
function fail(error: unknown): void {
  const text = error instanceof Error ? error.message : String(error);
  const kind = error instanceof PackError ? error.kind : undefined;
  const advice =
    kind === "replaced" ? " Reload the page to see the new pack." : kind === "network" ? " Is the server still running?" : "";
  message.textContent = text + advice;
  message.hidden = false;
}

function loadDecoder(): Promise<Decoder> {
  const name = hasSimd() ? "cairn-pack-simd.wasm" : "cairn-pack.wasm";
  decoder ??= fetch(name)
    .then((answer) => {
      if (!answer.ok) throw new Error(`${name}: expected the decoder, found the server's answer ${answer.status}`);
      return answer.arrayBuffer();
    })
    .then((bytes) => Decoder.create(bytes));
  return decoder;
}

/** Opens a pack of the server, drawn as the page says; here where there is no WebGL, if the server draws it. */
async function openUrl(url: string): Promise<void> {
  const drawn = streamUrls.get(url);
  streaming.hidden = drawn === undefined;
  if (drawn !== undefined && (streams.checked || !hasWebGl())) return openStream(url, drawn);
  if (!hasWebGl())
    return fail(new Error("This browser draws no WebGL 2, which the globe needs. Another browser or graphics driver may."));
  return open(new HttpSource(new URL(url, location.href).href), url);
}

function hasWebGl(): boolean {
  return document.createElement("canvas").getContext("webgl2") !== null;
}

function closeViews(): void {
  view?.destroy();
  stream?.destroy();
  view = undefined;
  stream = undefined;
  globe.replaceChildren();
}

function openStream(url: string, drawnAt: string): void {
  message.hidden = true;
  const link = readLink(location.hash);
  if (link.hour !== undefined && link.pack === url) hour.value = String(link.hour);
  const camera = view && packUrl === url ? cameraOf(view.widget.camera) : link.pack === url ? link.camera : undefined;
  closeViews();
  packUrl = url;
  streams.checked = true;
  show.disabled = true;
  legend.replaceChildren();
  info.value = "Waiting for the server's first picture …";
  stream = new StreamView(drawnAt, globe, { hour: Number(hour.value), ...(camera ? { camera } : {}) }, describeStream, fail);
  Object.assign(globalThis, { cairn: { stream } });
}

function describeStream(figures: StreamFigures): void {
  const latency = figures.latencyMs === undefined ? "" : `, ${figures.latencyMs.toFixed(0)} ms from a key to its picture`;
  info.value =
    `${figures.width}×${figures.height}, ${figures.framesPerSecond} frames/s, ${figures.megabitsPerSecond.toFixed(2)} Mbit/s, ` +
    `drawn in ${figures.drawMs.toFixed(0)} ms${latency}${figures.complete ? "" : ", loading"}`;
  history.replaceState(null, "", currentLink());
  Object.assign((globalThis as unknown as { cairn: object }).cairn, { figures });
}

async function open(source: ByteSource, url: string | undefined): Promise<void> {
  message.hidden = true;
  const streamed = stream?.camera && packUrl === url ? stream.camera : undefined;
  show.disabled = false;
  info.value = `Opening ${source.name} …`;
  progress.hidden = false;
  progress.removeAttribute("value");
  try {
    const pack = await Pack.open(source, await loadDecoder());
    closeViews();
    view = await PackView.create(pack, globe, element("cesium-credits"), fail);
    packUrl = url;
    watch(view);
    const link = readLink(location.hash);
    const wanted = (link.show ?? (view.hasImagery ? "imagery" : "relief")) as Show;
    show.value = wanted;
    showAs(wanted);
    if (streamed) setCamera(streamed);
    else if (link.camera && link.pack === url) setCamera(link.camera);
    else view.goHome();
    if (link.hour !== undefined) hour.value = String(link.hour);
    view.setHour(Number(hour.value));
    const bound = pack.metadata.error_bound_m;
    info.value = `${source.name}: heights above ${pack.header.verticalDatum === "unknown" ? "an unknown datum" : pack.header.verticalDatum}${typeof bound === "number" ? `, error bound ${bound} m` : ""}`;
    Object.assign(globalThis, { cairn: { view, pack, heightAt, Cesium } }); // for the console and for tests
  } catch (error) {
    progress.hidden = true;
    info.value = "No pack is open.";
    fail(error);
  }
}

function watch(current: PackView): void {
  let most = 0;
  current.widget.scene.globe.tileLoadProgressEvent.addEventListener((waiting: number) => {
    most = waiting === 0 ? 0 : Math.max(most, waiting);
    progress.hidden = waiting === 0;
    progress.max = Math.max(most, 1);
    progress.value = most - waiting;
  });
  current.widget.camera.moveEnd.addEventListener(() => {
    if (current === view) history.replaceState(null, "", currentLink());
  });
  current.widget.scene.renderError.addEventListener((_scene: unknown, error: unknown) => fail(error));
}

function setCamera([lon, lat, height, heading, pitch]: [number, number, number, number, number]): void {
  view!.widget.camera.setView({
    destination: Cesium.Cartesian3.fromDegrees(lon, lat, height),
    orientation: { heading: Cesium.Math.toRadians(heading), pitch: Cesium.Math.toRadians(pitch), roll: 0 },
  });
}

function currentLink(): string {
  return writeLink({
    ...(packUrl ? { pack: packUrl } : {}),
    ...(view ? { camera: cameraOf(view.widget.camera) } : stream?.camera ? { camera: stream.camera, stream: true } : {}),
    hour: Number(hour.value),
    show: show.value,
  });
}

function showAs(what: Show): void {
  view?.show(what);
  legend.replaceChildren();
  const add = (colour: string, text: string) => {
    const item = document.createElement("li");
    const patch = document.createElement("span");
    patch.style.background = colour;
    item.append(patch, text);
    legend.append(item);
  };
  if (what === "level" && view)
    for (const { layer, level } of view.pack.levels) if (layer === 0) add(levelColour(level), `level ${level}`);
  if (what === "error")
    for (const [limit] of ERROR_COLOURS)
      add(errorColour(limit), limit === Infinity ? "error above 100 m" : `error up to ${limit} m`);
}

function describe(place: PlaceInfo): string {
  const where = `${Math.abs(place.lat).toFixed(5)}° ${place.lat < 0 ? "S" : "N"}  ${Math.abs(place.lon).toFixed(5)}° ${place.lon < 0 ? "W" : "E"}`;
  if (place.metres === undefined) return `${where}  no height`;
  return `${where}  ${place.metres.toFixed(2)} m, error up to ${place.errorM!.toPrecision(3)} m, level ${place.level}`;
}

// --- Controls. ---

/** The height at the cursor is asked for once at a time; the latest place is the one that counts. */
let asked: { x: number; y: number } | undefined;
let asking = false;
async function describeCursor(): Promise<void> {
  if (asking) return;
  asking = true;
  while (asked && view) {
    const { x, y } = asked;
    asked = undefined;
    try {
      const place = await view.placeAt(x, y);
      if (place) info.value = describe(place);
    } catch (error) {
      fail(error);
    }
  }
  asking = false;
}
globe.addEventListener("pointermove", (event) => {
  asked = { x: event.offsetX, y: event.offsetY };
  void describeCursor();
});
globe.addEventListener("pointerdown", (event) => {
  globe.focus();
  asked = { x: event.offsetX, y: event.offsetY };
  void describeCursor();
});
globe.addEventListener("keydown", (event) => {
  if (view && moveByKey(view.widget, event.key)) event.preventDefault();
});

element<HTMLFormElement>("panel").addEventListener("submit", (event) => {
  event.preventDefault();
  const text = element<HTMLInputElement>("place").value;
  const place = readPlace(text);
  if (!place) return fail(new Error(`Go to: expected a latitude and a longitude such as 46.5, 8.1, found ${text || "nothing"}`));
  message.hidden = true;
  if (stream?.camera) stream.setCamera([place.lon, place.lat, ...(stream.camera.slice(2) as [number, number, number])]);
  view?.goTo(place.lon, place.lat);
  void (view && heightAt(view.pack, place.lon, place.lat).then((height) => {
    info.value = describe({ ...place, ...height });
  }, fail));
});
show.addEventListener("change", () => showAs(show.value as Show));
hour.addEventListener("input", () => (stream ?? view)?.setHour(Number(hour.value)));
element("home").addEventListener("click", () => (stream ?? view)?.goHome());
streams.addEventListener("change", () => {
  if (packUrl !== undefined) void openUrl(packUrl);
});
element("link").addEventListener("click", () => {
  history.replaceState(null, "", currentLink());
  navigator.clipboard?.writeText(location.href).then(
    () => (info.value = "The link is copied."),
    () => (info.value = "The link is in the address bar."),
  );
});
element("picture").addEventListener("click", () => {
  const canvas = stream?.canvas ?? view?.widget.canvas;
  if (!canvas) return;
  // A canvas keeps its picture no longer than the frame, and a frame that nobody asks for is not drawn.
  view?.widget.scene.requestRender();
  view?.widget.render();
  const save = document.createElement("a");
  save.download = "cairn.png";
  save.href = canvas.toDataURL("image/png");
  save.click();
});
message.addEventListener("click", () => (message.hidden = true));

packs.addEventListener("change", () => {
  history.replaceState(null, "", writeLink({ pack: packs.value }));
  void openUrl(packs.value);
});
function openFile(file: File): void {
  streaming.hidden = true;
  streams.checked = false;
  void open(new BlobSource(file, file.name), undefined);
}
element<HTMLInputElement>("file").addEventListener("change", (event) => {
  const file = (event.target as HTMLInputElement).files?.[0];
  if (file) openFile(file);
});
addEventListener("dragover", (event) => {
  event.preventDefault();
  document.body.classList.add("dragging");
});
addEventListener("dragleave", () => document.body.classList.remove("dragging"));
addEventListener("drop", (event) => {
  event.preventDefault();
  document.body.classList.remove("dragging");
  const file = event.dataTransfer?.files[0];
  if (file) openFile(file);
});

// --- Start. ---

/** Lists the server's packs, where it is `cairn serve`, and opens the one that the link names, or the first. */
async function start(): Promise<void> {
  if (matchMedia("(max-width: 40rem)").matches) document.querySelector("details")!.open = false;
  const { pack: wanted, stream: isStreamed } = readLink(location.hash);
  let urls: { url: string; name: string; stream?: string }[] = [];
  try {
    const answer = await fetch("packs.json");
    if (answer.ok) urls = (await answer.json()) as typeof urls;
  } catch {
    // A static server has no list.
  }
  if (wanted && !urls.some((one) => one.url === wanted)) urls.unshift({ url: wanted, name: wanted });
  packs.replaceChildren(...urls.map(({ url, name }) => new Option(name, url)));
  const first = wanted ?? urls[0]?.url;
  if (first === undefined) return;
  packs.value = first;
  for (const { url, stream: drawnAt } of urls) if (drawnAt) streamUrls.set(url, drawnAt);
  streams.checked = isStreamed === true;
  await openUrl(first);
}

void start();
