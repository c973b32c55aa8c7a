// The health of inputs and processes, with one sentence that says how things stand.
import { bytes, count, find, make, setAttribute, setText } from "../dom";
import type { DeputyItem, HealthItem, InputItem } from "../protocol";
import { Rows, type Row } from "./rows";

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
  private changed = true;
  private inputRows = new Rows<InputItem>(this.inputList, inputRow);
  private processRows = new Rows<HealthItem>(this.processList, processRow);
  private deputyRows = new Rows<DeputyItem>(this.deputyList, (name) => machine(name, this.order));

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
  // A command that was stopped is forgotten by its deputy; people want to start it again. (With --lab the viewer remembers.)
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
  names(): string[] {
    return [...this.processes.keys()];
  }
  commands(): { name: string; pid: number }[] {
    return [...this.deputies.values()].flatMap((deputy) => deputy.commands);
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
    setAttribute(this.verdict, "class", `verdict ${problems.length ? "bad" : "good"}`);
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
    this.inputRows.render(sorted(this.inputs));
    this.processRows.render(sorted(this.processes));
    this.deputyRows.render(sorted(this.deputies));
  }
}

function inputRow(name: string): Row<InputItem> {
  const [rate, flow, state] = [make("span"), make("span"), make("span", { class: "state" })];
  const element = make("li", {}, make("b", {}, name), rate, flow, state);
  return {
    element,
    update: (input) => {
      setAttribute(element, "class", input.late ? "late" : "");
      setText(rate, `${input.rate_hz.toFixed(1)} Hz`);
      setText(flow, `${bytes(input.bytes_s)}/s`);
      setText(state, input.late ? `late ${input.late_s.toFixed(1)} s` : "on time");
    },
  };
}

const FACTS = ["State", "Latency", "Queue", "Dropped", "Memory", "Processor", "Last error"];

function processRow(name: string): Row<HealthItem> {
  const dot = make("i");
  const rate = make("span", { title: "messages handled a second" });
  const latency = make("span", { title: "median time to handle a message" });
  const losses = make("span", { title: "messages dropped or lost" });
  const text = make("p");
  const values = FACTS.map(() => make("dd"));
  const element = make("li", {}, make("details", {}, make("summary", {}, dot, make("b", {}, name), rate, latency, losses), text,
    make("dl", {}, ...FACTS.flatMap((title, i) => [make("dt", {}, title), values[i]]))));
  return {
    element,
    update: (process) => {
      const behind = Math.max(0, ...Object.values(process.behind_s));
      const lossy = process.dropped + process.lost;
      setAttribute(dot, "class", `dot ${process.state}`);
      setText(rate, `${process.rate_hz.toFixed(0)}/s`);
      setText(latency, `${process.latency_ms.toFixed(1)} ms`);
      setText(losses, lossy > 0 ? `−${count(lossy)}` : "");
      setAttribute(losses, "class", lossy > 0 ? "warn" : "");
      setText(text, process.text);
      text.hidden = process.text === "";
      [
        process.state + (process.host ? ` on ${process.host}, pid ${process.pid}` : ""),
        `${process.latency_ms.toFixed(1)} ms median, ${process.latency_p95_ms.toFixed(1)} 95 %, ${process.latency_p99_ms.toFixed(1)} 99 %`,
        `${count(process.queue)} waiting${behind > 0.3 ? `, ${behind.toFixed(1)} s behind its sensors` : ""}`,
        `${count(process.dropped)} by policy, ${count(process.lost)} lost, ${count(process.late)} late, ${count(process.rejected)} damaged`,
        `${bytes(process.memory_bytes)} at most`,
        `${process.cpu_percent.toFixed(0)} % of a core`,
        process.last_error || "none",
      ].forEach((value, i) => setText(values[i], value));
    },
  };
}

type Command = DeputyItem["commands"][number];

function machine(name: string, order: Order): Row<DeputyItem> {
  const load = make("small");
  const list = make("ul");
  const rows = new Rows<Command>(list, (command) => commandRow(command, order));
  return {
    element: make("section", {}, make("h3", {}, `Machine ${name}`, load), list),
    update: (deputy) => {
      setText(load, ` ${(100 * deputy.cpu).toFixed(0)} % busy, ${bytes(deputy.memory_free_bytes)} free`);
      rows.render(deputy.commands.map((command) => [command.name, command]));
    },
  };
}

function commandRow(name: string, order: Order): Row<Command> {
  const dot = make("i");
  const state = make("span");
  const button = (verb: "start" | "stop" | "restart"): HTMLElement =>
    make("button", { type: "button", "aria-label": `${verb} ${name}`, click: () => order(verb, name) }, verb);
  const [start, stop, restart] = [button("start"), button("stop"), button("restart")];
  return {
    element: make("li", {}, dot, make("b", {}, name), state, start, stop, restart),
    update: (command) => {
      const running = command.pid > 0;
      setAttribute(dot, "class", `dot ${running ? "running" : command.exit_code ? "failed" : "stopping"}`);
      setText(state, running ? `${(100 * command.cpu).toFixed(0)} %` : command.exit_code ? `status ${command.exit_code}` : "stopped");
      start.hidden = running;
      stop.hidden = restart.hidden = !running;
    },
  };
}

function put<T>(map: Map<string, T>, key: string, item: T | null): void {
  if (item) map.set(key, item);
  else map.delete(key);
}

function sorted<T>(map: Map<string, T>): [string, T][] {
  return [...map.entries()].sort((a, b) => a[0].localeCompare(b[0]));
}
