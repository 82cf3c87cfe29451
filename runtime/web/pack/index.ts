/** @cairn/pack: reads cairn packs by ranges of bytes, in browsers and in Node. docs/browser.md explains it. */
export { BlobSource, type ByteSource } from "./byte_source.js";
export { Decoder, hasSimd } from "./decoder.js";
export { PackError, type PackErrorKind } from "./errors.js";
export * from "./grid.js";
export { HttpSource, type HttpOptions } from "./http_source.js";
export { type Entry, type HeightTile, imageBytes, Pack, type PackHeader, type PackLevel, type TextureTile } from "./pack.js";
export { type Height, heightAt } from "./sampler.js";
