// Loop closures: each with what every stage said of it.
import { find, make, setAttribute, setText } from "../dom";
import type { LoopItem } from "../protocol";
import { Rows, type Row } from "./rows";

const MOST_ROWS = 60;
const STATES = { closed: "closed", rejected: "rejected", switched_off: "switched off" };

export class LoopPanel {
  private loops = new Map<string, LoopItem>();
  private list = make("ul", { class: "loop-list" });
  private summary = make("p", { class: "caption" });
  private more = make("p", { class: "caption" });
  private rows = new Rows<LoopItem>(this.list, (key) => this.row(key));
  private first = 0;
  private all = false;
  private chosen: string | null = null;
  private changed = true;

  constructor(private pick: (key: string | null) => void, private showAll: (all: boolean) => void) {
    const box = make("input", { type: "checkbox", change: () => {
      this.all = box.checked;
      this.changed = true;
      this.showAll(this.all);
    } });
    find("loops").append(make("header", {}, make("h2", {}, "Loop closures"), make("label", { class: "toggle" }, box, "rejected too")), this.summary, this.list, this.more);
  }

  set(key: string, loop: LoopItem | null): void {
    if (loop) this.loops.set(key, loop);
    else this.loops.delete(key);
    this.changed = true;
  }

  clear(): void {
    this.loops.clear();
    this.chosen = null;
    this.changed = true;
  }

  choose(key: string | null, scroll = false): void {
    this.chosen = key;
    this.changed = true;
    this.render(0);
    if (scroll) this.list.querySelector(".chosen")?.scrollIntoView({ block: "nearest", behavior: "smooth" });
  }

  render(firstUtime: number): void {
    if (!this.changed) return;
    this.changed = false;
    this.first = firstUtime || this.first;
    const every = [...this.loops.entries()].sort((a, b) => b[1].utime - a[1].utime);
    const closed = every.filter(([, loop]) => loop.state === "closed").length;
    const off = every.filter(([, loop]) => loop.state === "switched_off").length;
    const rejected = every.length - closed - off;
    this.summary.textContent = every.length
      ? `${closed} closed, ${off} switched off again by the pose graph, ${rejected} candidates rejected`
      : "No place has been recognised again yet.";
    const shown = every.filter(([key, loop]) => this.all || loop.state !== "rejected" || key === this.chosen);
    this.rows.render(shown.slice(0, MOST_ROWS));
    this.more.textContent = shown.length > MOST_ROWS ? `and ${shown.length - MOST_ROWS} older ones` : "";
  }

  private row(key: string): Row<LoopItem> {
    const badge = make("i");
    const at = make("span");
    const title = make("b");
    const button = make("button", { type: "button", click: () => {
      const chosen = this.chosen === key ? null : key;
      this.choose(chosen);
      this.pick(chosen);
    } }, badge, title, at);
    const element = make("li", {}, button);
    let drawn = "";
    return {
      element,
      update: (loop) => {
        const isChosen = key === this.chosen;
        setAttribute(element, "class", isChosen ? "chosen" : "");
        setAttribute(button, "aria-expanded", String(isChosen));
        setAttribute(badge, "class", `badge ${loop.state}`);
        setText(badge, STATES[loop.state]);
        setText(title, `${name(loop.from)} – ${name(loop.to)}`);
        setText(at, this.first ? `${((loop.utime - this.first) / 1e6).toFixed(1)} s` : "");
        const wanted = isChosen ? JSON.stringify(loop) : "";
        if (wanted === drawn) return;
        drawn = wanted;
        element.replaceChildren(button, ...(isChosen ? [report(loop)] : []));
      },
    };
  }
}

const name = (node: string): string => (node[0] === "k" ? "keyframe " : "scan ") + node.slice(1);

function report(loop: LoopItem): HTMLElement {
  const digits = (value: number): string => (Math.abs(value) >= 100 ? value.toFixed(0) : value.toPrecision(3));
  const box = make("div", { class: "report" });
  if (loop.state === "switched_off")
    box.append(make("p", { class: "bad" }, `The pose graph switched it off: ${loop.off_reason || "it disagrees with the rest"} (squared error ${digits(loop.off_squared_error ?? 0)}).`));
  if (loop.source) box.append(make("p", {}, `Measured by ${loop.source}.`));
  if (loop.stages.length === 0) {
    box.append(make("p", {}, "No stage has reported on it."));
    return box;
  }
  box.append(make("table", {},
    make("thead", {}, make("tr", {}, ...["Stage", "Score", "Needed", "Verdict"].map((title) => make("th", { scope: "col" }, title)))),
    make("tbody", {}, ...loop.stages.flatMap((stage) => [
      make("tr", {}, make("th", { scope: "row" }, stage.stage), make("td", {}, digits(stage.score)), make("td", {}, digits(stage.threshold)),
           make("td", { class: stage.passed ? "good" : "bad" }, stage.passed ? "✓ passed" : "✕ failed")),
      ...(stage.reason ? [make("tr", { class: "reason" }, make("td", { colspan: "4" }, stage.reason))] : []),
    ]))));
  return box;
}
