// The bytes that the viewer sends (docs/viewer.md has the tables). Mirrors viz/web/protocol.hpp.

export const TOPICS = [
  "time", "notice", "robot", "pose", "health", "input", "deputy", "scan", "loop",
  "nodes", "truth", "fused", "lidar", "visual", "keyframe", "camera", "octomap", "cloud",
] as const;
export type Topic = (typeof TOPICS)[number];

export interface Item {
  topic: Topic;
  key: string;
  gone: boolean;
  data: DataView;
}

export interface Batch {
  number: number;
  epoch: number;
  items: Item[];
}

const utf8 = new TextDecoder();

export const textOf = (data: DataView): string => utf8.decode(data);
export const jsonOf = <T>(item: Item): T => JSON.parse(textOf(item.data)) as T;
export const bytesOf = (data: DataView, from = 0): Uint8Array =>
  new Uint8Array(data.buffer, data.byteOffset + from, data.byteLength - from);

// Throws RangeError for bytes that are no batch.
export function decodeBatch(buffer: ArrayBuffer): Batch {
  const view = new DataView(buffer);
  if (view.getUint8(0) !== 1) throw new RangeError("an unknown kind of message");
  const batch: Batch = { number: view.getUint32(1, true), epoch: view.getUint32(5, true), items: [] };
  for (let at = 9; at < view.byteLength; ) {
    const keyBytes = view.getUint16(at + 2, true);
    const dataBytes = view.getUint32(at + 4, true);
    const topic = TOPICS[view.getUint8(at)];
    const gone = view.getUint8(at + 1) === 1;
    const key = textOf(new DataView(buffer, at + 8, keyBytes));
    const data = new DataView(buffer, at + 8 + keyBytes, dataBytes);
    if (topic) batch.items.push({ topic, key, gone, data });
    at += 8 + keyBytes + dataBytes;
  }
  return batch;
}

export interface TileHead {
  utime: number;
  x: number;
  y: number;
  z: number;
  resolution: number;
  size: number;
  encoding: number;
  packed: Uint8Array;
}

export const ENCODING = { probability: 1, fused: 2, octomap: 3, cloud: 4 } as const;

export function decodeTile(data: DataView): TileHead {
  return {
    utime: data.getFloat64(0, true),
    x: data.getInt32(8, true),
    y: data.getInt32(12, true),
    z: data.getInt32(16, true),
    resolution: data.getFloat64(20, true),
    size: data.getInt32(28, true),
    encoding: data.getUint8(32),
    packed: bytesOf(data, 33),
  };
}

export interface Pose {
  t: [number, number, number];
  q: [number, number, number, number]; // w, x, y, z
}

export interface PoseItem extends Pose {
  utime: number;
  source: "slam" | "truth";
  state: "unknown" | "ok" | "weak" | "lost";
  reason: string;
  sigma_m: number;
}

// Topic pose, key "localization": of a localizer, when one runs.
export interface LocalizationItem {
  utime: number;
  state: "unknown" | "candidate" | "localized";
  reason: string;
  fix_utime: number; // when the robot was found, from nothing; 0: never
  score_percent: number; // of the LiDAR's points that agree with the map
  t?: [number, number, number]; // where it may be, or is
  yaw?: number;
  sigma_m?: number;
}

export interface RobotItem {
  name: string;
  has_lidar: boolean;
  has_camera: boolean;
  has_odometry: boolean;
  planar: boolean;
  resolution_m: number;
  height_m: number;
  lidar: [number, number, number];
  camera: [number, number, number, number, number, number, number];
}

export interface SessionItem {
  utime: number;
  first_utime: number;
  path_m: number;
  keyframes: number;
  lidar_nodes: number;
  loops_closed: number;
  area_m2: number;
  damaged_tiles: number;
}

export interface PlayerItem {
  ready: boolean;
  file: string;
  loaded?: number;
  problem?: string;
  first_utime?: number;
  duration_s?: number;
  position_s?: number;
  playing?: boolean;
  speed?: number;
  closures_s?: number[];
  damage?: string;
}

export interface HealthItem {
  process: string;
  host: string;
  pid: number;
  state: string;
  text: string;
  silent_s: number;
  rate_hz: number;
  latency_ms: number;
  latency_p95_ms: number;
  latency_p99_ms: number;
  queue: number;
  cpu_percent: number;
  memory_bytes: number;
  dropped: number;
  lost: number;
  late: number;
  rejected: number;
  behind_s: Record<string, number>;
  last_error: string;
}

export interface InputItem {
  channel: string;
  rate_hz: number;
  bytes_s: number;
  utime: number;
  late: boolean;
  late_s: number;
}

export interface Stage {
  stage: string;
  score: number;
  threshold: number;
  passed: boolean;
  reason: string;
}

export interface LoopItem {
  from: string;
  to: string;
  state: "closed" | "rejected" | "switched_off";
  utime: number;
  source: string;
  stages: Stage[];
  off_reason?: string;
  off_squared_error?: number;
}

export interface DeputyItem {
  deputy: string;
  cpu: number;
  memory_total_bytes: number;
  memory_free_bytes: number;
  commands: { name: string; group: string; pid: number; exit_code: number; cpu: number; memory_bytes: number }[];
}

export interface NoticeItem {
  number: number;
  level: "info" | "error";
  text: string;
}

export interface CellAnswer {
  known: boolean;
  cell: [number, number];
  resolution_m: number;
  fused: number | null;
  lidar: number | null;
  visual: number | null;
  provenance: "none" | "lidar" | "camera" | "both" | "conflict";
  first_utime: number;
  changed_utime: number;
  changes: number;
}

export interface Node {
  id: number;
  previous: number;
  utime: number;
  x: number;
  y: number;
  z: number;
  q: [number, number, number, number];
}

export function decodeNodes(data: DataView): Node[] {
  const nodes: Node[] = [];
  for (let at = 0; at + 44 <= data.byteLength; at += 44)
    nodes.push({
      id: data.getUint32(at, true),
      previous: data.getUint32(at + 4, true),
      utime: data.getFloat64(at + 8, true),
      x: data.getFloat32(at + 16, true),
      y: data.getFloat32(at + 20, true),
      z: data.getFloat32(at + 24, true),
      q: [0, 1, 2, 3].map((i) => data.getFloat32(at + 28 + 4 * i, true)) as Node["q"],
    });
  return nodes;
}
