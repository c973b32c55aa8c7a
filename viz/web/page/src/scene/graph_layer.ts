// The pose graph: the way the robot has driven (through the nodes where they are now), keyframes, and loop closures.
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Group, Points, PointsMaterial, Quaternion, Vector2, Vector3 } from "three";
import { decodeNodes, type LoopItem, type Node, type PoseItem } from "../protocol";
import { DynamicLine } from "./lines";
import { Ribbon } from "./ribbon";
import type { SceneTheme } from "./theme";

const PULSE_MS = 1600;

export class GraphLayer {
  readonly trajectory = new Group();
  readonly keyframes = new Group();
  readonly loops = new Group();
  readonly nodes = new Map<string, Node>();
  private chunks = new Map<string, Node[]>();
  private loopItems = new Map<string, LoopItem>();
  private path: Ribbon;
  private closed: Ribbon;
  private fresh: Ribbon;
  private off: Ribbon;
  private chosen: Ribbon;
  private frusta = new DynamicLine("segments", { opacity: 0.28 });
  private dots: Points;
  private changed = false;
  private chosenKey: string | null = null;
  private freshUntil = new Map<string, number>();
  private tail: Pose3 | null = null;
  private camera: RobotCamera | null = null;
  showRejected = false;

  constructor(viewport: Vector2) {
    this.path = new Ribbon(3, viewport);
    this.closed = new Ribbon(1.5, viewport, 0.5);
    this.fresh = new Ribbon(7, viewport, 0.5);
    this.off = new Ribbon(1.6, viewport, 0.7);
    this.chosen = new Ribbon(6, viewport, 0.9);
    this.trajectory.add(this.path.object);
    this.loops.add(this.off.object, this.closed.object, this.fresh.object, this.chosen.object);
    const geometry = new BufferGeometry();
    this.dots = new Points(geometry, new PointsMaterial({ size: 5, sizeAttenuation: false }));
    this.dots.frustumCulled = false;
    this.keyframes.add(this.frusta.object, this.dots);
    this.path.object.position.z = this.dots.position.z = 0.03;
    this.loops.position.z = 0.05;
  }

  setChunk(key: string, data: DataView | null): void {
    const kind = key[0];
    for (const node of this.chunks.get(key) ?? []) this.nodes.delete(kind + node.id);
    if (data) {
      const nodes = decodeNodes(data);
      this.chunks.set(key, nodes);
      for (const node of nodes) this.nodes.set(kind + node.id, node);
    } else {
      this.chunks.delete(key);
    }
    this.changed = true;
  }

  setLoop(key: string, loop: LoopItem | null, now: number): void {
    const before = this.loopItems.get(key);
    if (loop) {
      this.loopItems.set(key, loop);
      if (loop.state === "closed" && before?.state !== "closed") this.freshUntil.set(key, now + PULSE_MS);
    } else {
      this.loopItems.delete(key);
    }
    this.changed = true;
  }

  setPose(pose: PoseItem | null): void {
    this.tail = pose && { utime: pose.utime, x: pose.t[0], y: pose.t[1], z: pose.t[2] };
    this.changed = true;
  }

  setCamera(camera: [number, number, number, number, number, number, number]): void {
    this.camera = { at: new Vector3(camera[0], camera[1], camera[2]), turn: new Quaternion(camera[4], camera[5], camera[6], camera[3]) };
    this.changed = true;
  }

  clear(): void {
    this.nodes.clear();
    this.chunks.clear();
    this.loopItems.clear();
    this.freshUntil.clear();
    this.tail = null;
    this.changed = true;
  }

  choose(key: string | null): void {
    this.chosenKey = key;
    this.changed = true;
  }

  recolour(theme: SceneTheme): void {
    this.path.colour(theme.trajectory);
    this.closed.colour(theme.loop);
    this.fresh.colour(theme.loop);
    this.chosen.colour(theme.highlight);
    this.off.colour(theme.loopOff);
    this.frusta.colour(theme.keyframe);
    (this.dots.material as PointsMaterial).color.copy(theme.keyframe);
  }

  // Rebuilds what has changed; true while something still moves.
  update(now: number): boolean {
    let moving = false;
    for (const [key, until] of this.freshUntil) {
      if (until < now) this.freshUntil.delete(key);
      this.changed = moving = true;
    }
    if (!this.changed) return false;
    this.changed = false;
    const nodes = [...this.nodes.values()].sort((a, b) => a.utime - b.utime);
    const points: number[] = [];
    for (const node of nodes) points.push(node.x, node.y, node.z);
    const last = nodes[nodes.length - 1];
    if (this.tail && last && this.tail.utime > last.utime) points.push(this.tail.x, this.tail.y, this.tail.z);
    this.path.setStrip(points);
    this.drawKeyframes();
    this.drawLoops(now);
    return moving;
  }

  // The loop whose line passes closest to a point of the screen, within 10 px.
  pick(project: (x: number, y: number, z: number) => [number, number] | null, px: number, py: number): string | null {
    let best: string | null = null;
    let least = 10;
    for (const [key, loop] of this.loopItems) {
      if (loop.state === "rejected" && !this.showRejected && key !== this.chosenKey) continue;
      const ends = this.ends(loop);
      if (!ends) continue;
      const a = project(ends[0], ends[1], ends[2]);
      const b = project(ends[3], ends[4], ends[5]);
      if (!a || !b) continue;
      const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
      const t = Math.min(1, Math.max(0, ((px - a[0]) * dx + (py - a[1]) * dy) / Math.max(1e-9, dx * dx + dy * dy)));
      const d = Math.hypot(a[0] + t * dx - px, a[1] + t * dy - py);
      if (d < least) [least, best] = [d, key];
    }
    return best;
  }

  centreOf(key: string): [number, number, number] | null {
    const loop = this.loopItems.get(key);
    const ends = loop && this.ends(loop);
    return ends ? [(ends[0] + ends[3]) / 2, (ends[1] + ends[4]) / 2, (ends[2] + ends[5]) / 2] : null;
  }

  private ends(loop: LoopItem): number[] | null {
    const a = this.nodes.get(loop.from);
    const b = this.nodes.get(loop.to);
    return a && b ? [a.x, a.y, a.z, b.x, b.y, b.z] : null;
  }

  private drawLoops(now: number): void {
    const lists = { closed: [] as number[], fresh: [] as number[], off: [] as number[], chosen: [] as number[] };
    for (const [key, loop] of this.loopItems) {
      const ends = this.ends(loop);
      if (!ends) continue;
      if (key === this.chosenKey) lists.chosen.push(...ends);
      else if (loop.state === "closed") lists.closed.push(...ends);
      else if (loop.state === "switched_off" || this.showRejected) lists.off.push(...ends);
      if ((this.freshUntil.get(key) ?? 0) > now) lists.fresh.push(...ends);
    }
    this.closed.setSegments(lists.closed);
    this.fresh.setSegments(lists.fresh);
    this.off.setSegments(lists.off);
    this.chosen.setSegments(lists.chosen);
  }

  private drawKeyframes(): void {
    const dots: number[] = [];
    const lines: number[] = [];
    const corners = [[-0.09, -0.07, 0.14], [0.09, -0.07, 0.14], [0.09, 0.07, 0.14], [-0.09, 0.07, 0.14]];
    const p = new Vector3();
    const q = new Quaternion();
    for (const [name, node] of this.nodes) {
      if (name[0] !== "k") continue;
      dots.push(node.x, node.y, node.z);
      if (!this.camera) continue;
      q.set(node.q[1], node.q[2], node.q[3], node.q[0]);
      const apex = this.camera.at.clone().applyQuaternion(q).add(p.set(node.x, node.y, node.z));
      const turn = q.clone().multiply(this.camera.turn);
      const rim = corners.map((c) => new Vector3(c[0], c[1], c[2]).applyQuaternion(turn).add(apex));
      rim.forEach((corner, i) => {
        const next = rim[(i + 1) % 4];
        lines.push(apex.x, apex.y, apex.z, corner.x, corner.y, corner.z, corner.x, corner.y, corner.z, next.x, next.y, next.z);
      });
    }
    this.frusta.set(lines);
    this.dots.geometry.dispose();
    this.dots.geometry = new BufferGeometry();
    this.dots.geometry.setAttribute("position", new BufferAttribute(new Float32Array(dots), 3).setUsage(DynamicDrawUsage));
  }
}

interface Pose3 {
  utime: number;
  x: number;
  y: number;
  z: number;
}

interface RobotCamera {
  at: Vector3;
  turn: Quaternion;
}
