/** CesiumJS providers for cairn packs. docs/browser.md explains them. */
export { CairnImageryProvider } from "./imagery_provider.js";
export { CairnTerrainProvider } from "./terrain_provider.js";
export { DetailProvider } from "./detail_provider.js";
