// The scene as a whole: takes items, keeps the layers, and answers what lies under a click.
import { Vector2 } from "three";
import { decodeTile, jsonOf, type Item, type LocalizationItem, type LoopItem, type Pose, type PoseItem, type RobotItem, type Topic } from "./protocol";
import { CloudLayer } from "./scene/cloud_layer";
import { GraphLayer } from "./scene/graph_layer";
import { GridLayer } from "./scene/grid_layer";
import { RobotLayer } from "./scene/robot_layer";
import { THEMES } from "./scene/theme";
import { Viewport } from "./scene/viewport";
import { VoxelLayer } from "./scene/voxel_layer";
import type { Layer } from "./ui/layers";

export class World {
  readonly viewport: Viewport;
  readonly grids = {
    fused: new GridLayer(true, "both", -0.01),
    lidar: new GridLayer(false, "lidar", -0.008),
    visual: new GridLayer(false, "camera", -0.006),
  };
  readonly cloud = new CloudLayer();
  readonly voxels = new VoxelLayer();
  readonly graph: GraphLayer;
  readonly robot: RobotLayer;
  pose: PoseItem | null = null;
  localization: LocalizationItem | null = null;
  tiles = 0; // taken since the page was opened

  constructor(canvas: HTMLCanvasElement) {
    this.viewport = new Viewport(canvas);
    this.graph = new GraphLayer(this.viewport.size as Vector2);
    this.robot = new RobotLayer(this.viewport.size as Vector2);
    this.viewport.scene.add(
      this.grids.fused.group, this.grids.lidar.group, this.grids.visual.group, this.cloud.group, this.voxels.group,
      this.graph.trajectory, this.graph.keyframes, this.graph.loops, this.robot.truth, this.robot.scan, this.robot.robot, this.robot.guess, this.robot.candidate);
  }

  recolour(theme: "light" | "dark"): void {
    for (const part of [this.viewport, this.graph, this.robot, ...Object.values(this.grids)]) part.recolour(THEMES[theme]);
  }

  show(layer: Layer, on: boolean): void {
    const groups = {
      fused: this.grids.fused.group, lidar: this.grids.lidar.group, visual: this.grids.visual.group, cloud: this.cloud.group,
      octomap: this.voxels.group, trajectory: this.graph.trajectory, keyframes: this.graph.keyframes, loops: this.graph.loops,
      truth: this.robot.truth, scan: this.robot.scan,
    };
    groups[layer].visible = on;
    // The viewer sends what is wanted again from the beginning.
    if (!on && layer in this.grids) this.grids[layer as "fused"].clear();
    if (!on && layer === "cloud") this.cloud.clear();
    if (!on && layer === "octomap") this.voxels.clear();
    this.viewport.invalidate();
  }

  clear(): void {
    for (const grid of Object.values(this.grids)) grid.clear();
    this.cloud.clear();
    this.voxels.clear();
    this.graph.clear();
    this.robot.clear();
    this.pose = null;
    this.localization = null;
    this.viewport.invalidate();
  }

  // False for topics that are none of the scene's.
  take(item: Item, now: number): boolean {
    switch (item.topic) {
      case "fused": case "lidar": case "visual": case "octomap": case "cloud":
        this.takeTile(item.topic, item);
        break;
      case "nodes":
        this.graph.setChunk(item.key, item.gone ? null : item.data);
        break;
      case "loop":
        this.graph.setLoop(item.key, item.gone ? null : jsonOf<LoopItem>(item), now);
        break;
      case "pose":
        if (item.key === "localization") {
          this.takeLocalization(item.gone ? null : jsonOf<LocalizationItem>(item));
          break;
        }
        if (item.gone) {
          this.pose = null;
          this.robot.setPose(null);
          this.graph.setPose(null);
          break;
        }
        this.pose = jsonOf<PoseItem>(item);
        this.robot.setPose(this.pose.state === "unknown" ? null : this.pose);
        if (this.pose.source === "slam") this.graph.setPose(this.pose);
        if (this.viewport.follow) this.viewport.moveTo(this.pose.t[0], this.pose.t[1], 0);
        break;
      case "scan":
        this.robot.setScan(item.gone ? null : item.data);
        break;
      case "truth":
        if (item.key === "alignment") {
          if (!item.gone) this.robot.alignTruth(jsonOf<Pose>(item));
        } else {
          this.robot.setTruth(item.key, item.gone ? null : item.data);
        }
        break;
      case "robot":
        if (!item.gone) {
          const robot = jsonOf<RobotItem>(item);
          if (robot.has_camera) this.graph.setCamera(robot.camera);
        }
        break;
      default:
        return false;
    }
    this.viewport.invalidate();
    return true;
  }

  // [x low, y low, x high, y high] of everything there is to see.
  bounds(): [number, number, number, number] | null {
    const box: [number, number, number, number] = [Infinity, Infinity, -Infinity, -Infinity];
    const add = (x: number, y: number): void => {
      box[0] = Math.min(box[0], x);
      box[1] = Math.min(box[1], y);
      box[2] = Math.max(box[2], x);
      box[3] = Math.max(box[3], y);
    };
    for (const grid of Object.values(this.grids)) {
      const b = grid.bounds();
      if (b) {
        add(b[0], b[1]);
        add(b[2], b[3]);
      }
    }
    for (const node of this.graph.nodes.values()) add(node.x, node.y);
    if (this.pose && this.pose.state !== "unknown") add(this.pose.t[0], this.pose.t[1]);
    return Number.isFinite(box[0]) ? box : null;
  }

  render(now: number): boolean {
    if (this.graph.update(now)) this.viewport.invalidate();
    const perspective = this.viewport.view === "3d";
    this.cloud.scaleTo(this.viewport.pixelsPerMetre, perspective);
    const camera = this.viewport.camera;
    this.voxels.seenFrom(camera.position, camera.position.clone().sub(this.viewport.centre), perspective);
    return this.viewport.render();
  }

  // A place that isn't sure yet is drawn as such; the robot itself is drawn where POSE says.
  private takeLocalization(place: LocalizationItem | null): void {
    this.localization = place;
    const perhaps = place?.state === "candidate" && place.t ? place : null;
    this.robot.setCandidate(perhaps?.t ?? null, perhaps?.yaw ?? 0);
  }

  private takeTile(topic: Topic, item: Item): void {
    const layer = topic === "cloud" ? this.cloud : topic === "octomap" ? this.voxels : this.grids[topic as "fused"];
    if (item.gone) return layer.remove(item.key);
    this.tiles++;
    try {
      layer.set(item.key, decodeTile(item.data));
    } catch {
      layer.remove(item.key); // a damaged tile is no reason to stop
    }
  }
}
