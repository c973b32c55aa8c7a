// Time line of a recording: play, pause, speed, seek; marks where loops were closed.
import { duration, find, make, setText } from "../dom";
import type { PlayerItem } from "../protocol";

type Send = (verb: "play" | "pause" | "seek" | "speed", value?: number) => void;
const SPEEDS = [0.5, 1, 2, 5, 10, 20];

export class Timeline {
  player: PlayerItem | null = null;
  private root = find("timeline");
  private play = make("button", { type: "button", class: "play", "aria-label": "Play", click: () => this.toggle() });
  private position = make("output", {});
  private length = make("span", { class: "length" });
  private slider = make("input", { type: "range", min: "0", max: "1", step: "0.05", value: "0", "aria-label": "Position" });
  private marks = make("div", { class: "marks", "aria-hidden": "true" });
  private speed = make("select", { "aria-label": "Speed", change: () => this.send("speed", Number(this.speed.value)) },
                       ...SPEEDS.map((value) => make("option", { value: String(value) }, `${value}×`)));
  private dragging = false;
  private drawnMarks = "";

  constructor(private send: Send) {
    this.speed.value = "1";
    this.slider.addEventListener("input", () => {
      this.dragging = true;
      setText(this.position, duration(Number(this.slider.value)));
    });
    this.slider.addEventListener("change", () => {
      this.dragging = false;
      this.send("seek", Number(this.slider.value));
    });
    this.root.append(this.play, this.position, make("div", { class: "track" }, this.marks, this.slider), this.length, this.speed);
  }

  set(player: PlayerItem): void {
    this.player = player;
    this.root.hidden = !player.ready;
    if (!player.ready) return;
    const length = player.duration_s ?? 0;
    this.slider.max = String(length);
    this.slider.setAttribute("aria-valuetext", duration(player.position_s ?? 0));
    setText(this.length, duration(length));
    if (!this.dragging) {
      this.slider.value = String(player.position_s ?? 0);
      setText(this.position, duration(player.position_s ?? 0));
      this.slider.style.setProperty("--done", `${length > 0 ? (100 * (player.position_s ?? 0)) / length : 0}%`);
    }
    this.play.dataset.playing = String(player.playing);
    this.play.setAttribute("aria-label", player.playing ? "Pause" : "Play");
    if (document.activeElement !== this.speed && player.speed) this.speed.value = String(player.speed);
    const marks = JSON.stringify(player.closures_s);
    if (marks === this.drawnMarks) return;
    this.drawnMarks = marks;
    this.marks.replaceChildren(...(player.closures_s ?? []).map((at) => make("i", { style: `left:${length > 0 ? (100 * at) / length : 0}%` })));
  }

  toggle(): void {
    if (this.player?.ready) this.send(this.player.playing ? "pause" : "play");
  }

  skip(seconds: number): void {
    if (this.player?.ready) this.send("seek", Math.max(0, (this.player.position_s ?? 0) + seconds));
  }
}
