// The health of inputs and processes, with one sentence that says how things stand.
import { bytes, count, find, make } from "../dom";
import type { DeputyItem, HealthItem, InputItem } from "../protocol";

export type Order = (verb: "start" | "stop" | "restart", target: string) => void;

export class HealthPanel {
  private processes = new Map<string, HealthItem>();
  private inputs = new Map<string, InputItem>();
  private deputies = new Map<string, DeputyItem>();
  private verdict = make("p", { class: "verdict" });
  private inputList = make("ul", { class: "inputs" });
  private processList = make("ul", { class: "processes" });
  private deputyList = make("div", { class: "deputies" });
  private performance = make("p", { class: "caption" });
  private open = new Set<string>();
  private changed = true;

  constructor(private order: Order) {
    find("health").append(make("header", {}, make("h2", {}, "Health")), this.verdict, this.inputList, this.processList, this.deputyList, this.performance);
  }

  setProcess(key: string, item: HealthItem | null): void {
    put(this.processes, key, item);
    this.changed = true;
  }
  setInput(key: string, item: InputItem | null): void {
    put(this.inputs, key, item);
    this.changed = true;
  }
  // A command that was stopped is forgotten by its deputy; people want to start it again.
  setDeputy(key: string, item: DeputyItem | null): void {
    for (const before of this.deputies.get(key)?.commands ?? [])
      if (item && !item.commands.some((command) => command.name === before.name)) item.commands.push({ ...before, pid: 0, exit_code: 0, cpu: 0 });
    put(this.deputies, key, item);
    this.changed = true;
  }
  clear(): void {
    this.processes.clear();
    this.inputs.clear();
    this.deputies.clear();
    this.changed = true;
  }
  setPerformance(text: string): void {
    this.performance.textContent = text;
  }

  // What is wrong, the worst first; nothing when all is well.
  problems(replaying: boolean): string[] {
    const list: string[] = [];
    for (const process of this.processes.values()) {
      if (process.state === "failed") list.push(`${process.process} has failed: ${process.last_error || "no reason given"}`);
      else if (process.state === "silent" && !replaying) list.push(`${process.process} has said nothing for ${process.silent_s.toFixed(0)} s`);
    }
    const late = [...this.inputs.values()].filter((input) => input.late);
    if (late.length > 1 && late.length === this.inputs.size)
      list.push(`No sensor has been heard for ${Math.min(...late.map((input) => input.late_s)).toFixed(0)} s`);
    else for (const input of late) list.push(`${input.channel} is late by ${input.late_s.toFixed(1)} s`);
    return list;
  }

  render(replaying: boolean): void {
    if (!this.changed) return;
    this.changed = false;
    const problems = this.problems(replaying);
    this.verdict.className = `verdict ${problems.length ? "bad" : "good"}`;
    if (this.processes.size + this.inputs.size === 0) {
      this.verdict.className = "verdict";
      this.verdict.textContent = "No process has said anything yet.";
    } else if (problems.length) {
      this.verdict.textContent = problems.join(". ") + ".";
    } else {
      const n = [...this.processes.keys()].filter((name) => name !== "viewer").length;
      const inputs = this.inputs.size === 1 ? "1 input" : `${this.inputs.size} inputs`;
      const others = n === 1 ? "1 process well" : n > 1 ? `${n} processes well` : replaying ? "No process in this recording" : "No process but this viewer";
      this.verdict.textContent = this.inputs.size ? `${others}, ${inputs} on time.` : `${others}, no sensor heard.`;
    }
    this.inputList.replaceChildren(...sorted(this.inputs).map((input) =>
      make("li", { class: input.late ? "late" : "" },
        make("b", {}, input.channel), make("span", {}, `${input.rate_hz.toFixed(1)} Hz`), make("span", {}, `${bytes(input.bytes_s)}/s`),
        make("span", { class: "state" }, input.late ? `late ${input.late_s.toFixed(1)} s` : "on time"))));
    const focused = document.activeElement?.closest("details")?.dataset.process;
    this.processList.replaceChildren(...sorted(this.processes).map((process) => this.row(process)));
    if (focused) (this.processList.querySelector(`[data-process="${CSS.escape(focused)}"] summary`) as HTMLElement | null)?.focus();
    this.deputyList.replaceChildren(...sorted(this.deputies).map((deputy) => this.machine(deputy)));
  }

  private row(process: HealthItem): HTMLLIElement {
    const behind = Math.max(0, ...Object.values(process.behind_s));
    const lossy = process.dropped + process.lost;
    const details = make("details", { "data-process": process.process, toggle: () => {
      if (details.open) this.open.add(process.process);
      else this.open.delete(process.process);
    } },
      make("summary", {}, make("i", { class: `dot ${process.state}` }), make("b", {}, process.process),
        make("span", { title: "messages handled a second" }, `${process.rate_hz.toFixed(0)}/s`),
        make("span", { title: "median time to handle a message" }, `${process.latency_ms.toFixed(1)} ms`),
        make("span", { class: lossy > 0 ? "warn" : "", title: "messages dropped or lost" }, lossy > 0 ? `−${count(lossy)}` : "")),
      process.text ? make("p", {}, process.text) : null,
      facts([
        ["State", process.state + (process.host ? ` on ${process.host}, pid ${process.pid}` : "")],
        ["Latency", `${process.latency_ms.toFixed(1)} ms median, ${process.latency_p95_ms.toFixed(1)} 95 %, ${process.latency_p99_ms.toFixed(1)} 99 %`],
        ["Queue", `${count(process.queue)} waiting${behind > 0.3 ? `, ${behind.toFixed(1)} s behind its sensors` : ""}`],
        ["Dropped", `${count(process.dropped)} by policy, ${count(process.lost)} lost, ${count(process.late)} late, ${count(process.rejected)} damaged`],
        ["Memory", `${bytes(process.memory_bytes)} at most`],
        ["Processor", `${process.cpu_percent.toFixed(0)} % of a core`],
        ["Last error", process.last_error || "none"],
      ]));
    details.open = this.open.has(process.process);
    return make("li", {}, details);
  }

  private machine(deputy: DeputyItem): HTMLElement {
    return make("section", {},
      make("h3", {}, `Machine ${deputy.deputy}`, make("small", {}, ` ${(100 * deputy.cpu).toFixed(0)} % busy, ${bytes(deputy.memory_free_bytes)} free`)),
      make("ul", {}, ...deputy.commands.map((command) => {
        const running = command.pid > 0;
        const button = (verb: "start" | "stop" | "restart"): HTMLElement =>
          make("button", { type: "button", "aria-label": `${verb} ${command.name}`, click: () => this.order(verb, command.name) }, verb);
        return make("li", {}, make("i", { class: `dot ${running ? "running" : command.exit_code ? "failed" : "stopping"}` }), make("b", {}, command.name),
          make("span", {}, running ? `${(100 * command.cpu).toFixed(0)} %` : `exit ${command.exit_code}`),
          ...(running ? [button("stop"), button("restart")] : [button("start")]));
      })));
  }
}

function put<T>(map: Map<string, T>, key: string, item: T | null): void {
  if (item) map.set(key, item);
  else map.delete(key);
}

function sorted<T>(map: Map<string, T>): T[] {
  return [...map.entries()].sort((a, b) => a[0].localeCompare(b[0])).map(([, item]) => item);
}

function facts(rows: [string, string][]): HTMLElement {
  return make("dl", {}, ...rows.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]));
}
