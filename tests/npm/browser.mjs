// Shows a page in headless Chromium from a server on this machine and returns what the page posts.
import { execFileSync, spawn } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import os from "node:os";
import path from "node:path";

const here = path.dirname(new URL(import.meta.url).pathname);
const types = { ".js": "text/javascript", ".mjs": "text/javascript", ".css": "text/css", ".json": "application/json",
                ".html": "text/html", ".wasm": "application/wasm", ".png": "image/png", ".jpg": "image/jpeg",
                ".glb": "model/gltf-binary", ".terrain": "application/vnd.quantized-mesh" };

const chromium = () => ["chromium", "chromium-browser", "google-chrome"].find((name) => {
  try { execFileSync("which", [name], { stdio: "ignore" }); return true; } catch { return false; }
});

/// Answers with a file or the range of it that was asked for.
function answer(request, response, file, data) {
  response.setHeader("Content-Type", types[path.extname(file)] ?? "application/octet-stream");
  const range = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? "");
  if (!range) return response.end(data);
  const first = Number(range[1]), last = Math.min(Number(range[2]), data.length - 1);
  response.statusCode = 206;
  response.setHeader("Content-Range", `bytes ${first}-${last}/${data.length}`);
  response.end(data.subarray(first, last + 1));
}

/// `folders` maps prefixes of addresses to folders or files; the page gets `task` at /task and posts JSON to /result. Returns
/// what it posted with `asked`, the requests below /export, and `failed`, the addresses that had no file. Ends the program
/// with SKIPPED where there is no Chromium.
export async function showPage(page, folders, task) {
  const program = chromium();
  if (!program) { console.log("SKIPPED: no Chromium is installed"); process.exit(0); }
  const failed = [];
  let asked = 0, finish;
  const result = new Promise((resolve) => { finish = resolve; });
  const server = http.createServer((request, response) => {
    const url = decodeURIComponent(request.url.split("?")[0]);
    if (url === "/task") return response.end(JSON.stringify(task));
    if (url === "/result") {
      let body = "";
      request.on("data", (d) => (body += d));
      request.on("end", () => { response.end(); finish(JSON.parse(body)); });
      return;
    }
    const prefix = Object.keys(folders).find((p) => url.startsWith(p));
    const file = url === "/" ? path.join(here, page) : prefix ? path.join(folders[prefix], url.slice(prefix.length)) : "";
    if (url.startsWith("/export")) ++asked;
    fs.readFile(file || "/nonexistent", (error, data) => {
      if (!error) return answer(request, response, file, data);
      if (url !== "/favicon.ico") failed.push(url);
      response.statusCode = 404;
      response.end();
    });
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const profile = fs.mkdtempSync(path.join(os.tmpdir(), "cairn-chromium-"));
  const browser = spawn(program, ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                                  "--window-size=960,540", `--user-data-dir=${profile}`,
                                  `http://127.0.0.1:${server.address().port}/`], { stdio: "ignore", detached: true });
  const timer = setTimeout(() => finish({ error: "no answer after 480 s" }), 480000);
  const found = await result;
  clearTimeout(timer);
  try { process.kill(-browser.pid); } catch { /* it has ended */ }
  server.close();
  server.closeAllConnections?.();
  setTimeout(() => fs.rmSync(profile, { recursive: true, force: true }), 500);
  return { ...found, asked, failed };
}

/// Writes the picture that a canvas gave as a data URL.
export function writePicture(file, url) {
  if (file && url) fs.writeFileSync(file, Buffer.from(url.split(",")[1], "base64"));
}
