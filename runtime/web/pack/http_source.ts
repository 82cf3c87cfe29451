import type { ByteSource } from "./byte_source.js";
import { PackError } from "./errors.js";

export interface HttpOptions {
  /** Of a request that may succeed at another try. */
  attempts?: number;
  /** The pause before the second attempt in seconds; it doubles, up to 3 s. */
  firstPauseS?: number;
  /** Of one attempt, in seconds. */
  timeoutS?: number;
  /** Requests at once. */
  parallel?: number;
  /** Bytes between two wanted ranges that are rather read than asked around. */
  gapBytes?: number;
  /** Bytes of a request that serves several ranges. */
  mostBytes?: number;
  fetch?: typeof fetch;
}

interface Wanted {
  offset: number;
  length: number;
  resolve(bytes: Uint8Array): void;
  reject(error: unknown): void;
}

/** What was asked for and came. */
export interface HttpCounts {
  requests: number;
  bytes: number;
  retries: number;
}

/**
 * A pack on a server that sends ranges of bytes. Ranges that are wanted at one time and lie near each other are
 * asked for in one request. A file that is replaced meanwhile is told by its length or its entity tag.
 */
export class HttpSource implements ByteSource {
  readonly name: string;
  readonly counts: HttpCounts = { requests: 0, bytes: 0, retries: 0 };
  private readonly options: Required<HttpOptions>;
  private total: number | undefined;
  private etag: string | null = null;
  private waiting: Wanted[] = [];
  private running = 0;
  private scheduled = false;

  constructor(url: string, options: HttpOptions = {}) {
    this.name = url;
    this.options = {
      attempts: 5,
      firstPauseS: 0.1,
      timeoutS: 30,
      parallel: 6,
      gapBytes: 32 << 10,
      mostBytes: 1 << 20,
      fetch: (input, init) => globalThis.fetch(input, init),
      ...options,
    };
  }

  async size(): Promise<number | undefined> {
    return this.total;
  }

  read(offset: number, length: number, fresh = false): Promise<Uint8Array> {
    if (fresh) return this.ask(offset, length, true);
    return new Promise((resolve, reject) => {
      this.waiting.push({ offset, length, resolve, reject });
      this.schedule();
    });
  }

  /** Starts requests when all that is wanted at this time is known. */
  private schedule(): void {
    if (this.scheduled) return;
    this.scheduled = true;
    setTimeout(() => {
      this.scheduled = false;
      while (this.running < this.options.parallel && this.waiting.length > 0) void this.serve(this.takeRun());
    }, 0);
  }

  /** Takes the range that waits longest and those near it. */
  private takeRun(): Wanted[] {
    const first = this.waiting[0]!;
    const sorted = [...this.waiting].sort((a, b) => a.offset - b.offset);
    let from = sorted.indexOf(first);
    let to = from;
    let begin = first.offset;
    let end = first.offset + first.length;
    const { gapBytes, mostBytes } = this.options;
    for (; to + 1 < sorted.length; ++to) {
      const next = sorted[to + 1]!;
      const grown = Math.max(end, next.offset + next.length);
      if (next.offset > end + gapBytes || grown - begin > mostBytes) break;
      end = grown;
    }
    for (; from > 0; --from) {
      const before = sorted[from - 1]!;
      if (before.offset + before.length + gapBytes < begin || end - before.offset > mostBytes) break;
      begin = before.offset;
    }
    const run = sorted.slice(from, to + 1);
    this.waiting = this.waiting.filter((one) => !run.includes(one));
    return run;
  }

  private async serve(run: Wanted[]): Promise<void> {
    ++this.running;
    const begin = run[0]!.offset;
    const end = Math.max(...run.map((one) => one.offset + one.length));
    try {
      const bytes = await this.ask(begin, end - begin, false);
      for (const one of run) one.resolve(bytes.subarray(one.offset - begin, one.offset - begin + one.length));
    } catch (error) {
      for (const one of run) one.reject(error);
    } finally {
      --this.running;
      if (this.waiting.length > 0) this.schedule();
    }
  }

  private async ask(offset: number, length: number, fresh: boolean): Promise<Uint8Array> {
    let pause = this.options.firstPauseS;
    for (let attempt = 1; ; ++attempt) {
      try {
        return await this.attempt(offset, length, fresh);
      } catch (error) {
        const again = error instanceof PackError && error.kind === "network";
        if (!again || attempt >= this.options.attempts) throw error;
        ++this.counts.retries;
        await new Promise((resolve) => setTimeout(resolve, pause * 1000));
        pause = Math.min(2 * pause, 3);
      }
    }
  }

  private async attempt(offset: number, length: number, fresh: boolean): Promise<Uint8Array> {
    const last = offset + length - 1;
    const stop = new AbortController();
    const timer = setTimeout(() => stop.abort(), this.options.timeoutS * 1000);
    try {
      ++this.counts.requests;
      const answer = await this.options.fetch(this.name, {
        headers: { Range: `bytes=${offset}-${last}` },
        cache: fresh ? "reload" : "default",
        signal: stop.signal,
      });
      try {
        this.check(answer, offset, last);
      } catch (error) {
        stop.abort(); // the rest of the answer is not wanted
        throw error;
      }
      const bytes = new Uint8Array(await answer.arrayBuffer());
      this.counts.bytes += bytes.length;
      if (bytes.length !== length)
        throw new PackError("network", `${this.name}: expected ${length} bytes at ${offset}, found ${bytes.length}`);
      return bytes;
    } catch (error) {
      if (error instanceof PackError) throw error;
      const why = stop.signal.aborted ? `no answer in ${this.options.timeoutS} s` : String(error);
      throw new PackError("network", `${this.name}: cannot be reached: ${why}`);
    } finally {
      clearTimeout(timer);
    }
  }

  /** Refuses an answer that is not the range, or is one of another file than the first answer's. */
  private check(answer: Response, offset: number, last: number): void {
    const { status } = answer;
    if (status === 429 || status >= 500)
      throw new PackError("network", `${this.name}: expected bytes, found the server's error ${status}`);
    if (status === 412) throw new PackError("replaced", `${this.name}: the file is another one now`);
    if (status === 200)
      throw new PackError("refused", `${this.name}: expected a range of bytes, found the whole file: the server sends no ranges`);
    if (status === 416 && this.total !== undefined)
      throw new PackError("replaced", `${this.name}: the file is another one now, and shorter`);
    if (status !== 206) throw new PackError("refused", `${this.name}: expected bytes, found the answer ${status}`);
    // A server of another origin may hide the field; then only the number of bytes is known.
    const range = /^bytes (\d+)-(\d+)\/(\d+)$/.exec(answer.headers.get("Content-Range") ?? "");
    if (range) {
      const total = Number(range[3]);
      if (Number(range[1]) !== offset || (Number(range[2]) !== last && last < total))
        throw new PackError("refused", `${this.name}: expected bytes ${offset}-${last}, found ${range[1]}-${range[2]}`);
      if (last >= total)
        throw new PackError("damaged", `${this.name}: expected bytes ${offset}-${last}, found a file of ${total} bytes`);
      if (this.total !== undefined && this.total !== total)
        throw new PackError("replaced", `${this.name}: the file is another one now, of ${total} bytes`);
      this.total = total;
    }
    const etag = answer.headers.get("ETag");
    if (etag && !etag.startsWith("W/")) {
      if (this.etag !== null && this.etag !== etag)
        throw new PackError("replaced", `${this.name}: the file is another one now`);
      this.etag = etag;
    }
  }
}
