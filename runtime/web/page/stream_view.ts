import type { Link } from "./camera_link.js";

type Camera = NonNullable<Link["camera"]>;

/** What the server says of a frame. */
interface FrameNote {
  frame: number;
  input: number;
  size: [number, number];
  camera: Camera;
  draw_ms: number;
  encode_ms: number;
  complete: boolean;
  error_px: number;
}

/** What a viewer of a stream sees, of the last second. */
export interface StreamFigures {
  width: number;
  height: number;
  framesPerSecond: number;
  megabitsPerSecond: number;
  drawMs: number;
  /** From a key or a drag to its picture; undefined before the first. */
  latencyMs: number | undefined;
  complete: boolean;
  errorPx: number;
}

const MOST = { width: 1920, height: 1080 };
const DEGREES_PER_PIXEL = 0.15;
const DEFLECTIONS: Record<string, [axis: number, value: number]> = {
  KeyW: [0, 1], ArrowUp: [0, 1], KeyS: [0, -1], ArrowDown: [0, -1],
  KeyD: [1, 1], ArrowRight: [1, 1], KeyA: [1, -1], ArrowLeft: [1, -1],
  KeyE: [2, 1], PageUp: [2, 1], KeyQ: [2, -1], PageDown: [2, -1],
};
const STEPS: Record<string, number> = { Equal: 2, NumpadAdd: 2, Minus: -2, NumpadSubtract: -2 };

/** A picture that a server draws and sends (`cairn serve --stream`); this side steers and shows it. */
export class StreamView {
  readonly canvas = document.createElement("canvas");
  camera: Camera | undefined;
  private readonly socket: WebSocket;
  private readonly held = new Set<string>();
  private readonly times = new Map<number, number>();
  private input = 0;
  private recent: { at: number; bytes: number; drawMs: number; pictures: number }[] = [];
  private latencyMs: number | undefined;
  private drag: { id: number; x: number; y: number } | undefined;
  private readonly stop = new AbortController();
  private readonly resize: ResizeObserver;
  private ended = false;

  /** Begins a stream from a URL; `figures` is called with each frame, `failed` where the stream ends. */
  constructor(
    url: string,
    private readonly element: HTMLElement,
    start: { camera?: Camera; hour: number },
    private readonly figures: (figures: StreamFigures) => void,
    private readonly failed: (error: Error) => void,
  ) {
    const address = new URL(url, location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.addEventListener("open", () =>
      this.send({ size: this.size(), hour: start.hour, ...(start.camera ? { camera: start.camera } : {}) }),
    );
    this.socket.addEventListener("message", (event) => void this.take(event.data as ArrayBuffer));
    this.socket.addEventListener("close", (event) => {
      if (this.ended) return;
      this.ended = true;
      this.failed(new Error(event.reason || "The server has ended the stream, or draws for as many viewers as it can."));
    });
    element.append(this.canvas);
    this.canvas.style.cssText = "width: 100%; height: 100%; display: block";
    this.listen();
    this.resize = new ResizeObserver(() => this.send({ size: this.size() }));
    this.resize.observe(element);
  }

  destroy(): void {
    this.ended = true;
    this.stop.abort();
    this.resize.disconnect();
    this.socket.close();
    this.canvas.remove();
  }

  setCamera(camera: Camera): void {
    this.steer({ camera });
  }
  setHour(hour: number): void {
    this.steer({ hour });
  }
  goHome(): void {
    this.steer({ home: true });
  }

  private size(): [number, number] {
    const shrink = Math.min(1, MOST.width / this.element.clientWidth, MOST.height / this.element.clientHeight);
    const side = (pixels: number) => Math.max(64, Math.floor(pixels * shrink));
    return [side(this.element.clientWidth), side(this.element.clientHeight)];
  }

  private send(message: object): void {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  /** Sends what a person did, and remembers when. */
  private steer(message: object): void {
    this.input += 1;
    this.times.set(this.input, performance.now());
    this.send({ ...message, input: this.input });
  }

  private async take(bytes: ArrayBuffer): Promise<void> {
    const length = new DataView(bytes).getUint32(0, true);
    const note = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length))) as FrameNote;
    const jpeg = new Uint8Array(bytes, 4 + length);
    if (jpeg.length > 0) {
      const picture = await createImageBitmap(new Blob([jpeg], { type: "image/jpeg" }));
      if (this.ended) return;
      [this.canvas.width, this.canvas.height] = note.size;
      this.canvas.getContext("2d")!.drawImage(picture, 0, 0);
      picture.close();
    }
    const now = performance.now();
    this.send({ shown: note.frame });
    this.camera = note.camera;
    for (const [input, at] of this.times) {
      if (input > note.input) break;
      this.latencyMs = now - at;
      this.times.delete(input);
    }
    this.recent.push({ at: now, bytes: bytes.byteLength, drawMs: note.draw_ms, pictures: jpeg.length > 0 ? 1 : 0 });
    this.recent = this.recent.filter(({ at }) => now - at < 1000);
    const sum = (of: "bytes" | "drawMs" | "pictures") => this.recent.reduce((total, frame) => total + frame[of], 0);
    this.figures({
      width: note.size[0],
      height: note.size[1],
      framesPerSecond: sum("pictures"),
      megabitsPerSecond: (sum("bytes") * 8) / 1e6,
      drawMs: sum("drawMs") / this.recent.length,
      latencyMs: this.latencyMs,
      complete: note.complete,
      errorPx: note.error_px,
    });
  }

  private sendHeld(fast: boolean): void {
    const held = [0, 0, 0, fast ? 5 : 1];
    for (const code of this.held) {
      const [axis, value] = DEFLECTIONS[code]!;
      held[axis] = Math.max(-1, Math.min(1, held[axis]! + value));
    }
    this.steer({ held });
  }

  private listen(): void {
    const { element } = this;
    const options = { signal: this.stop.signal };
    element.addEventListener(
      "keydown",
      (event) => {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        if (event.code in STEPS) this.steer({ zoom: STEPS[event.code] });
        else if (!(event.code in DEFLECTIONS)) return;
        else if (!this.held.has(event.code)) {
          this.held.add(event.code);
          this.sendHeld(event.shiftKey);
        }
        event.preventDefault();
      },
      options,
    );
    element.addEventListener("keyup", (event) => this.held.delete(event.code) && this.sendHeld(event.shiftKey), options);
    element.addEventListener("blur", () => this.held.size > 0 && (this.held.clear(), this.sendHeld(false)), options);
    this.canvas.addEventListener(
      "pointerdown",
      (event) => {
        element.focus();
        this.canvas.setPointerCapture(event.pointerId);
        this.drag = { id: event.pointerId, x: event.clientX, y: event.clientY };
      },
      options,
    );
    this.canvas.addEventListener(
      "pointermove",
      (event) => {
        if (this.drag?.id !== event.pointerId) return;
        const [dx, dy] = [event.clientX - this.drag.x, event.clientY - this.drag.y];
        this.drag = { id: event.pointerId, x: event.clientX, y: event.clientY };
        this.steer({ turn: -dx * DEGREES_PER_PIXEL, tilt: dy * DEGREES_PER_PIXEL });
      },
      options,
    );
    for (const name of ["pointerup", "pointercancel"] as const)
      this.canvas.addEventListener(name, () => (this.drag = undefined), options);
    this.canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        this.steer({ zoom: Math.max(-3, Math.min(3, -event.deltaY / 100)) });
      },
      { ...options, passive: false },
    );
  }
}
