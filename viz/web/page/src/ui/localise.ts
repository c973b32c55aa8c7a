// "The robot is here": press where it stands, drag to where it looks; or arrow keys, Q and E, Enter.
import { find, make } from "../dom";
import type { World } from "../world";

const STEP_M = 0.1;
const TURN_RAD = Math.PI / 36;

export class LocaliseTool {
  private active = false;
  private dragging = false;
  private x = 0;
  private y = 0;
  private yaw = 0;
  private button = find("localise");
  private bar = make("div", { class: "toolbar card", hidden: true });
  private text = make("span", {});

  constructor(private world: World, private send: (x: number, y: number, yaw: number) => void) {
    this.bar.append(this.text, make("button", { type: "button", class: "primary", click: () => this.finish() }, "Send"),
                    make("button", { type: "button", click: () => this.toggle() }, "Cancel"));
    find("stage").append(this.bar);
    const canvas = world.viewport.canvas;
    canvas.addEventListener("pointerdown", (event) => {
      if (!this.active || event.button !== 0) return;
      const at = world.viewport.floorAt(event.clientX, event.clientY);
      if (!at) return;
      [this.x, this.y] = at;
      this.dragging = true;
      canvas.setPointerCapture(event.pointerId);
      this.draw();
    });
    canvas.addEventListener("pointermove", (event) => {
      const at = this.dragging ? world.viewport.floorAt(event.clientX, event.clientY) : null;
      if (!at || Math.hypot(at[0] - this.x, at[1] - this.y) < 0.05) return;
      this.yaw = Math.atan2(at[1] - this.y, at[0] - this.x);
      this.draw();
    });
    canvas.addEventListener("pointerup", () => (this.dragging = false));
  }

  get isActive(): boolean {
    return this.active;
  }

  toggle(): void {
    this.active = !this.active;
    this.dragging = false;
    this.button.setAttribute("aria-pressed", String(this.active));
    this.bar.hidden = !this.active;
    document.body.classList.toggle("localising", this.active);
    this.world.viewport.enableControls(!this.active);
    this.world.robot.guess.visible = false;
    if (this.active) {
      const pose = this.world.pose;
      [this.x, this.y] = pose ? [pose.t[0], pose.t[1]] : [this.world.viewport.centre.x, this.world.viewport.centre.y];
      this.yaw = pose ? 2 * Math.atan2(pose.q[3], pose.q[0]) : 0;
      this.draw();
    } else {
      this.world.viewport.invalidate();
    }
  }

  // True when the key was meant for this tool.
  key(event: KeyboardEvent): boolean {
    if (!this.active || (event.target instanceof HTMLElement && event.target.closest("button"))) return false;
    const step = event.shiftKey ? 5 * STEP_M : STEP_M;
    const moves: Record<string, [number, number, number]> = {
      ArrowLeft: [-step, 0, 0], ArrowRight: [step, 0, 0], ArrowUp: [0, step, 0], ArrowDown: [0, -step, 0],
      q: [0, 0, TURN_RAD], e: [0, 0, -TURN_RAD],
    };
    const move = moves[event.key];
    if (event.key === "Enter") this.finish();
    else if (event.key === "Escape") this.toggle();
    else if (!move) return false;
    else {
      this.x += move[0];
      this.y += move[1];
      this.yaw += move[2];
      this.draw();
    }
    return true;
  }

  private finish(): void {
    this.send(this.x, this.y, Math.atan2(Math.sin(this.yaw), Math.cos(this.yaw)));
    this.toggle();
  }

  private draw(): void {
    this.world.robot.setGuess(this.x, this.y, this.yaw);
    this.world.viewport.invalidate();
    const degrees = Math.round((Math.atan2(Math.sin(this.yaw), Math.cos(this.yaw)) * 180) / Math.PI);
    this.text.textContent = `Press where the robot stands, drag to where it looks: ${this.x.toFixed(2)}, ${this.y.toFixed(2)} m, ${degrees}°`;
  }
}
