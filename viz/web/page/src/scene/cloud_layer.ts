// The coloured point cloud: pages of 131,072 points, one draw call each.
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Points, ShaderMaterial } from "three";
import { unzlibSync } from "fflate";
import { ENCODING, type TileHead } from "../protocol";
import { PagedLayer } from "./paged_layer";

const BLOCK = 256;
const BLOCKS = 512;
const NOWHERE = 1e9; // behind every far plane

const vertexShader = `
attribute vec3 tint;
uniform float size;      // m
uniform float pixels;    // px a metre at distance 1 (perspective) or everywhere (orthographic)
uniform bool perspective;
varying vec3 shade;
void main() {
  vec4 p = modelViewMatrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * p;
  gl_PointSize = clamp(size * pixels / (perspective ? max(0.1, -p.z) : 1.0), 1.5, 12.0);
  shade = tint;
}`;
const fragmentShader = `
varying vec3 shade;
void main() { gl_FragColor = vec4(shade, 1.0); }`;

export class CloudLayer extends PagedLayer {
  private material = new ShaderMaterial({
    vertexShader, fragmentShader,
    uniforms: { size: { value: 0.03 }, pixels: { value: 500 }, perspective: { value: true } },
  });

  constructor() {
    super(BLOCK, BLOCKS, NOWHERE);
  }

  set(key: string, tile: TileHead): void {
    if (tile.encoding !== ENCODING.cloud) return;
    const raw = unzlibSync(tile.packed);
    const n = Math.floor(raw.length / 9);
    const view = new DataView(raw.buffer, raw.byteOffset, raw.byteLength);
    const edge = tile.resolution * tile.size;
    this.material.uniforms.size.value = Math.max(0.01, tile.resolution * 1.2);
    this.buffer.replace(key, n, (source, count, page, to) => {
      const [position, tint] = this.pages[page].attributes;
      const xyz = position.array as Float32Array;
      const rgb = tint.array as Uint8Array;
      for (let i = 0; i < count; i++) {
        const s = source + i;
        const t = 3 * (to + i);
        xyz[t] = (tile.x + (view.getUint16(2 * s, true) + 0.5) / 65536) * edge;
        xyz[t + 1] = (tile.y + (view.getUint16(2 * (n + s), true) + 0.5) / 65536) * edge;
        xyz[t + 2] = (tile.z + (view.getUint16(2 * (2 * n + s), true) + 0.5) / 65536) * edge;
        rgb[t] = raw[6 * n + s];
        rgb[t + 1] = raw[7 * n + s];
        rgb[t + 2] = raw[8 * n + s];
      }
      this.touch(page, to, count);
    });
  }

  scaleTo(pixelsPerMetre: number, perspective: boolean): void {
    this.material.uniforms.pixels.value = pixelsPerMetre;
    this.material.uniforms.perspective.value = perspective;
  }

  addPage(page: number): void {
    const n = this.buffer.pageSize;
    const position = new BufferAttribute(new Float32Array(3 * n).fill(NOWHERE), 3).setUsage(DynamicDrawUsage);
    const tint = new BufferAttribute(new Uint8Array(3 * n), 3, true).setUsage(DynamicDrawUsage);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", position);
    geometry.setAttribute("tint", tint);
    const points = new Points(geometry, this.material);
    points.frustumCulled = false;
    this.group.add(points);
    this.pages[page] = { geometry, attributes: [position, tint] };
  }
}
