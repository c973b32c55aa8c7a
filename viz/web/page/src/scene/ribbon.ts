// A line of a given width in pixels: WebGL's own lines are one pixel wide everywhere, too thin for a trajectory.
import { BufferAttribute, BufferGeometry, Color, DoubleSide, DynamicDrawUsage, Mesh, ShaderMaterial, Vector2 } from "three";

const vertexShader = `
attribute vec3 other;    // the segment's far end
attribute vec2 corner;   // -1 or 1 across, 0 or 1 along
uniform vec2 viewport;   // px
uniform float width;     // px
void main() {
  vec4 a = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  vec4 b = projectionMatrix * modelViewMatrix * vec4(other, 1.0);
  vec2 along = (b.xy / max(b.w, 1e-3) - a.xy / max(a.w, 1e-3)) * viewport;
  float l = length(along);
  vec2 direction = l > 1e-4 ? along / l : vec2(1.0, 0.0);
  vec4 p = corner.y < 0.5 ? a : b;
  vec2 shift = vec2(-direction.y, direction.x) * corner.x * width + direction * (corner.y * 2.0 - 1.0) * width * 0.5;
  p.xy += shift / viewport * p.w;
  gl_Position = p;
}`;
const fragmentShader = `
uniform vec3 tint;
uniform float opacity;
void main() { gl_FragColor = vec4(tint, opacity); }`;

export class Ribbon {
  readonly object: Mesh;
  private material: ShaderMaterial;
  private room = 0;

  constructor(width: number, viewport: Vector2, opacity = 1) {
    this.material = new ShaderMaterial({
      vertexShader, fragmentShader, side: DoubleSide, transparent: opacity < 1,
      uniforms: { viewport: { value: viewport }, width: { value: width }, tint: { value: new Color() }, opacity: { value: opacity } },
    });
    this.object = new Mesh(new BufferGeometry(), this.material);
    this.object.frustumCulled = false;
  }

  // Ends of segments one after another: x, y, z, x, y, z a segment.
  setSegments(ends: ArrayLike<number>): void {
    const n = ends.length / 6;
    if (n > this.room) this.grow(n);
    const geometry = this.object.geometry;
    if (this.room > 0) {
      const a = geometry.getAttribute("position").array as Float32Array;
      const b = geometry.getAttribute("other").array as Float32Array;
      for (let i = 0; i < n; i++)
        for (let c = 0; c < 4; c++)
          for (let k = 0; k < 3; k++) {
            a[12 * i + 3 * c + k] = ends[6 * i + k];
            b[12 * i + 3 * c + k] = ends[6 * i + 3 + k];
          }
      geometry.getAttribute("position").needsUpdate = true;
      geometry.getAttribute("other").needsUpdate = true;
    }
    geometry.setDrawRange(0, 6 * n);
  }

  setStrip(points: ArrayLike<number>): void {
    const n = Math.max(0, points.length / 3 - 1);
    const ends = new Float32Array(6 * n);
    for (let i = 0; i < n; i++) for (let k = 0; k < 6; k++) ends[6 * i + k] = points[3 * i + k];
    this.setSegments(ends);
  }

  colour(colour: Color): void {
    (this.material.uniforms.tint.value as Color).copy(colour);
  }

  private grow(n: number): void {
    this.room = Math.max(64, 2 ** Math.ceil(Math.log2(n)));
    const corners = new Float32Array(8 * this.room);
    const index = new Uint32Array(6 * this.room);
    for (let i = 0; i < this.room; i++) {
      corners.set([-1, 0, 1, 0, 1, 1, -1, 1], 8 * i);
      index.set([0, 1, 2, 0, 2, 3].map((k) => 4 * i + k), 6 * i);
    }
    this.object.geometry.dispose();
    const geometry = new BufferGeometry();
    for (const name of ["position", "other"])
      geometry.setAttribute(name, new BufferAttribute(new Float32Array(12 * this.room), 3).setUsage(DynamicDrawUsage));
    geometry.setAttribute("corner", new BufferAttribute(corners, 2));
    geometry.setIndex(new BufferAttribute(index, 1));
    this.object.geometry = geometry;
  }
}
