// The WebSocket: connects, comes back by itself, hands batches on, acknowledges them, and matches answers to questions.
import { decodeBatch, type Batch, type Topic } from "./protocol";

export type ConnectionState = "connecting" | "open" | "lost" | "refused";

interface Handlers {
  batch(batch: Batch): void;
  state(state: ConnectionState, retryInS: number): void;
  problem(text: string): void;
}

const FIRST_RETRY_S = 0.5;
const LONGEST_RETRY_S = 5;
const ANSWER_TIMEOUT_MS = 10000;

export class Connection {
  bytes = 0; // received since the page was opened
  private socket: WebSocket | null = null;
  private retryS = FIRST_RETRY_S;
  private failures = 0;
  private nextId = 1;
  private waiting = new Map<number, (answer: Record<string, unknown> | null) => void>();
  private wanted: Topic[] | null = null;

  constructor(private handlers: Handlers) {
    this.connect();
  }

  // The answer, or null when none comes.
  ask<T>(request: Record<string, unknown>): Promise<T | null> {
    const id = this.nextId++;
    return new Promise((resolve) => {
      if (!this.send({ ...request, id })) return resolve(null);
      const timer = setTimeout(() => this.waiting.delete(id) && resolve(null), ANSWER_TIMEOUT_MS);
      this.waiting.set(id, (answer) => {
        clearTimeout(timer);
        resolve(answer as T | null);
      });
    });
  }

  acknowledge(batch: number): void {
    this.send({ type: "ack", batch });
  }

  want(topics: Topic[]): void {
    this.wanted = topics;
    this.send({ type: "want", topics });
  }

  private send(message: object): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  private connect(): void {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/socket`);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.retryS = FIRST_RETRY_S;
      this.failures = 0;
      if (this.wanted) this.want(this.wanted);
      this.handlers.state("open", 0);
    };
    socket.onmessage = (event) => {
      if (typeof event.data === "string") return this.answer(event.data);
      const buffer = event.data as ArrayBuffer;
      this.bytes += buffer.byteLength;
      try {
        this.handlers.batch(decodeBatch(buffer));
      } catch (error) {
        this.handlers.problem(`The viewer sent something this page does not understand (${String(error)}). Reload the page.`);
      }
    };
    socket.onclose = () => {
      for (const resolve of this.waiting.values()) resolve(null);
      this.waiting.clear();
      this.failures++;
      void this.lost();
    };
  }

  // A viewer that answers HTTP but not the socket has refused us: too many browsers, or a name it doesn't know.
  private async lost(): Promise<void> {
    let state: ConnectionState = "lost";
    if (this.failures > 1) {
      try {
        if ((await fetch("/health", { cache: "no-store" })).ok) state = "refused";
      } catch {
        state = "lost";
      }
    }
    this.handlers.state(state, this.retryS);
    setTimeout(() => this.connect(), this.retryS * 1000);
    this.retryS = Math.min(LONGEST_RETRY_S, this.retryS * 1.6);
  }

  private answer(text: string): void {
    const answer = JSON.parse(text) as Record<string, unknown>;
    const resolve = this.waiting.get(answer.id as number);
    if (resolve) {
      this.waiting.delete(answer.id as number);
      resolve(answer);
    } else if (typeof answer.error === "string") {
      this.handlers.problem(answer.error);
    }
  }
}
