// What is known of the cell that was clicked.
import { ago, duration, make } from "../dom";
import type { CellAnswer } from "../protocol";

const WORDS = {
  none: "no sensor", lidar: "the LiDAR", camera: "the camera", both: "both sensors", conflict: "they disagree: the LiDAR says wall, the camera sees through",
};

export class CellCard {
  constructor(private root: HTMLElement) {}

  hide(): void {
    this.root.hidden = true;
  }

  show(answer: CellAnswer, x: number, y: number, at: [number, number], now: number, first: number): void {
    const place = `${x.toFixed(2)}, ${y.toFixed(2)} m`;
    const close = make("button", { type: "button", class: "icon close", "aria-label": "Close", click: () => this.hide() }, "×");
    const p = answer.known ? (answer.fused ?? answer.lidar ?? answer.visual) : null;
    if (!answer.known || p === null) {
      this.root.replaceChildren(close, make("h2", {}, "Unknown"), make("p", {}, `No sensor has seen ${place}.`));
    } else {
      const what = p > 0.65 ? "Occupied" : p < 0.35 ? "Free" : "Undecided";
      this.root.replaceChildren(
        close, make("h2", {}, what),
        make("p", { class: "caption" }, `Cell ${answer.cell[0]}, ${answer.cell[1]} at ${place}`),
        bar("Fused", answer.fused, "by-both"), bar("LiDAR", answer.lidar, "by-lidar"), bar("Camera", answer.visual, "by-camera"),
        make("dl", {},
          make("dt", {}, "Says so"), make("dd", {}, WORDS[answer.provenance]),
          ...(answer.first_utime ? [
            make("dt", {}, "First seen"), make("dd", {}, `at ${duration((answer.first_utime - first) / 1e6)}`),
            make("dt", {}, "Last changed"), make("dd", {}, `at ${duration((answer.changed_utime - first) / 1e6)}, ${ago((now - answer.changed_utime) / 1e6)}`),
            make("dt", {}, "Changes"), make("dd", {}, String(answer.changes)),
          ] : [])));
    }
    this.root.hidden = false;
    const stage = this.root.parentElement as HTMLElement;
    const [w, h] = [this.root.offsetWidth, this.root.offsetHeight];
    this.root.style.left = `${Math.max(8, Math.min(at[0] + 14, stage.clientWidth - w - 8))}px`;
    this.root.style.top = `${Math.max(8, Math.min(at[1] + 14, stage.clientHeight - h - 8))}px`;
  }
}

function bar(name: string, p: number | null, kind: string): HTMLElement {
  const text = p === null ? "unknown" : `${(100 * p).toFixed(p > 0.99 || p < 0.01 ? 1 : 0)} %`;
  return make("div", { class: "probability" }, make("span", {}, name),
    make("div", { class: "meter", role: "img", "aria-label": `${name}: ${text}` }, make("i", { class: kind, style: `width:${p === null ? 0 : 100 * p}%` })),
    make("b", {}, text));
}
