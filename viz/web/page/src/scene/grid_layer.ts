// The 2D grids: tiles of 64 x 64 cells as layers of array textures, one draw call for 256 tiles. A changed tile uploads 8 KB.
import {
  DataArrayTexture, DynamicDrawUsage, GLSL3, Group, InstancedBufferAttribute, InstancedBufferGeometry, Mesh,
  NearestFilter, PlaneGeometry, RGFormat, ShaderMaterial, UnsignedByteType,
} from "three";
import { unzlibSync } from "fflate";
import { ENCODING, type TileHead } from "../protocol";
import type { SceneTheme } from "./theme";

const CELLS = 64;
const PER_PAGE = 256;

const vertexShader = `
in vec3 tile;  // x, y of the low corner (m), layer
uniform float edge;
out vec2 cell;
flat out int layer;
void main() {
  cell = position.xy * ${CELLS}.0;
  layer = int(tile.z + 0.5);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(tile.xy + position.xy * edge, 0.0, 1.0);
}`;

// Where a pixel covers several cells the most occupied of them counts, so that walls do not vanish from afar.
const fragmentShader = `
precision highp float;
precision highp sampler2DArray;
uniform sampler2DArray cells;
uniform vec3 freeColour, lidarColour, cameraColour, bothColour, conflictColour, plainColour;
uniform bool provenance;
in vec2 cell;
flat in int layer;
out vec4 colour;
void main() {
  int n = int(clamp(ceil(fwidth(cell.x)), 1.0, 5.0));
  vec2 best = vec2(0.0);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      ivec2 at = ivec2(clamp(cell + vec2(i, j) - 0.5 * float(n - 1), 0.0, ${CELLS - 1}.0));
      vec2 here = floor(texelFetch(cells, ivec3(at, layer), 0).rg * 255.0 + 0.5);
      if (here.x > best.x) best = here;
    }
  if (best.x < 0.5) discard;
  float p = (best.x - 1.0) / 254.0;
  vec3 wall = plainColour;
  if (provenance) {
    if (best.y < 1.5) wall = lidarColour;
    else if (best.y < 2.5) wall = cameraColour;
    else if (best.y < 3.5) wall = bothColour;
    else wall = conflictColour;
  }
  colour = vec4(mix(freeColour, wall, smoothstep(0.35, 0.75, p)), 1.0);
}`;

interface Slot {
  page: number;
  layer: number;
  seen: number[] | null; // around its known cells, m
}

interface Page {
  texture: DataArrayTexture;
  pixels: Uint8Array;
  tiles: InstancedBufferAttribute;
  mesh: Mesh;
  used: number;
}

export class GridLayer {
  readonly group = new Group();
  private pages: Page[] = [];
  private slots = new Map<string, Slot>();
  private spare: { page: number; layer: number }[] = [];
  private theme: SceneTheme | null = null;
  private edge = 3.2;

  // With provenance: a wall's colour says which sensors see it. Else all have the colour of `plain`.
  constructor(private provenance: boolean, private plain: keyof SceneTheme, height: number) {
    this.group.position.z = height;
  }

  set(key: string, tile: TileHead): void {
    const raw = unzlibSync(tile.packed);
    const n = CELLS * CELLS;
    if (tile.size !== CELLS || raw.length !== (tile.encoding === ENCODING.fused ? 2 * n : n)) return;
    const slot = this.slots.get(key) ?? this.newSlot(key, tile);
    const page = this.pages[slot.page];
    const base = slot.layer * n * 2;
    const seen = [CELLS, CELLS, 0, 0];
    for (let i = 0; i < n; i++) {
      if (raw[i]) {
        seen[0] = Math.min(seen[0], i % CELLS);
        seen[1] = Math.min(seen[1], i >> 6);
        seen[2] = Math.max(seen[2], (i % CELLS) + 1);
        seen[3] = Math.max(seen[3], (i >> 6) + 1);
      }
      page.pixels[base + 2 * i] = raw[i];
      page.pixels[base + 2 * i + 1] = tile.encoding === ENCODING.fused ? raw[n + i] : 0;
    }
    slot.seen = seen[2] > 0 ? seen.map((cell, i) => (i % 2 ? tile.y : tile.x) * this.edge + cell * tile.resolution) : null;
    page.texture.addLayerUpdate(slot.layer);
    page.texture.needsUpdate = true;
  }

  remove(key: string): void {
    const slot = this.slots.get(key);
    if (!slot) return;
    const page = this.pages[slot.page];
    page.pixels.fill(0, slot.layer * CELLS * CELLS * 2, (slot.layer + 1) * CELLS * CELLS * 2);
    page.texture.addLayerUpdate(slot.layer);
    page.texture.needsUpdate = true;
    this.slots.delete(key);
    this.spare.push(slot);
  }

  clear(): void {
    for (const page of this.pages) {
      page.texture.dispose();
      page.mesh.geometry.dispose();
      (page.mesh.material as ShaderMaterial).dispose();
    }
    this.group.clear();
    this.pages = [];
    this.slots.clear();
    this.spare = [];
  }

  recolour(theme: SceneTheme): void {
    this.theme = theme;
    for (const page of this.pages) this.paint(page);
  }

  get tiles(): number {
    return this.slots.size;
  }

  // Around all known cells: [x low, y low, x high, y high] in metres, or null.
  bounds(): [number, number, number, number] | null {
    let box: [number, number, number, number] | null = null;
    for (const { seen } of this.slots.values()) {
      if (!seen) continue;
      box ??= [Infinity, Infinity, -Infinity, -Infinity];
      box = [Math.min(box[0], seen[0]), Math.min(box[1], seen[1]), Math.max(box[2], seen[2]), Math.max(box[3], seen[3])];
    }
    return box;
  }

  private newSlot(key: string, tile: TileHead): Slot {
    this.edge = tile.resolution * tile.size;
    let free = this.spare.pop();
    if (!free) {
      const last = this.pages[this.pages.length - 1];
      if (!last || last.used === PER_PAGE) this.addPage();
      free = { page: this.pages.length - 1, layer: this.pages[this.pages.length - 1].used++ };
    }
    const page = this.pages[free.page];
    page.tiles.setXYZ(free.layer, tile.x * this.edge, tile.y * this.edge, free.layer);
    page.tiles.needsUpdate = true;
    (page.mesh.geometry as InstancedBufferGeometry).instanceCount = page.used;
    (page.mesh.material as ShaderMaterial).uniforms.edge.value = this.edge;
    const slot: Slot = { ...free, seen: null };
    this.slots.set(key, slot);
    return slot;
  }

  private addPage(): void {
    const pixels = new Uint8Array(CELLS * CELLS * 2 * PER_PAGE);
    const texture = new DataArrayTexture(pixels, CELLS, CELLS, PER_PAGE);
    texture.format = RGFormat;
    texture.type = UnsignedByteType;
    texture.minFilter = texture.magFilter = NearestFilter;
    texture.unpackAlignment = 1;
    texture.needsUpdate = true;
    const plane = new PlaneGeometry(1, 1).translate(0.5, 0.5, 0);
    const geometry = new InstancedBufferGeometry();
    geometry.index = plane.index;
    geometry.setAttribute("position", plane.getAttribute("position"));
    const tiles = new InstancedBufferAttribute(new Float32Array(3 * PER_PAGE), 3);
    tiles.setUsage(DynamicDrawUsage);
    geometry.setAttribute("tile", tiles);
    geometry.instanceCount = 0;
    const material = new ShaderMaterial({
      vertexShader, fragmentShader, glslVersion: GLSL3, depthWrite: false,
      uniforms: {
        cells: { value: texture }, edge: { value: this.edge }, provenance: { value: this.provenance },
        freeColour: { value: null }, lidarColour: { value: null }, cameraColour: { value: null },
        bothColour: { value: null }, conflictColour: { value: null }, plainColour: { value: null },
      },
    });
    const mesh = new Mesh(geometry, material);
    mesh.frustumCulled = false;
    mesh.renderOrder = -10;
    this.group.add(mesh);
    const page = { texture, pixels, tiles, mesh, used: 0 };
    this.pages.push(page);
    this.paint(page);
  }

  private paint(page: Page): void {
    if (!this.theme) return;
    const uniforms = (page.mesh.material as ShaderMaterial).uniforms;
    uniforms.freeColour.value = this.theme.free;
    uniforms.lidarColour.value = this.theme.lidar;
    uniforms.cameraColour.value = this.theme.camera;
    uniforms.bothColour.value = this.theme.both;
    uniforms.conflictColour.value = this.theme.conflict;
    uniforms.plainColour.value = this.theme[this.plain];
  }
}
