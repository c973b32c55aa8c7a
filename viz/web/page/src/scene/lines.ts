// Lines that change: a buffer that grows in powers of two.
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Line, LineBasicMaterial, LineDashedMaterial, LineSegments } from "three";
import type { Color } from "three";

export class DynamicLine {
  readonly object: Line;
  private position = new BufferAttribute(new Float32Array(3 * 64), 3);

  constructor(kind: "strip" | "segments", options: { opacity?: number; dashed?: number } = {}) {
    const opacity = options.opacity ?? 1;
    const material = options.dashed
      ? new LineDashedMaterial({ dashSize: options.dashed, gapSize: options.dashed * 0.7, transparent: true, opacity })
      : new LineBasicMaterial({ transparent: opacity < 1, opacity });
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.position.setUsage(DynamicDrawUsage));
    geometry.setDrawRange(0, 0);
    this.object = kind === "strip" ? new Line(geometry, material) : new LineSegments(geometry, material);
    this.object.frustumCulled = false;
  }

  set(points: ArrayLike<number>): void {
    if (points.length > this.position.array.length) {
      let size = this.position.array.length;
      while (size < points.length) size *= 2;
      this.position = new BufferAttribute(new Float32Array(size), 3).setUsage(DynamicDrawUsage);
      this.object.geometry.dispose();
      this.object.geometry.setAttribute("position", this.position);
    }
    (this.position.array as Float32Array).set(points);
    this.position.needsUpdate = true;
    this.object.geometry.setDrawRange(0, points.length / 3);
    if (this.object.material instanceof LineDashedMaterial) this.dashes(points);
  }

  colour(colour: Color): void {
    (this.object.material as LineBasicMaterial).color.copy(colour);
  }

  private dashes(points: ArrayLike<number>): void {
    const along = new Float32Array(this.position.count);
    for (let i = 1; i < points.length / 3; i++)
      along[i] = along[i - 1] + Math.hypot(points[3 * i] - points[3 * i - 3], points[3 * i + 1] - points[3 * i - 2],
                                           points[3 * i + 2] - points[3 * i - 1]);
    this.object.geometry.setAttribute("lineDistance", new BufferAttribute(along, 1));
  }
}
