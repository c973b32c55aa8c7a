// The robot where it is, its scan, the ground truth, and the arrow with which people say where it is.
import {
  BufferAttribute, BufferGeometry, Color, ConeGeometry, CylinderGeometry, DoubleSide, DynamicDrawUsage, Group, Mesh,
  MeshBasicMaterial, Points, PointsMaterial, Quaternion, RingGeometry, Shape, ShapeGeometry, Vector2,
} from "three";
import type { Pose, PoseItem } from "../protocol";
import { Ribbon } from "./ribbon";
import type { SceneTheme } from "./theme";

function arrow(length: number): ShapeGeometry {
  const shape = new Shape();
  shape.moveTo(length, 0);
  shape.lineTo(-0.65 * length, 0.62 * length);
  shape.lineTo(-0.35 * length, 0);
  shape.lineTo(-0.65 * length, -0.62 * length);
  shape.closePath();
  return new ShapeGeometry(shape);
}

export class RobotLayer {
  readonly robot = new Group();
  readonly scan = new Group();
  readonly truth = new Group();
  readonly guess = new Group();
  readonly candidate = new Group(); // where the localizer thinks the robot may be
  private body: Mesh<ShapeGeometry, MeshBasicMaterial>;
  private rim: Mesh<ShapeGeometry, MeshBasicMaterial>;
  private mast: Mesh<CylinderGeometry, MeshBasicMaterial>;
  private halo: Mesh<RingGeometry, MeshBasicMaterial>;
  private points: Points<BufferGeometry, PointsMaterial>;
  private truthLine: Ribbon;
  private chunks = new Map<string, Float32Array>();
  private theme: SceneTheme | null = null;

  constructor(viewport: Vector2) {
    this.rim = new Mesh(arrow(0.33), new MeshBasicMaterial({ side: DoubleSide }));
    this.rim.position.x = -0.015;
    this.body = new Mesh(arrow(0.26), new MeshBasicMaterial({ side: DoubleSide }));
    this.body.position.z = 0.01;
    this.mast = new Mesh(new CylinderGeometry(0.17, 0.17, 0.3, 24).rotateX(Math.PI / 2).translate(0, 0, 0.15),
                         new MeshBasicMaterial({ transparent: true, opacity: 0.35 }));
    this.halo = new Mesh(new RingGeometry(0.92, 1, 48), new MeshBasicMaterial({ transparent: true, opacity: 0.6, side: DoubleSide }));
    this.robot.add(this.rim, this.body, this.mast, this.halo);
    this.rim.position.z = 0.31;
    this.body.position.z = 0.32;
    this.robot.visible = false;
    this.points = new Points(new BufferGeometry(), new PointsMaterial({ size: 3.5, sizeAttenuation: false }));
    this.points.frustumCulled = false;
    this.scan.add(this.points);
    this.truthLine = new Ribbon(1.6, viewport, 0.9);
    this.truth.add(this.truthLine.object);
    this.truthLine.object.position.z = 0.02;
    const shaft = new Mesh(new CylinderGeometry(0.04, 0.04, 0.8, 12).rotateZ(-Math.PI / 2).translate(0.4, 0, 0), new MeshBasicMaterial());
    const tip = new Mesh(new ConeGeometry(0.14, 0.3, 16).rotateZ(-Math.PI / 2).translate(0.95, 0, 0), shaft.material);
    const foot = new Mesh(new RingGeometry(0.16, 0.22, 32), new MeshBasicMaterial({ side: DoubleSide }));
    this.guess.add(shaft, tip, foot);
    const outline = { transparent: true, opacity: 0.85, side: DoubleSide };
    const circle = new Mesh(new RingGeometry(0.42, 0.5, 40), new MeshBasicMaterial(outline));
    const front = new Mesh(arrow(0.2), new MeshBasicMaterial(outline));
    this.candidate.add(circle, front);
    this.candidate.visible = false;
    this.candidate.position.z = 0.4;
    this.guess.visible = false;
    this.guess.position.z = 0.4;
  }

  setPose(pose: PoseItem | null): void {
    this.robot.visible = pose !== null;
    if (!pose) return;
    place(this.robot, pose);
    // Two standard deviations, when that is more than the robot itself.
    const radius = 2 * pose.sigma_m;
    this.halo.visible = pose.state !== "lost" && radius > 0.3 && radius < 20;
    this.halo.scale.setScalar(radius);
    if (this.theme) this.body.material.color.copy(pose.state === "lost" ? new Color("#d55e00") : this.theme.robot);
  }

  setScan(data: DataView | null): void {
    this.points.visible = data !== null;
    if (!data) return;
    const n = Math.floor((data.byteLength - 36) / 12);
    const f = (at: number): number => data.getFloat32(at, true);
    place(this.scan, { t: [f(8), f(12), f(16)], q: [f(20), f(24), f(28), f(32)] });
    const xyz = new Float32Array(3 * n);
    for (let i = 0; i < 3 * n; i++) xyz[i] = f(36 + 4 * i);
    this.points.geometry.dispose();
    this.points.geometry = new BufferGeometry();
    this.points.geometry.setAttribute("position", new BufferAttribute(xyz, 3).setUsage(DynamicDrawUsage));
  }

  setTruth(key: string, data: DataView | null): void {
    if (!data) {
      this.chunks.delete(key);
    } else {
      const points = new Float32Array(data.byteLength / 4);
      for (let i = 0; i < points.length; i++) points[i] = data.getFloat32(4 * i, true);
      this.chunks.set(key, points);
    }
    const ordered = [...this.chunks.entries()].sort((a, b) => Number(a[0]) - Number(b[0]));
    this.truthLine.setStrip(ordered.flatMap(([, points]) => Array.from(points)));
  }

  alignTruth(pose: Pose): void {
    place(this.truth, pose);
  }

  setGuess(x: number, y: number, yaw: number): void {
    this.guess.position.set(x, y, 0.4);
    this.guess.rotation.z = yaw;
    this.guess.visible = true;
  }

  setCandidate(at: [number, number, number] | null, yaw: number): void {
    this.candidate.visible = at !== null;
    if (!at) return;
    this.candidate.position.set(at[0], at[1], at[2] + 0.4);
    this.candidate.rotation.z = yaw;
  }

  clear(): void {
    this.robot.visible = false;
    this.candidate.visible = false;
    this.chunks.clear();
    this.truthLine.setStrip([]);
    this.points.geometry.dispose();
    this.points.geometry = new BufferGeometry();
  }

  recolour(theme: SceneTheme): void {
    this.theme = theme;
    this.body.material.color.copy(theme.robot);
    this.rim.material.color.copy(theme.robotEdge);
    this.mast.material.color.copy(theme.robot);
    this.halo.material.color.copy(theme.robot);
    this.points.material.color.copy(theme.scan);
    this.truthLine.colour(theme.truth);
    for (const child of [...this.guess.children, ...this.candidate.children]) ((child as Mesh).material as MeshBasicMaterial).color.copy(theme.highlight);
  }
}

function place(group: Group, pose: Pose): void {
  group.position.set(pose.t[0], pose.t[1], pose.t[2]);
  group.quaternion.copy(new Quaternion(pose.q[1], pose.q[2], pose.q[3], pose.q[0]));
}
