import { ZSTDDecoder } from "zstddec";

/** One row of a page of the index: an entry, or in a branch a page beneath it. */
export interface PageRow {
  key: bigint;
  offset: number;
  bytes: number;
  checksum: Uint8Array;
  flags: number;
  minimum: number;
  maximum: number;
  errorM: number;
  filled: number;
}

export interface Page {
  height: number;
  keys: BigUint64Array;
  rows: PageRow[];
}

export interface DecodedHeights {
  /** By row from the south, in quanta. */
  samples: Int32Array;
  /** 1 where a sample is void; absent where none is. */
  voids?: Uint8Array;
}

interface Exports {
  memory: WebAssembly.Memory;
  _initialize?(): void;
  malloc(bytes: number): number;
  free(at: number): void;
  cairn_error(): number;
  cairn_error_bytes(): number;
  cairn_has_checksum(at: number, bytes: number, sum: number): number;
  cairn_check_start(at: number, bytes: number): number;
  cairn_decode_page(at: number, bytes: number, rows: number, height: number): number;
  cairn_decode_heights(at: number, bytes: number, size: number, samples: number, voids: number): number;
  cairn_decode_image(format: number, at: number, bytes: number, width: number, height: number, rgba: number): number;
}

const ROW_BYTES = 64;
const MOST_ROWS = 1024;

/** A module with one function that uses v128: valid only where the engine has SIMD. */
const SIMD_PROBE = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
]);

/** Returns whether the engine runs the module's SIMD version. */
export function hasSimd(): boolean {
  return WebAssembly.validate(SIMD_PROBE);
}

/**
 * The checks and decoders of the format, in WebAssembly: those of the program, compiled from the same source. All
 * functions are synchronous. A RangeError says what is wrong with the bytes.
 */
export class Decoder {
  private constructor(
    private readonly wasm: Exports,
    private readonly zstd: ZSTDDecoder,
  ) {}

  /** Compiles the module: cairn-pack-simd.wasm where hasSimd(), else cairn-pack.wasm. */
  static async create(module: BufferSource | Promise<BufferSource>): Promise<Decoder> {
    const zstd = new ZSTDDecoder();
    await zstd.init();
    let wasm: Exports | undefined;
    const view = () => new Uint8Array(wasm!.memory.buffer);
    const unzstd = (frame: number, frameBytes: number, out: number, outBytes: number): number => {
      const plain = zstd.decode(view().slice(frame, frame + frameBytes), outBytes);
      if (plain.length !== outBytes) return 0;
      view().set(plain, out);
      return 1;
    };
    // What a C library may import and these functions never call.
    const nothing = new Proxy({}, { get: () => () => 0, has: () => true });
    const env = new Proxy({ cairn_unzstd: unzstd } as Record<string, unknown>, {
      get: (known, name: string) => known[name] ?? (() => 0),
      has: () => true,
    });
    const { instance } = await WebAssembly.instantiate(await module, {
      env: env as WebAssembly.ModuleImports,
      wasi_snapshot_preview1: nothing,
    });
    wasm = instance.exports as unknown as Exports;
    wasm._initialize?.();
    return new Decoder(wasm, zstd);
  }

  hasChecksum(bytes: Uint8Array, sum: Uint8Array): boolean {
    return this.withBytes(bytes, (at) => {
      const sumAt = this.put(sum);
      const equal = this.wasm.cairn_has_checksum(at, bytes.length, sumAt) !== 0;
      this.wasm.free(sumAt);
      return equal;
    });
  }

  /** Checks header and root, the first 16 KiB. */
  checkStart(bytes: Uint8Array): void {
    this.withBytes(bytes, (at) => this.must(this.wasm.cairn_check_start(at, bytes.length)));
  }

  decodePage(bytes: Uint8Array): Page {
    return this.withBytes(bytes, (at) => {
      const rowsAt = this.wasm.malloc(MOST_ROWS * ROW_BYTES + 8);
      const heightAt = rowsAt + MOST_ROWS * ROW_BYTES;
      try {
        const count = this.must(this.wasm.cairn_decode_page(at, bytes.length, rowsAt, heightAt)) - 1;
        const view = new DataView(this.wasm.memory.buffer, rowsAt);
        const rows = Array.from({ length: count }, (_, i) => readRow(view, i * ROW_BYTES));
        return {
          height: view.getInt32(MOST_ROWS * ROW_BYTES, true),
          keys: BigUint64Array.from(rows, (row) => row.key),
          rows,
        };
      } finally {
        this.wasm.free(rowsAt);
      }
    });
  }

  decodeHeights(block: Uint8Array, size: number): DecodedHeights {
    return this.withBytes(block, (at) => {
      const count = size * size;
      const out = this.wasm.malloc(5 * count);
      try {
        const kind = this.must(this.wasm.cairn_decode_heights(at, block.length, size, out, out + 4 * count));
        const samples = new Int32Array(this.wasm.memory.buffer, out, count).slice();
        if (kind === 1) return { samples };
        return { samples, voids: new Uint8Array(this.wasm.memory.buffer, out + 4 * count, count).slice() };
      } finally {
        this.wasm.free(out);
      }
    });
  }

  /** Returns the content of one zstd frame, which must have this many bytes. */
  decodeFrame(frame: Uint8Array, bytes: number): Uint8Array {
    const plain = this.zstd.decode(frame, bytes);
    if (plain.length !== bytes) throw new RangeError(`zstd frame: expected content of ${bytes} bytes, found another`);
    return plain;
  }

  /** Decodes a block-compressed image, format 1, 3 or 7, to RGBA. */
  decodeImage(format: number, blocks: Uint8Array, width: number, height: number): Uint8ClampedArray {
    return this.withBytes(blocks, (at) => {
      const out = this.wasm.malloc(4 * width * height);
      try {
        this.must(this.wasm.cairn_decode_image(format, at, blocks.length, width, height, out));
        return new Uint8ClampedArray(this.wasm.memory.buffer, out, 4 * width * height).slice();
      } finally {
        this.wasm.free(out);
      }
    });
  }

  private put(bytes: Uint8Array): number {
    const at = this.wasm.malloc(Math.max(bytes.length, 1));
    if (at === 0) throw new RangeError("WebAssembly: expected memory for a tile, found none");
    new Uint8Array(this.wasm.memory.buffer).set(bytes, at);
    return at;
  }

  private withBytes<T>(bytes: Uint8Array, use: (at: number) => T): T {
    const at = this.put(bytes);
    try {
      return use(at);
    } finally {
      this.wasm.free(at);
    }
  }

  private must(result: number): number {
    if (result !== 0) return result;
    const text = new Uint8Array(this.wasm.memory.buffer, this.wasm.cairn_error(), this.wasm.cairn_error_bytes());
    throw new RangeError(new TextDecoder().decode(text.slice()));
  }
}

/** The fields of `Row` in wasm/pack_module.cpp. */
function readRow(view: DataView, at: number): PageRow {
  return {
    key: view.getBigUint64(at, true),
    offset: Number(view.getBigUint64(at + 8, true)),
    checksum: new Uint8Array(view.buffer, view.byteOffset + at + 16, 8).slice(),
    bytes: view.getUint32(at + 32, true),
    flags: view.getUint32(at + 36, true),
    minimum: view.getInt32(at + 40, true),
    maximum: view.getInt32(at + 44, true),
    errorM: view.getFloat32(at + 48, true),
    filled: view.getUint32(at + 52, true),
  };
}
