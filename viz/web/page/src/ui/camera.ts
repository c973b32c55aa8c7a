// The camera's image: as it comes, or the latest keyframe with its features.
import { find, make, setText } from "../dom";
import { bytesOf } from "../protocol";

export type CameraMode = "keyframe" | "live";

export class CameraPanel {
  mode: CameraMode = "keyframe";
  private canvas = make("canvas", { width: "640", height: "480", role: "img", "aria-label": "No image yet" });
  private caption = make("p", { class: "caption" }, "No image yet");
  private busy = false;
  private seen = { keyframe: false, live: false };

  constructor(private changed: () => void) {
    const buttons = (["keyframe", "live"] as const).map((mode) =>
      make("button", { type: "button", role: "radio", "aria-checked": String(mode === this.mode), click: () => this.choose(mode, buttons) },
           mode === "keyframe" ? "Features" : "Live"));
    find("camera").append(
      make("header", {}, make("h2", {}, "Camera"), make("div", { class: "segmented small", role: "radiogroup", "aria-label": "Which image" }, ...buttons)),
      make("div", { class: "frame" }, this.canvas), this.caption);
  }

  clear(): void {
    this.canvas.getContext("2d")?.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.seen = { keyframe: false, live: false };
    setText(this.caption, "No image yet");
  }

  setLive(data: DataView): void {
    this.seen.live = true;
    if (this.mode === "live") void this.draw(bytesOf(data, 8), [], "Live image");
  }

  setKeyframe(data: DataView): void {
    this.seen.keyframe = true;
    if (this.mode !== "keyframe") return;
    const id = data.getUint32(8, true);
    const n = data.getUint32(20, true);
    const features: Feature[] = [];
    let mapped = 0;
    for (let i = 0; i < n; i++) {
      const at = 24 + 16 * i;
      const isMapped = data.getFloat32(at + 12, true) > 0;
      features.push({ u: data.getFloat32(at, true), v: data.getFloat32(at + 4, true), depth: data.getFloat32(at + 8, true), mapped: isMapped });
      if (isMapped) mapped++;
    }
    void this.draw(bytesOf(data, 24 + 16 * n), features,
                   `Keyframe ${id}: ${n} features, ${mapped} of them points of the map`);
  }

  private choose(mode: CameraMode, buttons: HTMLElement[]): void {
    this.mode = mode;
    buttons.forEach((button, i) => button.setAttribute("aria-checked", String((i === 0 ? "keyframe" : "live") === mode)));
    if (!this.seen[mode]) setText(this.caption, mode === "live" ? "Waiting for the camera…" : "Waiting for a keyframe…");
    this.changed();
  }

  // One image is decoded at a time; what comes meanwhile is left out.
  private async draw(jpeg: Uint8Array, features: Feature[], text: string): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    try {
      const image = await createImageBitmap(new Blob([jpeg as BlobPart], { type: "image/jpeg" }));
      if (this.canvas.width !== image.width || this.canvas.height !== image.height)
        [this.canvas.width, this.canvas.height] = [image.width, image.height];
      const context = this.canvas.getContext("2d") as CanvasRenderingContext2D;
      context.drawImage(image, 0, 0);
      image.close();
      const r = Math.max(2.2, this.canvas.width / 200);
      for (const feature of features) {
        context.beginPath();
        context.arc(feature.u, feature.v, feature.mapped ? r : r * 0.8, 0, 2 * Math.PI);
        context.lineWidth = Math.max(1, r / 2.2);
        context.strokeStyle = feature.mapped ? "#2fd6a3" : feature.depth > 0 ? "#56b4e9" : "#f0e442";
        context.stroke();
      }
      setText(this.caption, text);
      this.canvas.setAttribute("aria-label", text);
    } catch {
      setText(this.caption, "The image could not be read");
    } finally {
      this.busy = false;
    }
  }
}

interface Feature {
  u: number;
  v: number;
  depth: number;
  mapped: boolean;
}
