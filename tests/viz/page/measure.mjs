// Frame times and bytes per second: measure.mjs BUILD_DIR WORK_DIR SESSION [POINTS]. Numbers of software drawing (SwiftShader) on this
// machine's processor; a laptop's graphics card is another matter, so the page's own share (JavaScript) is told apart.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { launch, open, start, stats, stop, until } from "./browser.mjs";

const [build, work, session, points = "2000000"] = process.argv.slice(2);
const PORT = "8191";
const URL = `http://127.0.0.1:${PORT}/`;
const faults = [];
const viewer = start(work, "viewer", join(build, "bin/viewer"), [session, "--port", PORT]);
await until("the viewer", async () => (await fetch(`${URL}health`)).ok);
const browser = await launch(join(build, "web_modules"));

// Seconds of processor that the viewer has used.
const cpu = () => {
  const fields = readFileSync(`/proc/${viewer.pid}/stat`, "utf8").split(") ")[1].split(" ");
  return (Number(fields[11]) + Number(fields[12])) / 100;
};
const rss = () => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${viewer.pid}/status`, "utf8"))[1]) / 1000;
const ask = (page, verb, value) => page.evaluate(([v, x]) => new Promise((resolve) => {
  const socket = new WebSocket(`ws://${location.host}/socket`);
  socket.onopen = () => socket.send(JSON.stringify({ type: "replay", id: 1, verb: v, value: x }));
  socket.onmessage = () => resolve(socket.close());
}), [verb, value]);
const wait = (s) => new Promise((resolve) => setTimeout(resolve, 1000 * s));

async function bytesWhilePlaying(page, name, seconds) {
  await ask(page, "seek", 5);
  await wait(2);
  await ask(page, "play");
  await wait(1);
  const before = await stats(page);
  const cpuBefore = cpu();
  await wait(seconds);
  const after = await stats(page);
  await ask(page, "pause");
  const played = after.player.position_s - before.player.position_s;
  console.log(`${name}: ${((after.bytes - before.bytes) / seconds / 1000).toFixed(0)} kB/s, viewer ${((100 * (cpu() - cpuBefore)) / seconds).toFixed(0)} % of a core, ` +
    `${((after.frames - before.frames) / seconds).toFixed(1)} frames/s drawn, ${played.toFixed(1)} s played in ${seconds} s`);
}

async function frameTimes(page, name) {
  const result = await page.evaluate(async () => {
    const { world } = window.fusionSlam;
    const intervals = [];
    const script = [];
    const next = () => new Promise((resolve) => requestAnimationFrame(resolve));
    let last = await next();
    for (let i = 0; i < 40; i++) {
      world.viewport.panBy(0.002, 0.001);
      const now = await next();
      intervals.push(now - last);
      script.push(world.viewport.frameMs);
      last = now;
    }
    const median = (list) => [...list].sort((a, b) => a - b)[list.length >> 1];
    return { interval: median(intervals), script: median(script), points: world.cloud.total + world.voxels.total };
  });
  console.log(`${name}: ${result.points} points and voxels, ${result.interval.toFixed(1)} ms a frame (median of 40), of which the page's own code ${result.script.toFixed(2)} ms`);
}

const page = await open(browser, URL, {}, faults);
await until("the session", async () => (await stats(page)).fusedTiles > 0);
await wait(2);
await frameTimes(page, "map from above");
await bytesWhilePlaying(page, "default layers", 15);
await page.evaluate(() => window.fusionSlam.layers.set("cloud", true));
await page.evaluate(() => window.fusionSlam.layers.set("octomap", true));
await bytesWhilePlaying(page, "with cloud and OctoMap", 15);
await page.getByRole("radio", { name: "Live" }).click();
await bytesWhilePlaying(page, "and live camera", 15);

// Many points: tiles as the mapper sends them, through the same code.
await page.getByRole("radio", { name: "3D" }).click();
const filled = await page.evaluate(async (total) => {
  const per = 5000;
  const { world } = window.fusionSlam;
  let spent = 0;
  for (let k = 0; k * per < total; k++) {
    const raw = new Uint8Array(9 * per);
    for (let i = 0; i < raw.length; i++) raw[i] = (Math.imul(i + k * 7919, 2654435761) >>> 16) & 255;
    const stream = new Blob([raw]).stream().pipeThrough(new CompressionStream("deflate"));
    const packed = new Uint8Array(await new Response(stream).arrayBuffer());
    const began = performance.now();
    world.cloud.set(`test${k}`, { utime: 0, x: k % 20, y: Math.floor(k / 20), z: 0, resolution: 0.02, size: 32, encoding: 4, packed });
    spent += performance.now() - began;
  }
  world.viewport.invalidate();
  return spent;
}, Number(points));
console.log(`decoding ${points} points: ${filled.toFixed(0)} ms in all`);
await wait(3);
await page.getByRole("button", { name: "Fit" }).click();
await wait(2);
await frameTimes(page, "in space");
await page.context().close();

const pages = [];
for (let i = 0; i < 10; i++) pages.push(await open(browser, URL, { viewport: { width: 320, height: 240 } }, faults));
for (const one of pages) await until("a map on each", async () => (await stats(one)).fusedTiles > 0);
await bytesWhilePlaying(pages[0], "one of ten browsers", 15);
const health = await (await fetch(`${URL}health`)).json();
console.log(`ten browsers: ${health.browsers.length} connected, viewer's memory ${rss().toFixed(0)} MB`);
// One that takes nothing any more: what it asked for waits in no queue.
const asleep = await open(browser, `${URL}licences.txt`, {}, faults);
await asleep.evaluate((url) => {
  const socket = new WebSocket(url);
  socket.onopen = () => socket.send(JSON.stringify({ type: "want", topics: ["cloud", "octomap", "fused", "pose", "camera", "nodes"] }));
}, `ws://127.0.0.1:${PORT}/socket`);
const awake = rss();
await bytesWhilePlaying(pages[0], "one of ten browsers, an eleventh asleep", 15);
const eleventh = (await (await fetch(`${URL}health`)).json()).browsers.at(-1);
console.log(`asleep: ${JSON.stringify(eleventh)}, viewer's memory ${awake.toFixed(0)} MB before, ${rss().toFixed(0)} MB after`);
await browser.close();
await stop(viewer);
if (faults.length) console.log(`in the console: ${faults.join("; ")}`);
process.exit();
