// The page: connection, scene and panels put together.
import { Connection, type ConnectionState } from "./connection";
import { count, duration, find, metres } from "./dom";
import {
  jsonOf, type Batch, type CellAnswer, type DeputyItem, type HealthItem, type InputItem, type Item, type LoopItem,
  type NoticeItem, type PlayerItem, type SessionItem, type Topic,
} from "./protocol";
import { CameraPanel } from "./ui/camera";
import { CellCard } from "./ui/cell_card";
import { setUpHelp, setUpTabs, setUpTheme } from "./ui/chrome";
import { HealthPanel } from "./ui/health";
import { LayerPanel } from "./ui/layers";
import { LocaliseTool } from "./ui/localise";
import { LoopPanel } from "./ui/loops";
import { Notices } from "./ui/notices";
import { StagePanel } from "./ui/stage";
import { Timeline } from "./ui/timeline";
import { World } from "./world";

const WORK_MS = 8; // of each frame for what came; where frames are slow anyway, half of their time
const MOST_WORK_MS = 200;
const ALWAYS: Topic[] = ["time", "notice", "robot", "pose", "health", "input", "deputy", "loop", "nodes", "truth"];

const world = new World(find<HTMLCanvasElement>("canvas"));
const notices = new Notices(find("notices"));
const layers = new LayerPanel(find("layers"), (layer, on) => {
  world.show(layer, on);
  want();
});
const camera = new CameraPanel(() => want());
const card = new CellCard(find("card"));
const timeline = new Timeline((verb, value) => void connection.ask({ type: "replay", verb, ...(value === undefined ? {} : { value }) }));
const health = new HealthPanel((verb, target) => void command({ verb, target }));
const loops = new LoopPanel(
  (key) => {
    world.graph.choose(key);
    const centre = key && world.graph.centreOf(key);
    if (centre && world.viewport.touched) world.viewport.moveTo(centre[0], centre[1], 0);
    world.viewport.invalidate();
  },
  (all) => {
    world.graph.showRejected = all;
    world.graph.choose(null);
    world.viewport.invalidate();
  });
const stage = new StagePanel(world, () => {
  if (!layers.on.has("cloud") && !layers.on.has("octomap")) layers.set("cloud", true); // space without it is empty
});
const localise = new LocaliseTool(world, (x, y, yaw) => void command({ verb: "localise", x, y, yaw }));

let link: ConnectionState = "connecting";
let session: SessionItem | null = null;
const TRACKERS = ["visual_odometry", "lidar_mapper"];
let truthError: number | null = null;
let epoch = -1;
let fresh = false; // connected anew: perhaps to another viewer
let waiting: { batch: Batch; next: number }[] = [];
let frames: number[] = [];
let lastFrame = 0;
let lastDescribed = 0;
let beginnings = 0;
let lastBytes = { at: performance.now(), n: 0, perSecond: 0 };

const connection = new Connection({
  batch: (batch) => waiting.push({ batch, next: 0 }),
  state: (state, retryInS) => {
    link = state;
    waiting = [];
    if (state === "open") fresh = true;
    stage.link(state, retryInS);
  },
  problem: (text) => notices.show("error", text),
});

function want(): void {
  const topics = [...ALWAYS, camera.mode === "live" ? "camera" : "keyframe"] as Topic[];
  for (const layer of ["fused", "lidar", "visual", "cloud", "octomap", "scan"] as const) if (layers.on.has(layer)) topics.push(layer);
  connection.want(topics);
}

async function command(request: Record<string, unknown>): Promise<void> {
  const answer = await connection.ask<{ ok: boolean; text: string }>({ type: "command", ...request });
  if (!answer) notices.show("error", "No answer from the viewer: the command may not have arrived.");
  else notices.show(answer.ok ? "info" : "error", answer.text ?? "Refused.");
}

// A replay went back or the viewer is another one: everything comes again. The player's bar stays.
function startAnew(): void {
  beginnings++;
  world.clear();
  camera.clear();
  health.clear();
  loops.clear();
  session = null;
  truthError = null;
}

function take(item: Item, now: number): void {
  const value = <T>(): T | null => (item.gone ? null : jsonOf<T>(item));
  world.take(item, now);
  switch (item.topic) {
    case "time":
      if (item.key === "player" && !item.gone) timeline.set(jsonOf<PlayerItem>(item));
      if (item.key === "session") session = value<SessionItem>();
      break;
    case "truth":
      if (item.key === "alignment") truthError = value<{ rmse_m: number }>()?.rmse_m ?? null;
      break;
    case "notice": {
      const notice = value<NoticeItem>();
      if (notice) notices.show(notice.level, notice.text);
      break;
    }
    case "health": health.setProcess(item.key, value<HealthItem>()); break;
    case "input": health.setInput(item.key, value<InputItem>()); break;
    case "deputy": health.setDeputy(item.key, value<DeputyItem>()); break;
    case "loop": loops.set(item.key, value<LoopItem>()); break;
    case "camera": if (!item.gone) camera.setLive(item.data); break;
    case "keyframe":
      if (item.gone) camera.clear(); // the map was reset
      else camera.setKeyframe(item.data);
      break;
    default: break;
  }
}

// Works off what came, a little each frame, so that a large map does not stop the page; what is done is acknowledged.
function work(now: number): void {
  const until = performance.now() + Math.min(MOST_WORK_MS, Math.max(WORK_MS, 0.5 * (now - lastFrame)));
  lastFrame = now;
  while (waiting.length > 0 && performance.now() < until) {
    const { batch } = waiting[0];
    if (batch.epoch !== epoch || fresh) {
      if (epoch !== -1) startAnew();
      epoch = batch.epoch;
      fresh = false;
    }
    while (waiting[0].next < batch.items.length && performance.now() < until) take(batch.items[waiting[0].next++], now);
    if (waiting[0].next < batch.items.length) return;
    waiting.shift();
    connection.acknowledge(batch.number);
  }
}

function describe(now: number): void {
  if (now - lastBytes.at > 1000) {
    lastBytes = { at: now, n: connection.bytes, perSecond: (1000 * (connection.bytes - lastBytes.n)) / (now - lastBytes.at) };
    frames = frames.filter((at) => at > now - 2000);
    const drawn = world.cloud.total + world.voxels.total;
    health.setPerformance(`This page: ${(lastBytes.perSecond / 1000).toFixed(0)} kB/s, ${(frames.length / 2).toFixed(0)} frames/s` +
      `${drawn ? `, ${count(drawn)} points and voxels` : ""}.`);
  }
  const replaying = timeline.player !== null;
  layers.count("cloud", world.cloud.total ? count(world.cloud.total) : "");
  layers.count("octomap", world.voxels.total ? count(world.voxels.total) : "");
  layers.count("truth", truthError === null ? "" : `± ${metres(truthError)}`);
  layers.count("loops", session?.loops_closed ? String(session.loops_closed) : "");
  stage.describe({ link, session, player: timeline.player, truthError, problems: replaying ? [] : health.problems(false), hasTracker: health.names().some((name) => TRACKERS.includes(name)) });
  health.render(replaying);
  loops.render(session?.first_utime ?? 0);
}

function frame(now: number): void {
  work(now);
  stage.autoFit();
  if (world.render(now)) frames.push(now);
  if (now - lastDescribed > 200) {
    describe(now);
    lastDescribed = now;
  }
  stage.scale();
  requestAnimationFrame(frame);
}

async function askCell(x: number, y: number, at: [number, number]): Promise<void> {
  const answer = await connection.ask<CellAnswer>({ type: "cell", x, y });
  if (answer) card.show(answer, x, y, at, session?.utime ?? 0, session?.first_utime ?? 0);
}

stage.onClick((x, y, px) => {
  const key = layers.on.has("loops") ? world.graph.pick((a, b, c) => world.viewport.project(a, b, c), px[0], px[1]) : null;
  if (key) {
    card.hide();
    loops.choose(key, true);
    world.graph.choose(key);
    world.viewport.invalidate();
    document.body.dataset.tab = "loops";
    return;
  }
  void askCell(x, y, px);
});
find("save").addEventListener("click", () => void command({ verb: "save_map" }));
find("reset").addEventListener("click", () => {
  if (confirm("Start a new map? What was not saved is lost.")) void command({ verb: "reset" });
});
find("localise").addEventListener("click", () => localise.toggle());
document.addEventListener("keydown", (event) => {
  const inField = event.target instanceof HTMLElement && event.target.closest("input, select, textarea, dialog");
  if (inField || event.ctrlKey || event.metaKey || event.altKey) return;
  if (localise.key(event)) return event.preventDefault();
  const onButton = event.target instanceof HTMLElement && event.target.closest("button, summary");
  if (event.key === " " && !onButton) {
    timeline.toggle();
    event.preventDefault();
  } else if (event.key === "," || event.key === ".") {
    timeline.skip(event.key === "," ? -5 : 5);
  } else if (event.key.toLowerCase() === "l") {
    localise.toggle();
  } else if (event.key === "Escape") {
    card.hide();
    loops.choose(null);
    world.graph.choose(null);
  } else if (event.key === "Enter" && event.target === world.viewport.canvas) {
    const centre = world.viewport.centre;
    void askCell(centre.x, centre.y, [world.viewport.canvas.clientWidth / 2, world.viewport.canvas.clientHeight / 2]);
  } else if (stage.key(event)) {
    event.preventDefault();
  }
});
setUpTheme((theme) => world.recolour(theme));
setUpTabs();
setUpHelp();
for (const layer of ["fused", "lidar", "visual", "cloud", "octomap", "trajectory", "keyframes", "loops", "truth", "scan"] as const)
  world.show(layer, layers.on.has(layer));
want();
requestAnimationFrame(frame);

// For tests and for the curious: what the page has and how fast it is.
Object.assign(window, {
  fusionSlam: {
    world, layers, camera,
    stats: () => ({
      link, beginnings, processes: health.names(), commands: health.commands(), bytes: connection.bytes, bytesPerSecond: lastBytes.perSecond, frames: world.viewport.frames, frameMs: world.viewport.frameMs,
      points: world.cloud.total, voxels: world.voxels.total, fusedTiles: world.grids.fused.tiles, nodes: world.graph.nodes.size,
      tiles: world.tiles, waiting: waiting.length, pose: world.pose, session, player: timeline.player, truthError,
      time: duration((session ? session.utime - session.first_utime : 0) / 1e6),
    }),
    screenOf: (x: number, y: number, z = 0) => world.viewport.project(x, y, z),
  },
});
