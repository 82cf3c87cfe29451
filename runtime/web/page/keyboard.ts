import * as Cesium from "cesium";

/** Moves the camera by a key; returns whether the key has a meaning. */
export function moveByKey(widget: Cesium.CesiumWidget, key: string): boolean {
  const { camera, scene } = widget;
  const height = Math.max(camera.positionCartographic.height, 10);
  const angle = height / scene.globe.ellipsoid.maximumRadius / 10;
  const turn = Cesium.Math.toRadians(5);
  const moves: Record<string, () => void> = {
    ArrowLeft: () => camera.rotateLeft(angle),
    ArrowRight: () => camera.rotateRight(angle),
    ArrowUp: () => camera.rotateUp(angle),
    ArrowDown: () => camera.rotateDown(angle),
    "+": () => camera.zoomIn(height / 5),
    "=": () => camera.zoomIn(height / 5),
    "-": () => camera.zoomOut(height / 4),
    q: () => camera.twistLeft(turn),
    e: () => camera.twistRight(turn),
    r: () => camera.lookUp(turn),
    f: () => camera.lookDown(turn),
  };
  const move = moves[key];
  if (!move) return false;
  move();
  scene.requestRender();
  return true;
}
