// Short messages that go away by themselves; errors stay longer.
import { make } from "../dom";

const SHOWN_MS = { info: 6000, error: 14000 };
const MOST = 4;

export class Notices {
  private shown = new Set<string>();
  constructor(private root: HTMLElement) {}

  show(level: "info" | "error", text: string): void {
    if (this.shown.has(text)) return;
    this.shown.add(text);
    const box = make("div", { class: `notice ${level}`, role: level === "error" ? "alert" : "status" }, make("span", {}, text),
      make("button", { type: "button", class: "icon close", "aria-label": "Dismiss", click: () => drop() }, "×"));
    const drop = (): void => {
      box.remove();
      this.shown.delete(text);
    };
    this.root.append(box);
    while (this.root.children.length > MOST) this.root.firstElementChild?.remove();
    setTimeout(drop, SHOWN_MS[level]);
  }
}
