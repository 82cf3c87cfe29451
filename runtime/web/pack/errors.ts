/** Why a pack cannot be read. */
export type PackErrorKind =
  | "network" // no answer after all tries; another try later may succeed
  | "refused" // the server's answer: not found, no ranges of bytes
  | "damaged" // bytes that are not what the pack states
  | "replaced"; // the file is another one than when the pack was opened

/** An error of one line that begins with the pack's name: "PACK: PLACE: expected X, found Y". */
export class PackError extends Error {
  constructor(
    readonly kind: PackErrorKind,
    message: string,
  ) {
    super(message);
    this.name = "PackError";
  }
}
