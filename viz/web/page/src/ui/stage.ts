// What lies around the canvas: connection, key figures, empty and error states, view buttons, scale, clicks.
import type { ConnectionState } from "../connection";
import { duration, find, make, metres, setText } from "../dom";
import type { PlayerItem, SessionItem } from "../protocol";
import type { World } from "../world";

export interface Situation {
  link: ConnectionState;
  session: SessionItem | null;
  player: PlayerItem | null;
  truthError: number | null;
  problems: string[];
  hasTracker: boolean; // a service that tracks the robot is running
}

export class StagePanel {
  private chip = find("link");
  private facts = find("facts");
  private empty = find("empty");
  private banner = find("banner");
  private lastEmpty = "";
  private fitted = "";
  private wasOpen = false;

  constructor(private world: World, private intoSpace: () => void) {
    find("view2d").addEventListener("click", () => this.view("2d"));
    find("view3d").addEventListener("click", () => this.view("3d"));
    find("fit").addEventListener("click", () => this.fit());
    find("follow").addEventListener("click", () => this.follow(!world.viewport.follow));
    world.viewport.canvas.addEventListener("pointerdown", () => world.viewport.touched && this.follow(false));
  }

  link(state: ConnectionState, retryInS: number): void {
    if (state === "open") this.wasOpen = true;
    const lost = state === "refused"
      ? "The viewer refuses this page: too many browsers are open, or it does not know the name in the address (see --name)."
      : this.wasOpen && state === "lost" ? "The viewer has gone. What you see is its last word." : "";
    this.banner.hidden = lost === "";
    setText(this.banner, lost && `${lost} Trying again${retryInS >= 2 ? ` every ${Math.round(retryInS)} s` : ""}…`);
  }

  describe(now: Situation): void {
    const { session, player } = now;
    const hasMap = this.world.bounds() !== null;
    const pose = this.world.pose;
    const place = this.world.localization;
    let chip: [string, string] = ["wait", "Connecting…"];
    if (now.link === "lost" || now.link === "refused") chip = ["bad", "Disconnected"];
    else if (now.link === "open" && player) chip = player.problem ? ["bad", "Recording unreadable"] : player.ready ? ["replay", "Recording"] : ["wait", `Reading ${Math.round(100 * (player.loaded ?? 0))} %`];
    else if (now.link === "open" && !session?.utime && !hasMap) chip = ["wait", "No data yet"];
    else if (now.link === "open") chip = now.problems.length ? ["warn", "Live, with problems"] : ["good", "Live"];
    this.chip.className = `chip ${chip[0]}`;
    setText(this.chip.lastElementChild as Element, chip[1]);
    if (now.link === "open" && !player) {
      this.banner.hidden = now.problems.length === 0;
      setText(this.banner, now.problems.slice(0, 2).join(". "));
      if (place && place.state !== "localized" && now.problems.length === 0) {
        this.banner.hidden = false;
        setText(this.banner, `The robot is not found in the saved map yet: ${place.reason}. Drive it around, or press Localise and show where it stands.`);
      }
    }
    const rows: [string, string, string][] = [];
    if (place) {
      const since = place.fix_utime && session?.utime ? ` since ${duration((place.fix_utime - session.first_utime) / 1e6)}` : "";
      const words = { unknown: "searching", candidate: `perhaps here, ${place.score_percent} % fits`, localized: `found${since}, ${place.score_percent} % fits` };
      rows.push(["In the saved map", words[place.state], { unknown: "bad", candidate: "warn", localized: "" }[place.state]]);
    }
    if (pose && pose.source === "slam") {
      const words = { ok: `± ${metres(2 * pose.sigma_m)}`, weak: `weak, ± ${metres(2 * pose.sigma_m)}`, lost: "lost", unknown: "unknown" };
      rows.push(["Position", words[pose.state], pose.state === "lost" ? "bad" : pose.state === "weak" ? "warn" : ""]);
    }
    if (session && hasMap) {
      if (session.utime) rows.push(["Time", duration((session.utime - session.first_utime) / 1e6), ""]);
      if (session.path_m > 0) rows.push(["Driven", metres(session.path_m), ""]);
      if (session.area_m2 > 0) rows.push(["Mapped", `${session.area_m2.toFixed(0)} m²`, ""]);
      if (session.keyframes + session.lidar_nodes > 0) rows.push(["Loops", String(session.loops_closed), ""]);
      if (now.truthError !== null) rows.push(["Error", metres(now.truthError), ""]);
    }
    const text = JSON.stringify(rows);
    if (this.facts.dataset.rows !== text) {
      this.facts.dataset.rows = text;
      this.facts.replaceChildren(...rows.map(([name, value, kind]) => make("div", { class: kind }, make("dt", {}, name), make("dd", {}, value))));
    }
    this.showEmpty(now);
  }

  // Keeps everything in view until the person moves it.
  autoFit(): void {
    if (this.world.viewport.touched || this.world.viewport.follow) return;
    const box = this.world.bounds();
    if (!box) return;
    const key = box.map((value) => value.toFixed(1)).join() + this.world.viewport.size.toArray().join() + this.world.viewport.view;
    if (key === this.fitted) return;
    this.fitted = key;
    this.world.viewport.fit(box, this.covered());
  }

  fit(): void {
    const box = this.world.bounds();
    this.follow(false);
    this.world.viewport.touched = false;
    this.fitted = "";
    if (box) this.world.viewport.fit(box, this.covered());
  }

  view(view: "2d" | "3d"): void {
    find("view2d").setAttribute("aria-checked", String(view === "2d"));
    find("view3d").setAttribute("aria-checked", String(view === "3d"));
    this.world.viewport.show(view);
    if (view === "3d") this.intoSpace();
    if (!this.world.viewport.touched) this.fitted = "";
    else if (view === "3d") this.fit();
  }

  follow(on: boolean): void {
    this.world.viewport.follow = on;
    find("follow").setAttribute("aria-pressed", String(on));
    if (on && this.world.pose) this.world.viewport.moveTo(this.world.pose.t[0], this.world.pose.t[1], 0);
  }

  // A click that was no drag: place on the floor (m) and on the canvas (px).
  onClick(handle: (x: number, y: number, px: [number, number]) => void): void {
    const canvas = this.world.viewport.canvas;
    let down: [number, number] | null = null;
    canvas.addEventListener("pointerdown", (event) => (down = event.button === 0 ? [event.clientX, event.clientY] : null));
    canvas.addEventListener("pointerup", (event) => {
      if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 5 || document.body.classList.contains("localising")) return;
      const at = this.world.viewport.floorAt(event.clientX, event.clientY);
      const box = canvas.getBoundingClientRect();
      if (at) handle(at[0], at[1], [event.clientX - box.left, event.clientY - box.top]);
    });
  }

  // True when the key was one of the map's.
  key(event: KeyboardEvent): boolean {
    const viewport = this.world.viewport;
    const moves: Record<string, [number, number]> = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
    if (moves[event.key] && event.target !== viewport.canvas && event.target !== document.body) return false;
    if (moves[event.key]) viewport.panBy(...moves[event.key]);
    else if (event.key === "+" || event.key === "=") viewport.zoomBy(1.25);
    else if (event.key === "-") viewport.zoomBy(0.8);
    else if (event.key === "f" || event.key === "F") this.fit();
    else if (event.key === "r" || event.key === "R") this.follow(!viewport.follow);
    else if (event.key === "2" || event.key === "3") this.view(event.key === "2" ? "2d" : "3d");
    else return false;
    return true;
  }

  scale(): void {
    const root = find("scale");
    root.hidden = this.world.viewport.view === "3d";
    const perMetre = this.world.viewport.pixelsPerMetre / Math.max(1, this.world.viewport.size.x / this.world.viewport.canvas.clientWidth);
    const most = 120 / perMetre;
    const power = 10 ** Math.floor(Math.log10(most));
    const length = [5, 2, 1].map((k) => k * power).find((value) => value <= most) ?? power;
    setText(root.firstElementChild as Element, length >= 1 ? `${length} m` : `${Math.round(length * 100)} cm`);
    (root.lastElementChild as HTMLElement).style.width = `${length * perMetre}px`;
  }

  private covered(): number {
    return matchMedia("(min-width: 900px)").matches ? 236 : 0;
  }

  private showEmpty(now: Situation): void {
    let title = "";
    let text = "";
    let code = "";
    const hasMap = this.world.bounds() !== null;
    if (!this.wasOpen) {
      title = now.link === "connecting" ? "Connecting to the viewer" : "The viewer does not answer";
      text = now.link === "connecting" ? "" : "It may not be running, or run on another machine or port. This page tries again by itself.";
      code = now.link === "connecting" ? "" : "fusion-slam view";
    } else if (now.player?.problem) {
      title = "This recording can't be shown";
      text = now.player.problem;
    } else if (now.player && !now.player.ready) {
      title = "Reading the recording";
      text = `${Math.round(100 * (now.player.loaded ?? 0))} % of ${now.player.file}`;
    } else if (now.link === "open" && !hasMap && !now.player && now.session?.utime && now.hasTracker) {
      title = "The map begins with the next measurements";
      text = "The services run and have no map yet, or were reset.";
    } else if (now.link === "open" && !hasMap && !now.player) {
      title = now.session?.utime ? "Sensors are heard, the map is not" : "Listening to the network";
      text = now.session?.utime
        ? "No service has published a pose or a map yet. The Health panel shows which processes run."
        : "No message has arrived yet. Start the sensors and the services, or play a recording; `fusion-slam doctor` finds what is wrong with a network.";
      code = now.session?.utime ? "fusion-slam service lidar_mapper" : "fusion-slam doctor";
    } else if (now.player?.ready && !hasMap) {
      title = "No map at this moment of the recording";
      text = "Move along the time line, or press play. A recording of sensors alone has none: `run` makes one.";
      code = "fusion-slam run LOG --out DIR";
    }
    const key = title + text;
    if (key === this.lastEmpty) return;
    this.lastEmpty = key;
    this.empty.hidden = title === "";
    this.empty.replaceChildren(make("div", { class: "pulse" }), make("h2", {}, title), text ? make("p", {}, text) : "", code ? make("code", {}, code) : "");
  }
}
