// Canvas, cameras and controls: a map from above and a view in space, drawn only when something has changed.
import { GridHelper, Group, LineBasicMaterial, LinearSRGBColorSpace, MOUSE, OrthographicCamera, PerspectiveCamera, Plane, Raycaster, Scene, TOUCH, Vector2, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { SceneTheme } from "./theme";

export type View = "2d" | "3d";

export class Viewport {
  readonly scene = new Scene();
  readonly size = new Vector2(1, 1);  // device pixels
  readonly floor = new Group();
  touched = false;  // the person has moved the view: it is theirs now
  frames = 0;
  frameMs = 0;      // of the last frame, on this thread
  view: View = "2d";
  follow = false;
  private renderer: WebGLRenderer;
  private flat = new OrthographicCamera(-10, 10, 10, -10, -500, 500);
  private deep = new PerspectiveCamera(50, 1, 0.1, 2000);
  private controls: Record<View, OrbitControls>;
  private dirty = true;
  private ray = new Raycaster();
  private lines: GridHelper | null = null;

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.flat.up.set(0, 1, 0);
    this.deep.up.set(0, 0, 1);
    this.flat.position.set(0, 0, 100);
    this.deep.position.set(-6, -8, 8);
    this.controls = { "2d": new OrbitControls(this.flat, canvas), "3d": new OrbitControls(this.deep, canvas) };
    const flat = this.controls["2d"];
    flat.enableRotate = false;
    flat.screenSpacePanning = true;
    flat.zoomToCursor = true;
    flat.mouseButtons = { LEFT: MOUSE.PAN, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN };
    flat.touches = { ONE: TOUCH.PAN, TWO: TOUCH.DOLLY_PAN };
    flat.minZoom = 0.02;
    flat.maxZoom = 200;
    this.controls["3d"].maxPolarAngle = Math.PI * 0.495;
    this.controls["3d"].enableDamping = false;
    for (const controls of Object.values(this.controls)) {
      controls.addEventListener("change", () => this.invalidate());
      controls.addEventListener("start", () => (this.touched = true));
    }
    this.scene.add(this.floor);
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement as HTMLElement);
    this.resize();
    this.show("2d");
  }

  show(view: View): void {
    const from = this.controls[this.view].target;
    this.view = view;
    this.controls["2d"].enabled = view === "2d";
    this.controls["3d"].enabled = view === "3d";
    this.moveTo(from.x, from.y, 0);
    this.invalidate();
  }

  enableControls(on: boolean): void {
    this.controls[this.view].enabled = on;
  }

  invalidate(): void {
    this.dirty = true;
  }

  get camera(): OrthographicCamera | PerspectiveCamera {
    return this.view === "2d" ? this.flat : this.deep;
  }

  // Pixels a metre covers: everywhere (2D), at distance 1 (3D).
  get pixelsPerMetre(): number {
    const height = this.size.y;
    if (this.view === "2d") return (height / (this.flat.top - this.flat.bottom)) * this.flat.zoom;
    return height / (2 * Math.tan((this.deep.fov * Math.PI) / 360));
  }

  moveTo(x: number, y: number, z: number): void {
    const controls = this.controls[this.view];
    const shift = new Vector3(x, y, z).sub(controls.target);
    controls.target.add(shift);
    this.camera.position.add(shift);
    this.invalidate();
  }

  // Shows a rectangle of the floor, leaving `margin` pixels at the left for what lies over the canvas.
  fit(box: [number, number, number, number], left: number): void {
    const [w, h] = [Math.max(4, box[2] - box[0]), Math.max(4, box[3] - box[1])];
    const [x, y] = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
    const ratio = this.size.x / this.size.y;
    const usable = Math.max(0.4, 1 - left / (this.size.x / this.renderer.getPixelRatio()));
    const height = 1.12 * Math.max(h, w / (ratio * usable));
    if (this.view === "2d") {
      this.flat.zoom = (this.flat.top - this.flat.bottom) / height;
      this.flat.updateProjectionMatrix();
      this.moveTo(x - (height * ratio * (1 - usable)) / 2, y, 0);
    } else {
      const distance = (0.95 * height) / (2 * Math.tan((this.deep.fov * Math.PI) / 360));
      this.controls["3d"].target.set(x, y, 0);
      this.deep.position.set(x - 0.25 * distance, y - 0.75 * distance, 0.85 * distance);
      this.controls["3d"].update();
    }
    this.invalidate();
  }

  zoomBy(factor: number): void {
    this.touched = true;
    if (this.view === "2d") {
      this.flat.zoom = Math.min(200, Math.max(0.02, this.flat.zoom * factor));
      this.flat.updateProjectionMatrix();
    } else {
      const target = this.controls["3d"].target;
      this.deep.position.sub(target).divideScalar(factor).add(target);
    }
    this.invalidate();
  }

  // Moves by a part of what is seen.
  panBy(right: number, up: number): void {
    this.touched = true;
    const target = this.controls[this.view].target;
    const height = this.view === "2d" ? (this.flat.top - this.flat.bottom) / this.flat.zoom : this.deep.position.distanceTo(target);
    const heading = this.view === "2d" ? Math.PI / 2 : Math.atan2(target.y - this.deep.position.y, target.x - this.deep.position.x);
    const [c, s] = [Math.cos(heading), Math.sin(heading)];
    this.moveTo(target.x + height * (up * c + right * s), target.y + height * (up * s - right * c), target.z);
  }

  // Where the floor is under a point of the page.
  floorAt(clientX: number, clientY: number): [number, number] | null {
    const box = this.canvas.getBoundingClientRect();
    const ndc = new Vector2(((clientX - box.left) / box.width) * 2 - 1, 1 - ((clientY - box.top) / box.height) * 2);
    this.ray.setFromCamera(ndc, this.camera);
    const hit = this.ray.ray.intersectPlane(new Plane(new Vector3(0, 0, 1), 0), new Vector3());
    return hit ? [hit.x, hit.y] : null;
  }

  // A point of the map on the canvas, CSS pixels; null behind the camera.
  project(x: number, y: number, z: number): [number, number] | null {
    const p = new Vector3(x, y, z).project(this.camera);
    if (p.z > 1) return null;
    return [((p.x + 1) / 2) * this.canvas.clientWidth, ((1 - p.y) / 2) * this.canvas.clientHeight];
  }

  get centre(): Vector3 {
    return this.controls[this.view].target;
  }

  recolour(theme: SceneTheme): void {
    this.scene.background = theme.background;
    if (this.lines) this.scene.remove(this.lines);
    this.lines = new GridHelper(400, 400, theme.lines, theme.lines);
    this.lines.rotation.x = Math.PI / 2;
    this.lines.position.z = -0.02;
    (this.lines.material as LineBasicMaterial).depthWrite = false;
    this.lines.renderOrder = -20;
    this.scene.add(this.lines);
    this.invalidate();
  }

  // Draws when something has changed; true when it did.
  render(): boolean {
    if (!this.dirty) return false;
    this.dirty = false;
    const began = performance.now();
    if (this.lines) this.lines.visible = this.view === "3d" || this.pixelsPerMetre > 6;
    this.renderer.render(this.scene, this.camera);
    this.frameMs = performance.now() - began;
    this.frames++;
    return true;
  }

  private resize(): void {
    const box = (this.canvas.parentElement as HTMLElement).getBoundingClientRect();
    if (box.width < 1 || box.height < 1) return;
    this.renderer.setSize(box.width, box.height, false);
    this.renderer.getDrawingBufferSize(this.size);
    const ratio = box.width / box.height;
    [this.flat.left, this.flat.right, this.flat.top, this.flat.bottom] = [-10 * ratio, 10 * ratio, 10, -10];
    this.deep.aspect = ratio;
    this.flat.updateProjectionMatrix();
    this.deep.updateProjectionMatrix();
    this.invalidate();
  }
}
