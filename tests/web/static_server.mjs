// A plain file server that sends ranges of bytes, as nginx does: for what works without `cairn serve`.
import { createReadStream, existsSync, statSync } from "node:fs";
import http from "node:http";
import { extname, join, normalize } from "node:path";

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm", ".json": "application/json" };

/** Serves folders by the first part of the path; returns the server and its address. */
export async function serveFolders(folders) {
  const server = http.createServer((request, answer) => {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://x").pathname));
    const [, first, ...rest] = path.split("/");
    const file = folders[first] && join(folders[first], ...(rest.join("/") === "" ? ["index.html"] : rest));
    if (!file || !existsSync(file) || !statSync(file).isFile()) return answer.writeHead(404).end();
    const { size } = statSync(file);
    const type = { "Content-Type": TYPES[extname(file)] ?? "application/octet-stream" };
    const range = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? "");
    if (!range) {
      answer.writeHead(200, { ...type, "Content-Length": size });
      return createReadStream(file).pipe(answer);
    }
    const [start, end] = [Number(range[1]), Math.min(Number(range[2]), size - 1)];
    answer.writeHead(206, { ...type, "Content-Range": `bytes ${start}-${end}/${size}`, "Content-Length": end - start + 1 });
    createReadStream(file, { start, end }).pipe(answer);
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { server, url: `http://127.0.0.1:${server.address().port}` };
}
