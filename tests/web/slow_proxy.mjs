// A proxy before `cairn serve` that adds a network's latency, counts, and spoils answers when it is told to.
import http from "node:http";

export class SlowProxy {
  constructor(port, latencyMs) {
    this.target = port;
    this.latencyMs = latencyMs;
    this.packs = { requests: 0, bytes: 0 };
    this.spoil = undefined; // (bytes, first) => bytes, for answers of packs
    this.server = http.createServer((request, answer) => setTimeout(() => this.forward(request, answer), latencyMs));
  }

  listen() {
    return new Promise((resolve) =>
      this.server.listen(0, "127.0.0.1", () => resolve(`http://127.0.0.1:${this.server.address().port}`)),
    );
  }

  forward(request, answer) {
    const onward = http.request(
      { host: "127.0.0.1", port: this.target, path: request.url, method: request.method, headers: request.headers },
      (from) => {
        const parts = [];
        from.on("data", (part) => parts.push(part));
        from.on("end", () => {
          let body = Buffer.concat(parts);
          if (request.url.startsWith("/packs/")) {
            ++this.packs.requests;
            this.packs.bytes += body.length;
            const range = /^bytes (\d+)-/.exec(from.headers["content-range"] ?? "");
            if (this.spoil && range) body = this.spoil(body, Number(range[1]));
          }
          answer.writeHead(from.statusCode, from.headers);
          answer.end(body);
        });
        from.on("error", () => answer.destroy());
      },
    );
    onward.on("error", () => answer.destroy());
    request.pipe(onward);
  }

  close() {
    this.server.closeAllConnections();
    this.server.close();
  }
}
