// The page in headless Chromium, against `cairn serve` behind 80 ms of latency. Environment: CAIRN, the program;
// CAIRN_PACK, a pack with heights and imagery; CAIRN_MODULES, a folder with puppeteer-core; CAIRN_PICTURES, where
// pictures go (optional); CAIRN_WASM, the built page.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { copyFileSync, existsSync, mkdtempSync, readFileSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, before, test } from "node:test";
import { SlowProxy } from "./slow_proxy.mjs";
import { serveFolders } from "./static_server.mjs";

const { CAIRN: cairn, CAIRN_PACK: packPath, CAIRN_MODULES: modules, CAIRN_PICTURES: pictures } = process.env;
const chromium = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);
const puppeteer = createRequire(join(modules, "package.json"))("puppeteer-core");

const LATENCY_MS = 80;
const MOST_BYTES = 3e6;
const MOST_REQUESTS = 60;
const PATIENCE_MS = 240000; // a software renderer on a busy machine

let browser, folder, pack;
let mountains; // a pack of the sample, which no test changes
const running = [];

/** Starts `cairn serve` with packs and options; returns its port and process. */
async function serve(...packs) {
  const server = spawn(cairn, ["serve", ...packs, "--port", "0"], { stdio: ["ignore", "pipe", "inherit"] });
  running.push(server);
  const url = await new Promise((resolve) => server.stdout.once("data", (data) => resolve(String(data).trim())));
  return { server, port: new URL(url).port };
}

/** Opens the page; `errors` gets what the console shows as errors. */
async function openPage(url, viewport = { width: 960, height: 540 }) {
  const page = await browser.newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  await page.setViewport(viewport);
  const errors = [];
  page.on("console", (line) => line.type() === "error" && errors.push(line.text()));
  page.on("pageerror", (error) => errors.push(String(error)));
  await page.goto(url);
  return { page, errors };
}

function headerOf(path) {
  return { indexOffset: Number(readFileSync(path).readBigUInt64LE(120)) };
}

/** Waits until all tiles of the view are there. */
async function settled(page) {
  await page.waitForFunction(
    () => {
      const view = globalThis.cairn?.view;
      if (!view) return false;
      view.widget.scene.requestRender();
      return view.widget.scene.globe.tilesLoaded && document.getElementById("progress").hidden;
    },
    { polling: 200 },
  );
}

async function messageOf(page) {
  await page.waitForFunction(() => !document.getElementById("message").hidden);
  return page.$eval("#message", (element) => element.textContent);
}

before(async () => {
  folder = mkdtempSync(join(tmpdir(), "cairn-browser-"));
  pack = join(folder, "pack.cairn");
  copyFileSync(packPath, pack);
  mountains = join(folder, "mountains.cairn");
  execFileSync(cairn, ["bake", join(process.env.CAIRN_SOURCE, "sample-dem/jacksboro_fault.tif"), "-o", mountains]);
  browser = await puppeteer.launch({
    executablePath: chromium,
    headless: true,
    protocolTimeout: PATIENCE_MS,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-background-networking", "--disable-component-update"],
  });
});

after(async () => {
  await browser?.close();
  for (const server of running) server.kill();
  rmSync(folder, { recursive: true });
});

test("the first view: bytes, requests, no error; heights bit for bit; controls", async () => {
  const { port } = await serve(pack);
  const proxy = new SlowProxy(port, LATENCY_MS);
  const url = await proxy.listen();
  const outside = [];
  const { page, errors } = await openPage("about:blank");
  page.on("request", (request) => {
    if (!request.url().startsWith(url) && !/^(blob|data|about):/.test(request.url())) outside.push(request.url());
  });
  const begin = Date.now();
  await page.goto(url);
  await settled(page);
  const first = { ...proxy.packs };
  console.log(`first view: ${first.requests} requests and ${first.bytes} bytes of the pack, ${Date.now() - begin} ms`);
  const counts = await page.evaluate(() => globalThis.cairn.view.imageryProvider.counts);
  console.log(`imagery tiles: ${counts.copied} copied as blocks, ${counts.decoded} decoded`);
  const picture = await page.screenshot({ path: pictures && join(pictures, "browser.png") });
  assert.ok(first.bytes <= MOST_BYTES, `${first.bytes} bytes`);
  assert.ok(first.requests <= MOST_REQUESTS, `${first.requests} requests`);
  assert.ok(counts.copied > 0);
  assert.ok(picture.length > 30000, "a picture of something");
  assert.deepEqual(outside, []);

  // Heights.
  const bounds = await page.evaluate(() => globalThis.cairn.pack.metadata.bounds);
  let state = 5;
  const random = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
  const places = Array.from({ length: 1000 }, () => [
    bounds.west + random() * (bounds.east - bounds.west),
    bounds.south + random() * (bounds.north - bounds.south),
  ]);
  const inPage = await page.evaluate(async (places) => {
    const { heightAt, pack } = globalThis.cairn;
    const out = [];
    for (const [lon, lat] of places) out.push((await heightAt(pack, lon, lat))?.metres ?? null);
    return out;
  }, places);
  const table = "lon,lat\n" + places.map(([lon, lat]) => `${lon},${lat}\n`).join("");
  const sampled = JSON.parse(execFileSync(cairn, ["sample", pack, "--points", "-", "--json"], { input: table, maxBuffer: 1 << 26 }));
  assert.deepEqual(inPage, sampled.map((one) => one.height));
  assert.ok(inPage.filter((height) => height !== null).length > 300);

  // The globe that is drawn is the pack's surface within what its level is off.
  const drawn = await page.evaluate(() => {
    const { view, Cesium } = globalThis.cairn;
    const { scene, camera, canvas } = view.widget;
    const out = [];
    for (let i = 1; i < 10; ++i) {
      const ray = camera.getPickRay(new Cesium.Cartesian2((canvas.clientWidth * i) / 10, canvas.clientHeight * 0.6));
      const point = scene.globe.pick(ray, scene);
      if (!point) continue;
      const place = Cesium.Cartographic.fromCartesian(point);
      out.push([Cesium.Math.toDegrees(place.longitude), Cesium.Math.toDegrees(place.latitude), place.height]);
    }
    return out;
  });
  assert.ok(drawn.length > 2);
  const worst = await page.evaluate(() => {
    const { view } = globalThis.cairn;
    return view.terrain.levelErrorM(0);
  });
  const under = await page.evaluate(async (places) => {
    const { heightAt, pack } = globalThis.cairn;
    return Promise.all(places.map(async ([lon, lat]) => (await heightAt(pack, lon, lat))?.metres ?? 0));
  }, drawn);
  for (const [i, [lon, lat, height]] of drawn.entries())
    assert.ok(Math.abs(height - under[i]) <= worst, `${lon} ${lat}: drawn ${height} m, the pack has ${under[i]} m`);

  // Controls.
  await page.type("#place", `${(bounds.south + bounds.north) / 2}, ${(bounds.west + bounds.east) / 2}`);
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => /° [NS]/.test(document.getElementById("place-info").value));
  assert.match(await page.$eval("#place-info", (e) => e.value), / m, error up to .* m, level /);
  await page.select("#show", "level");
  await settled(page);
  assert.ok((await page.$$("#legend li")).length > 0);
  if (pictures) await page.screenshot({ path: join(pictures, "browser-levels.png") });
  await page.select("#show", "error");
  await settled(page);
  if (pictures) await page.screenshot({ path: join(pictures, "browser-errors.png") });
  await page.select("#show", "imagery");
  await page.focus("#globe");
  const cameraBefore = await page.evaluate(() => globalThis.cairn.view.widget.camera.positionCartographic.height);
  await page.keyboard.press("-");
  assert.ok((await page.evaluate(() => globalThis.cairn.view.widget.camera.positionCartographic.height)) > cameraBefore);
  await page.click("#link");
  const link = await page.evaluate(() => location.href);
  assert.match(link, /#pack=packs\/pack\.cairn&camera=/);
  await page.type("#place", " nonsense");
  await page.keyboard.press("Enter");
  assert.match(await messageOf(page), /expected a latitude and a longitude/);
  assert.deepEqual(errors, []);
  await page.close();

  // A link leads to its view, on a phone too.
  const phone = await openPage(link, { width: 375, height: 700, isMobile: true, hasTouch: true });
  await settled(phone.page);
  const camera = /camera=([^&]*)/.exec(link)[1];
  assert.equal(/camera=([^&]*)/.exec(await phone.page.evaluate(() => location.href))[1], camera);
  assert.ok(await phone.page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
  await phone.page.touchscreen.tap(180, 500);
  if (pictures) await phone.page.screenshot({ path: join(pictures, "browser-phone.png") });
  assert.deepEqual(phone.errors, []);

  // A file that the user chooses.
  const input = await phone.page.$("#file");
  await phone.page.evaluate(() => (globalThis.cairn = undefined));
  await input.uploadFile(pack);
  await phone.page.waitForFunction(() => globalThis.cairn?.pack.source.name === "pack.cairn");
  await settled(phone.page);
  assert.deepEqual(phone.errors, []);
  await phone.page.close();
  proxy.close();
});

test("the page flies over a pack from a plain file server; a file that is no pack is said in words", async () => {
  const { server, url } = await serveFolders({ web: process.env.CAIRN_WASM, packs: folder });
  const { page } = await openPage(`${url}/web/#pack=../packs/pack.cairn`);
  await page.waitForFunction(() => globalThis.cairn?.pack.header.tileSize > 0);
  assert.equal(await page.evaluate(() => globalThis.cairn.pack.source.counts.requests > 0), true);
  await page.goto("about:blank");
  await page.goto(`${url}/web/#pack=style.css`);
  assert.match(await messageOf(page), /style\.css: expected bytes 0-16383, found a file of \d+ bytes/);
  await page.close();
  server.closeAllConnections();
  server.close();
});

/** Reads a block of heights in the page, past what is kept; returns the error's kind and words. */
function readBlock(page) {
  return page.evaluate(async () => {
    const { pack } = globalThis.cairn;
    const entries = await pack.entriesOfLevel(0, pack.levelRange(0).finest, 1e6);
    try {
      await pack.readChecked(entries.find((entry) => !entry.constant), "heights");
      return "no error";
    } catch (error) {
      return `${error.kind}: ${error.message}`;
    }
  });
}

test("a damaged tile, a file that is replaced and a server that dies are said in words", async () => {
  const { server, port } = await serve(pack);
  const proxy = new SlowProxy(port, 0);
  const url = await proxy.listen();

  // Blocks only: header, root, index and metadata stay as they are.
  const { indexOffset } = headerOf(pack);
  proxy.spoil = (bytes, first) => {
    const copy = Buffer.from(bytes);
    if (first >= 16384 && first < indexOffset) for (let i = 0; i < copy.length; i += 100) copy[i] ^= 1;
    return copy;
  };
  const damaged = await openPage(url);
  assert.match(await messageOf(damaged.page), /pack\.cairn: .* expected its checksum, found another/);
  await damaged.page.close();
  proxy.spoil = undefined;

  const replaced = await openPage(url);
  await settled(replaced.page);
  assert.equal(await readBlock(replaced.page), "no error");
  const other = join(folder, "other.cairn");
  copyFileSync(mountains, other);
  renameSync(other, pack);
  assert.match(await readBlock(replaced.page), /^replaced: .*another one now/);
  await replaced.page.close();

  const dying = await openPage(url);
  await settled(dying.page);
  assert.equal(await readBlock(dying.page), "no error");
  server.kill("SIGKILL");
  assert.match(await readBlock(dying.page), /^network: .*cannot be reached/);
  await dying.page.close();
  proxy.close();
});

const drawsPictures = existsSync(join(dirname(cairn), "cairn-stream")) || existsSync(join(dirname(cairn), "../lib/cairn/cairn-stream"));
/** In a page: the first row from above in each column of a picture that is no sky; its height where all is sky. */
async function skylineOf(png, sky) {
  const picture = await createImageBitmap(await (await fetch(png)).blob());
  const canvas = new OffscreenCanvas(picture.width, picture.height);
  const context = canvas.getContext("2d");
  context.drawImage(picture, 0, 0);
  const { data, width, height } = context.getImageData(0, 0, picture.width, picture.height);
  const isSky = (x, y) => sky.every((value, i) => Math.abs(data[4 * (y * width + x) + i] - value) <= 40);
  const rows = [];
  for (let x = 0; x < width; ++x) {
    let y = 0;
    while (y < height && isSky(x, y)) ++y;
    rows.push(y);
  }
  return rows;
}

/** Returns the row of each column at which the bare ellipsoid's horizon is, which CesiumJS draws where no tile is. */
function horizonRows(width, height, fovDegrees, metres, pitchDegrees) {
  const radians = (degrees) => (degrees * Math.PI) / 180;
  const dip = Math.acos(6371e3 / (6371e3 + metres));
  const pixel = (2 * Math.tan(radians(fovDegrees) / 2)) / height;
  const [sine, cosine] = [Math.sin(radians(pitchDegrees)), Math.cos(radians(pitchDegrees))];
  return Array.from({ length: width }, (_, column) => {
    const x = (column + 0.5 - width / 2) * pixel;
    const isAbove = (row) => {
      const y = (height / 2 - row - 0.5) * pixel;
      return Math.atan2(sine + y * cosine, Math.hypot(x, cosine - y * sine)) > -dip;
    };
    let row = 0;
    while (row < height && isAbove(row)) ++row;
    return row;
  });
}

test("mountains stand where the project's own renderer draws them", { skip: !drawsPictures && "SKIPPED: built without the viewer" }, async () => {
  const [width, height] = [960, 540];
  const magenta = [255, 0, 255];
  const { port } = await serve(mountains);
  const { page } = await openPage(`http://127.0.0.1:${port}/`, { width, height });
  await settled(page);
  // From a valley: ridges 2 km away and farther, up to 11 degrees above the eye.
  const camera = [-84.205, 36.484, 640, 240, 3];
  const { drawn, fovDegrees } = await page.evaluate(async ([lon, lat, metres, heading, pitch]) => {
    const { view, Cesium } = globalThis.cairn;
    const { scene, camera, canvas } = view.widget;
    for (const sky of [scene.skyAtmosphere, scene.sun]) if (sky) sky.show = false;
    scene.backgroundColor = Cesium.Color.MAGENTA;
    scene.fog.enabled = false;
    scene.globe.maximumScreenSpaceError = 1;
    view.show("relief");
    const [h, p] = [heading, pitch].map(Cesium.Math.toRadians);
    camera.setView({ destination: Cesium.Cartesian3.fromDegrees(lon, lat, metres), orientation: { heading: h, pitch: p, roll: 0 } });
    // Tiles that a frame finds missing are asked for after it, so that one frame without any is not enough.
    for (let loaded = 0; loaded < 10; ) {
      scene.requestRender();
      view.widget.render();
      await new Promise((done) => setTimeout(done, 100));
      loaded = scene.globe.tilesLoaded ? loaded + 1 : 0;
    }
    scene.requestRender(); // without it nothing is drawn, and the canvas keeps no picture
    view.widget.render();
    return { drawn: canvas.toDataURL("image/png"), fovDegrees: Cesium.Math.toDegrees(camera.frustum.fovy) };
  }, camera);
  const shot = join(folder, "shot.png");
  execFileSync(cairn, ["view", mountains, `--camera=${camera.join(",")}`, "--size", `${width}x${height}`, "--fov", String(fovDegrees), "--hole-colour", "magenta", "--samples", "1", "--tolerance", "0.25", "--no-fog", "--screenshot", shot]);
  const expected = `data:image/png;base64,${readFileSync(shot).toString("base64")}`;
  const [ours, alone] = await Promise.all([drawn, expected].map((png) => page.evaluate(skylineOf, png, magenta)));
  const saved = await page.evaluate(() => {
    let picture;
    HTMLAnchorElement.prototype.click = function () {
      picture = this.href;
    };
    document.getElementById("picture").click();
    return picture;
  });
  assert.deepEqual(await page.evaluate(skylineOf, saved, magenta), ours, "Save picture saves what is shown");
  const horizon = horizonRows(width, height, fovDegrees, camera[2], camera[4]);
  const theirs = alone.map((row, x) => Math.min(row, horizon[x]));
  if (pictures) {
    copyFileSync(shot, join(pictures, "skyline-view.png"));
    writeFileSync(join(pictures, "skyline-browser.png"), Buffer.from(drawn.split(",")[1], "base64"));
  }
  assert.equal(ours.length, theirs.length);
  assert.ok(Math.max(...theirs) - Math.min(...theirs) > 20, "mountains in the picture");
  // At a cliff of the skyline a column's neighbours count, too: 2 pixels are to the side as well.
  const off = ours.filter((row, x) => {
    const near = theirs.slice(Math.max(0, x - 2), x + 3);
    return row < Math.min(...near) - 2 || row > Math.max(...near) + 2;
  });
  console.log(`skyline: ${off.length} of ${width} columns are more than 2 pixels off`);
  assert.equal(off.length, 0);
  await page.close();
});

test("where a browser has no WebGL the server draws, keys steer it, and the globe takes its camera over", { skip: !drawsPictures && "SKIPPED: built without the viewer" }, async () => {
  const { port } = await serve(mountains, "--stream");
  const { page, errors } = await openPage("about:blank", { width: 800, height: 450 });
  await page.evaluateOnNewDocument(() => {
    const { getContext } = HTMLCanvasElement.prototype;
    HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
      return kind === "webgl2" && !globalThis.hasWebGl ? null : getContext.call(this, kind, ...rest);
    };
  });
  await page.goto(`http://127.0.0.1:${port}/`);
  const isWhole = () => globalThis.cairn?.figures?.complete;
  await page.waitForFunction(isWhole, { polling: 100 });
  const size = await page.$eval("#globe canvas", (canvas) => [canvas.width, canvas.height]);
  assert.deepEqual(size, [800, 450]);
  const colours = await page.$eval("#globe canvas", (canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  });
  assert.ok(colours > 1000, `${colours} colours`);
  if (pictures) await page.screenshot({ path: join(pictures, "browser-stream.png") });

  const before = await page.evaluate(() => globalThis.cairn.stream.camera);
  await page.focus("#globe");
  await page.keyboard.down("KeyW");
  await page.waitForFunction((lat) => globalThis.cairn.stream.camera[1] > lat, { polling: 50 }, before[1]);
  await page.keyboard.up("KeyW");
  await page.waitForFunction(() => globalThis.cairn.figures.latencyMs > 0, { polling: 50 });
  assert.match(await page.$eval("#place-info", (info) => info.value), /^800×450, \d+ frames\/s, [\d.]+ Mbit\/s, drawn in \d+ ms, \d+ ms from a key/);

  await page.type("#place", "36.4, -84.3");
  await page.click("#panel button[type=submit]");
  await page.waitForFunction(() => Math.abs(globalThis.cairn.stream.camera[0] + 84.3) < 0.01, { polling: 50 });
  assert.match(page.url(), /draw=server/);

  await page.evaluate(() => (globalThis.hasWebGl = true));
  await page.click("#stream");
  await settled(page);
  const [lon, lat] = await page.evaluate(() => {
    const { longitude, latitude } = globalThis.cairn.view.widget.camera.positionCartographic;
    return [longitude, latitude].map((angle) => (angle * 180) / Math.PI);
  });
  assert.ok(Math.abs(lon + 84.3) < 0.01 && Math.abs(lat - 36.4) < 0.01, `${lon}, ${lat}`);
  assert.deepEqual(errors, []);
  await page.close();
});

test("a server that stops drawing is said in words", { skip: !drawsPictures && "SKIPPED: built without the viewer" }, async () => {
  const { server, port } = await serve(mountains, "--stream");
  const { page } = await openPage(`http://127.0.0.1:${port}/#draw=server`, { width: 320, height: 180 });
  await page.waitForFunction(() => globalThis.cairn?.figures, { polling: 100 });
  server.kill();
  assert.match(await messageOf(page), /server has ended the stream/);
  await page.close();
});
