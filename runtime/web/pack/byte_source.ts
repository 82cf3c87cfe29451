import { PackError } from "./errors.js";

/** The bytes of one pack, wherever it lies. */
export interface ByteSource {
  /** The file's name or address, with which each error begins. */
  readonly name: string;
  /** Returns exactly these bytes. `fresh` asks for them past any cache. */
  read(offset: number, length: number, fresh?: boolean): Promise<Uint8Array>;
  /** Returns the file's length, undefined where nothing was read yet or a server hides it. */
  size(): Promise<number | undefined>;
}

/** A pack in memory, or a file that a user chose. */
export class BlobSource implements ByteSource {
  constructor(
    private readonly blob: Blob,
    readonly name: string,
  ) {}

  async size(): Promise<number> {
    return this.blob.size;
  }

  async read(offset: number, length: number): Promise<Uint8Array> {
    if (offset + length > this.blob.size)
      throw new PackError("damaged", `${this.name}: expected ${length} bytes at ${offset}, found the file's end`);
    try {
      return new Uint8Array(await this.blob.slice(offset, offset + length).arrayBuffer());
    } catch (error) {
      // A browser refuses to read a chosen file that has changed since.
      throw new PackError("replaced", `${this.name}: cannot be read any more: ${String(error)}`);
    }
  }
}
