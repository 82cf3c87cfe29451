// Builds the page: node build.mjs WORK OUT, where WORK has node_modules as npm ci installs them. Writes to OUT the page, the
// module @cairn/pack by itself, CesiumJS, and the licences of all that is shipped.
import { cpSync, mkdirSync, readFileSync, symlinkSync, writeFileSync, rmSync, existsSync } from "node:fs";
import { createRequire } from "node:module";
import { execFileSync } from "node:child_process";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const [work, out] = process.argv.slice(2).map((path) => resolve(path));
const here = dirname(fileURLToPath(import.meta.url));
const modules = join(work, "node_modules");
const { build } = createRequire(join(work, "package.json"))("esbuild");

// 0. A function that the modules lack would be a silent import: what they import is known.
const known = ["cairn_unzstd", "emscripten_notify_memory_growth", "proc_exit", "fd_close", "fd_write", "fd_seek"];
for (const name of ["cairn-pack.wasm", "cairn-pack-simd.wasm"])
  for (const { name: wanted } of WebAssembly.Module.imports(new WebAssembly.Module(readFileSync(join(out, name)))))
    if (!known.includes(wanted)) throw new Error(`${name}: expected no import but ${known.join(", ")}, found ${wanted}`);

// 1. The sources beside their packages, so that both compilers find these.
const source = join(work, "source");
rmSync(source, { recursive: true, force: true });
for (const folder of ["pack", "cesium", "page"]) cpSync(join(here, folder), join(source, folder), { recursive: true });
const config = JSON.parse(readFileSync(join(here, "tsconfig.json"), "utf8"));
config.include = ["pack", "cesium", "page"];
writeFileSync(join(source, "tsconfig.json"), JSON.stringify(config));
if (!existsSync(join(source, "node_modules"))) symlinkSync(modules, join(source, "node_modules"));
execFileSync(process.execPath, [join(modules, "typescript/bin/tsc"), "-p", source], { stdio: "inherit" });

// 2. The page and the module.
mkdirSync(out, { recursive: true });
const common = { bundle: true, format: "esm", target: "es2022", minify: true, legalComments: "none", logLevel: "warning" };
const cesiumBeside = {
  name: "cesium beside the page",
  setup: (build) => build.onResolve({ filter: /^cesium$/ }, () => ({ path: "./cesium/index.js", external: true })),
};
await build({ ...common, entryPoints: [join(source, "page/main.ts")], plugins: [cesiumBeside], outfile: join(out, "page.js") });
await build({ ...common, entryPoints: [join(source, "pack/index.ts")], outfile: join(out, "cairn-pack.js") });
await build({
  ...common,
  entryPoints: [join(source, "cesium/index.ts")],
  external: ["cesium"],
  outfile: join(out, "cairn-cesium.js"),
});
cpSync(join(source, "page/style.css"), join(out, "style.css"));

// 3. CesiumJS: what the page loads of it.
const cesium = join(modules, "cesium/Build/Cesium");
for (const part of ["index.js", "Workers", "ThirdParty", "Assets/approximateTerrainHeights.json", "Assets/IAU2006_XYS", "Assets/Images"])
  cpSync(join(cesium, part), join(out, "cesium", part), { recursive: true });

// 4. Licences.
const parts = [
  ["cairn", join(here, "../../LICENSE")],
  ["CesiumJS and what it contains", join(modules, "cesium/LICENSE.md")],
  ["zstddec, and zstd in it", join(modules, "zstddec/LICENSE")],
];
const xxhash = /\/\*([^]*?)\*\//.exec(readFileSync(join(work, "include/xxhash.h"), "utf8"))[1].replace(/^ \* ?/gm, "");
const texts = [
  ...parts.map(([name, path]) => [name, readFileSync(path, "utf8")]),
  ["xxHash", xxhash],
];
const emscripten = "/usr/share/doc/emscripten/copyright"; // Debian's
if (existsSync(emscripten))
  texts.push(["musl, libc++ and Emscripten's own code in the WebAssembly modules", readFileSync(emscripten, "utf8")]);
writeFileSync(join(out, "licences.txt"), texts.map(([name, text]) => `=== ${name} ===\n\n${text.trim()}\n`).join("\n\n"));
cpSync(join(source, "page/index.html"), join(out, "index.html"));
