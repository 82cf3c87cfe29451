import * as Cesium from "cesium";
import type { Pack } from "../pack/index.js";

/** The scheme of geographic tiles on the pack's ellipsoid. */
export function tilingSchemeOf(pack: Pack): Cesium.GeographicTilingScheme {
  const { semiMajorM, semiMinorM } = pack.header;
  return new Cesium.GeographicTilingScheme({
    ellipsoid: new Cesium.Ellipsoid(semiMajorM, semiMajorM, semiMinorM),
  });
}
