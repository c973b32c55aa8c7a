// Which layers are drawn, and what their colours mean.
import { make, setText } from "../dom";

export const LAYERS = [
  ["fused", "Fused grid", "What both sensors together know of the floor plan"],
  ["lidar", "LiDAR grid", "What the LiDAR alone would have mapped"],
  ["visual", "Camera grid", "What the camera alone would have mapped"],
  ["cloud", "Point cloud", "Coloured points from the depth camera"],
  ["octomap", "OctoMap voxels", "Occupied space, coloured by height"],
  ["trajectory", "Trajectory", "Where the robot has been, after the latest optimisation"],
  ["keyframes", "Keyframes", "Camera poses that the map is built on"],
  ["loops", "Loop closures", "Places that were recognised again; click one for its report"],
  ["truth", "Ground truth", "Where the robot really was (simulated or surveyed recordings only)"],
  ["scan", "Live scan", "The LiDAR's latest turn"],
] as const;
export type Layer = (typeof LAYERS)[number][0];

const STORE = "fusion-slam-layers";
const AT_FIRST: Layer[] = ["fused", "trajectory", "keyframes", "loops", "truth", "scan"];

export class LayerPanel {
  readonly on = new Set<Layer>(AT_FIRST);
  private counts = new Map<Layer, HTMLElement>();
  private boxes = new Map<Layer, HTMLInputElement>();

  constructor(root: HTMLElement, private changed: (layer: Layer, on: boolean) => void) {
    try {
      const stored = JSON.parse(localStorage.getItem(STORE) ?? "null") as Layer[] | null;
      if (stored) {
        this.on.clear();
        for (const layer of stored) if (LAYERS.some(([name]) => name === layer)) this.on.add(layer);
      }
    } catch {
      // No storage: the usual layers.
    }
    const list = make("ul", {});
    for (const [name, title, help] of LAYERS) {
      const box = make("input", { type: "checkbox", change: () => this.set(name, box.checked) });
      box.checked = this.on.has(name);
      const number = make("small", {});
      this.counts.set(name, number);
      this.boxes.set(name, box);
      list.append(make("li", {}, make("label", { title: help }, box, make("i", { class: `swatch ${name}` }), make("span", {}, title), number)));
    }
    const legend = make("dl", { class: "legend", "aria-label": "Colours of the fused grid" });
    for (const [kind, text] of [["free", "free"], ["by-lidar", "LiDAR"], ["by-camera", "camera"], ["by-both", "both"], ["conflict", "they disagree"]])
      legend.append(make("div", {}, make("dt", { class: kind }), make("dd", {}, text)));
    const fold = make("details", { class: "fold" }, make("summary", {}, "Layers"), list, make("p", { class: "legend-title" }, "Wall seen by"), legend);
    fold.open = matchMedia("(min-width: 900px)").matches;
    root.append(fold);
  }

  set(layer: Layer, on: boolean): void {
    if (on) this.on.add(layer);
    else this.on.delete(layer);
    const box = this.boxes.get(layer);
    if (box) box.checked = on;
    try {
      localStorage.setItem(STORE, JSON.stringify([...this.on]));
    } catch {
      // Not remembered then.
    }
    this.changed(layer, on);
  }

  count(layer: Layer, text: string): void {
    const element = this.counts.get(layer);
    if (element) setText(element, text);
  }
}
