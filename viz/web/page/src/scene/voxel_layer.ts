// The OctoMap's occupied voxels as boxes, coloured by height (cividis, readable for the colour-blind). Only those with a free or
// unknown neighbour are drawn, and of each box only the three faces that look at the camera.
import {
  BufferAttribute, DynamicDrawUsage, InstancedBufferAttribute, InstancedBufferGeometry, Mesh, ShaderMaterial,
} from "three";
import { unzlibSync } from "fflate";
import { ENCODING, type TileHead } from "../protocol";
import { PagedLayer } from "./paged_layer";

const N = 32;
const BLOCK = 128;
const BLOCKS = 512;
const UNKNOWN = -128;

// Three faces of the unit cube around the corner (1, 1, 1); the shader mirrors them towards the camera.
const FACES = new Float32Array([
  1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1,
  -1, 1, -1, -1, 1, 1, 1, 1, 1, 1, 1, -1,
  -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1,
]);
const INDEX = [0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7, 8, 9, 10, 8, 10, 11];
const FACE_OF = new Float32Array([0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2]);

const vertexShader = `
attribute float face;
attribute vec4 box;     // centre (m), half edge (m); 0: none
uniform vec3 eye;
uniform vec3 look;      // from the scene to an orthographic camera
uniform bool perspective;
varying vec3 shade;
vec3 cividis(float t) {
  t = clamp(t, 0.0, 1.0);
  return clamp(vec3(-0.0047 + 1.02 * t, 0.135 + 0.72 * t + 0.05 * t * t, 0.33 + 0.55 * t - 0.66 * t * t), 0.0, 1.0);
}
void main() {
  vec3 side = sign(perspective ? eye - box.xyz : look);
  side += vec3(equal(side, vec3(0.0)));
  gl_Position = projectionMatrix * modelViewMatrix * vec4(box.xyz + position * side * box.w, 1.0);
  float light = face < 0.5 ? 0.78 : face < 1.5 ? 0.66 : 1.0;
  shade = cividis(0.15 + box.z / 2.6) * light;
}`;
const fragmentShader = `
varying vec3 shade;
void main() { gl_FragColor = vec4(shade, 1.0); }`;

export class VoxelLayer extends PagedLayer {
  private scratch = new Float32Array(4 * N * N * N);
  private logOdds = new Int8Array(N * N * N);
  private material = new ShaderMaterial({
    vertexShader, fragmentShader, side: 2,
    uniforms: { eye: { value: null }, look: { value: null }, perspective: { value: true } },
  });

  constructor() {
    super(BLOCK, BLOCKS, 0);
  }

  set(key: string, tile: TileHead): void {
    if (tile.encoding !== ENCODING.octomap || tile.size !== N) return;
    const n = this.boxes(tile, unzlibSync(tile.packed));
    this.buffer.replace(key, n, (source, count, page, to) => {
      const target = this.pages[page].attributes[0].array as Float32Array;
      target.set(this.scratch.subarray(4 * source, 4 * (source + count)), 4 * to);
      this.touch(page, to, count);
    });
  }

  seenFrom(eye: unknown, look: unknown, perspective: boolean): void {
    this.material.uniforms.eye.value = eye;
    this.material.uniforms.look.value = look;
    this.material.uniforms.perspective.value = perspective;
  }

  addPage(page: number): void {
    const geometry = new InstancedBufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(FACES, 3));
    geometry.setAttribute("face", new BufferAttribute(FACE_OF, 1));
    geometry.setIndex(INDEX);
    const box = new InstancedBufferAttribute(new Float32Array(4 * this.buffer.pageSize), 4);
    box.setUsage(DynamicDrawUsage);
    geometry.setAttribute("box", box);
    geometry.instanceCount = this.buffer.pageSize;
    const mesh = new Mesh(geometry, this.material);
    mesh.frustumCulled = false;
    this.group.add(mesh);
    this.pages[page] = { geometry, attributes: [box] };
  }

  // Fills scratch with the boxes to be drawn; how many.
  private boxes(tile: TileHead, raw: Uint8Array): number {
    const odds = this.logOdds;
    let at = N * N * N / 8;
    for (let i = 0; i < odds.length; i++) {
      const known = (raw[i >> 3] >> (i & 7)) & 1;
      odds[i] = known ? (raw[at++] << 24) >> 24 : UNKNOWN;
    }
    const solid = (x: number, y: number, z: number): boolean =>
      x >= 0 && y >= 0 && z >= 0 && x < N && y < N && z < N && odds[(z * N + y) * N + x] > 0;
    let n = 0;
    for (let z = 0, i = 0; z < N; z++)
      for (let y = 0; y < N; y++)
        for (let x = 0; x < N; x++, i++) {
          if (odds[i] <= 0) continue;
          if (solid(x - 1, y, z) && solid(x + 1, y, z) && solid(x, y - 1, z) && solid(x, y + 1, z) &&
              solid(x, y, z - 1) && solid(x, y, z + 1)) continue;
          this.scratch[4 * n] = (tile.x * N + x + 0.5) * tile.resolution;
          this.scratch[4 * n + 1] = (tile.y * N + y + 0.5) * tile.resolution;
          this.scratch[4 * n + 2] = (tile.z * N + z + 0.5) * tile.resolution;
          this.scratch[4 * n + 3] = tile.resolution / 2;
          n++;
        }
    return n;
  }
}
