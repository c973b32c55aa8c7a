// The page as a person meets it: page_test.mjs BUILD_DIR WORK_DIR. Runs in a network namespace of its own (page_test).
import { existsSync, mkdirSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { check, launch, open, run, start, stats, stop, until } from "./browser.mjs";

const [build, work] = process.argv.slice(2);
const bin = (name) => join(build, "bin", name);
const NETWORK = "udpm://239.255.76.67:7667?ttl=0";
const PORT = "8190";
const URL = `http://127.0.0.1:${PORT}/`;
const SERVICES = ["visual_odometry", "lidar_mapper", "loop_detector", "pose_graph", "dense_mapper", "fuser"];
const faults = [];
const LAB = join(work, "lab.cfg");

rmSync(work, { recursive: true, force: true });
mkdirSync(join(work, "saved"), { recursive: true });
writeFileSync(LAB, 'cmd "worker" { exec = "/bin/sleep 3600"; deputy = "robot"; }\n');
const shot = (page, name) => page.screenshot({ path: join(work, `${name}.png`) });
const text = (page, selector) => page.locator(selector).innerText();
const view = (session = []) => start(work, "viewer", bin("viewer"), [...session, "--port", PORT, "--lcm-url", NETWORK, "--save-dir", join(work, "saved"), "--lab", LAB]);
const knows = ({ processes }) => SERVICES.every((service) => processes.includes(service));
const ready = () => until("the viewer to serve", async () => (await fetch(`${URL}health`)).ok);

async function live(browser) {
  await run(work, "simulate", bin("simulate"), [
    join(process.env.SOURCE_DIR, "config/worlds/office.yaml"), "--seed", "1", "--seconds", "20", "--camera-hz", "5", "--out", join(work, "office.lcm")]);
  let viewer = view();
  await ready();
  const page = await open(browser, URL, { colorScheme: "light" }, faults);
  await until("the empty state", async () => (await text(page, "#empty")).includes("Listening to the network"));
  check((await text(page, "#link")).includes("No data yet"), "with no data it says so, and what to do");
  await shot(page, "empty");

  const services = new Map(SERVICES.map((name) => [name, start(work, name, bin(name), ["--lcm-url", NETWORK])]));
  await until("every service to be seen", async () => knows(await stats(page)));
  const logger = start(work, "logger", "lcm-logger", ["--force", "--quiet", `--lcm-url=${NETWORK}`, join(work, "session.lcmlog")]);
  const player = start(work, "player", "lcm-logplayer", ["--speed=0.7", `--lcm-url=${NETWORK}`, join(work, "office.lcm")]);
  player.startedAt = Date.now();
  // At its pace it can't be further than 8.4 s by then, however far behind page and services are.
  setTimeout(() => player.kill("SIGSTOP"), 12_000).unref();
  const early = await until("a first map", async () => {
    const now = await stats(page);
    return now.session?.area_m2 > 2 && now.fusedTiles > 0 && now.nodes > 2 ? now : null;
  });
  check((await text(page, "#link")).startsWith("Live"), "it says Live");
  await shot(page, "live");
  await reset(page, player);
  await player.ended;
  // The services go on with what waits: the map is whole when the pose is that of the last measurement and nothing changes any more.
  let area = 0;
  let same = 0;
  const whole = await until("the map to be whole", async () => {
    const now = await stats(page);
    same = now.session.area_m2 === area ? same + 1 : 0;
    area = now.session.area_m2;
    return same > 12 && now.session.utime - now.pose.utime < 500_000 ? now : null;
  });
  check(whole.session.path_m > 1, `the robot has driven ${whole.session.path_m.toFixed(1)} m`);
  check(whole.truthError !== null, `the error against ground truth is shown (${whole.truthError} m)`);

  await cell(page, whole);
  await page.keyboard.press("Escape");
  await page.getByRole("button", { name: "Save map" }).click();
  await until("the map to be saved", async () => (await text(page, "#notices")).includes("Saved to"));
  const folder = join(work, "saved", readdirSync(join(work, "saved"))[0]);
  for (const file of ["map.pgm", "map.yaml", "octomap.bt", "cloud.ply", "trajectory.tum"]) check(existsSync(join(folder, file)), `saved ${file}`);
  await stop(logger, "SIGINT");

  await stop(viewer, "SIGKILL");
  await until("the page to notice that the viewer has gone", async () => (await text(page, "#link")).includes("Disconnected"));
  await shot(page, "disconnected");
  viewer = view();
  await until("the page to have everything again", async () => {
    const now = await stats(page);
    return now.link === "open" && now.beginnings > whole.beginnings && now.fusedTiles >= whole.fusedTiles && now.nodes >= whole.nodes && now.session?.area_m2 > 0.99 * whole.session.area_m2;
  });
  check(true, "a viewer that was killed and started again is whole again, and so is the page");

  // A viewer knows the processes that it has heard, each once a second; this one has just begun.
  await until("the new viewer to have heard every service", async () => knows(await stats(page)));
  await stop(services.get("lidar_mapper"), "SIGKILL");
  await until("the dead process to be named", async () => (await text(page, "#banner")).includes("lidar_mapper has said nothing"));
  check(true, "a process that dies is named at the top");
  await shot(page, "problem");
  await localise(page);
  await processes(page);
  for (const service of services.values()) await stop(service);
  await page.context().close();
  check((await stop(viewer)) === 0, "the viewer ends with 0 when asked to");
}

// While the player holds still nothing new comes: the map has to be gone whole, and then begin anew.
async function reset(page, player) {
  await until("some driving", async () => {
    const { session } = await stats(page);
    return session.utime - session.first_utime > 3e6;
  });
  player.kill("SIGSTOP");
  check(player.exitCode === null, "the recording has not ended yet");
  page.once("dialog", (dialog) => void dialog.accept());
  await page.getByRole("button", { name: "Reset" }).click();
  await until("the old map to be gone", async () => {
    const now = await stats(page);
    return now.session.area_m2 === 0 && now.fusedTiles === 0 && now.nodes === 0;
  });
  check((await stats(page)).link === "open", "Reset: every service has given up its map");
  await until("the page to say what is next", async () => (await text(page, "#empty")).includes("begins with the next measurements"));
  await shot(page, "reset");
  await new Promise((resolve) => setTimeout(resolve, Math.max(0, player.startedAt + 12_500 - Date.now())));
  player.kill("SIGCONT");
  const anew = await until("the new map", async () => {
    const now = await stats(page);
    return now.session.area_m2 > 2 && now.fusedTiles > 0 && now.nodes > 2 ? now : null;
  });
  check(true, `the map begins anew and grows from nothing to ${anew.session.area_m2.toFixed(1)} m2`);
}

// A process of the lab, through the sheriff and a deputy: "worker" is a shell that waits.
async function processes(page) {
  const deputy = start(work, "deputy", bin("procman-deputy"), ["--name", "robot", "--lcm-url", NETWORK, "--allow-anything"]);
  const row = page.locator("#health li", { has: page.getByText("worker", { exact: true }) });
  const button = (verb) => page.getByRole("button", { name: `${verb} worker` });
  const pid = async () => (await stats(page)).commands.find((one) => one.name === "worker")?.pid ?? 0;
  await button("start").click();
  const first = await until("the process to run", pid);
  check(await row.isVisible(), "start: a process of the lab runs");
  await until("the sheriff to have ended", async () => (await text(page, "#notices")).includes("carried out: start worker"));
  await button("restart").click();
  await until("another process in its place", async () => ![0, first].includes(await pid()));
  check(true, "restart: another process in its place");
  await until("the sheriff to have ended", async () => (await text(page, "#notices")).includes("carried out: restart worker"));
  await shot(page, "processes");
  await button("stop").click();
  await until("the process to end", async () => (await pid()) === 0 && (await button("start").isVisible()));
  check(true, "stop: it has ended");
  await stop(deputy);
}

async function cell(page, now) {
  const [x, y] = now.pose.t;
  const at = await page.evaluate(([a, b]) => window.fusionSlam.screenOf(a, b), [x, y]);
  const box = await page.locator("#canvas").boundingBox();
  // Beside the robot, where no loop's line is: the nearest free place.
  for (const [dx, dy] of [[14, 0], [-14, 0], [0, 14], [0, -14], [26, 10], [-26, -10]]) {
    await page.mouse.click(box.x + at[0] + dx, box.y + at[1] + dy);
    const seen = await until("an answer to the click", async () => (await page.locator("#card").isVisible()) || (await page.locator("#loops .chosen").count()) > 0);
    if (seen && (await page.locator("#card").isVisible())) break;
    await page.keyboard.press("Escape");
  }
  const card = await text(page, "#card");
  check(/Free|Occupied|Undecided|Unknown/.test(card), `a click on a cell is answered: ${card.split("\n")[0]}, ${card.replace(/\s+/g, " ").slice(0, 90)}`);
  await shot(page, "cell");
}

async function localise(page) {
  await page.locator("#canvas").focus();
  await page.keyboard.press("l");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("q");
  check(await page.locator(".toolbar").isVisible(), "the pose can be given by keyboard alone");
  await shot(page, "localise");
  await page.keyboard.press("Enter");
  await until("the pose to be sent", async () => (await text(page, "#notices")).includes("Told the localizer"));
}

async function recording(browser) {
  const viewer = view([join(work, "session.lcmlog")]);
  await ready();
  const page = await open(browser, URL, { colorScheme: "dark" }, faults);
  const end = await until("the end of the recording", async () => {
    const now = await stats(page);
    return now.player?.ready && now.session?.area_m2 > 2 && now.fusedTiles > 0 && now.nodes > 2 ? now : null;
  });
  check(end.player.duration_s > 15, `a recording opens at its end, ${end.player.duration_s.toFixed(1)} s`);
  await shot(page, "recording-dark");
  await seek(page, 3); // before the reset
  await until("the earlier moment", async () => {
    const now = await stats(page);
    return Math.abs(now.player.position_s - 3) < 0.2 && now.session?.area_m2 < 0.97 * end.session.area_m2;
  });
  check(true, "seeking back shows the smaller map of then");
  await page.locator("#canvas").focus();
  await page.keyboard.press("Space");
  await until("it to play", async () => (await stats(page)).player.position_s > 4);
  await page.keyboard.press("Space");
  await until("it to pause", async () => !(await stats(page)).player.playing);
  check(true, "Space plays and pauses");
  // It has paused wherever this machine got to, perhaps just after the reset, where there is no cloud yet.
  await seek(page, end.player.duration_s);
  await page.getByRole("radio", { name: "3D" }).click();
  await until("the cloud", async () => (await stats(page)).points > 1000);
  await shot(page, "space-dark");
  await page.getByRole("button", { name: "Reset" }).evaluate((button) => {
    window.confirm = () => true;
    button.click();
  });
  await until("the refusal", async () => (await text(page, "#notices")).includes("no robot to command"));
  check(true, "a recording can't be commanded, and says so");
  await page.context().close();
  await phone(browser);
  await many(browser);
  await stop(viewer);
}

const seek = (page, to_s) => page.locator("#timeline input").evaluate((slider, value) => {
  slider.value = String(value);
  slider.dispatchEvent(new Event("change"));
}, to_s);

async function phone(browser) {
  const page = await open(browser, URL, { viewport: { width: 390, height: 844 }, colorScheme: "light", hasTouch: true, isMobile: true }, faults);
  await until("the map", async () => (await stats(page)).fusedTiles > 0);
  for (const tab of ["Map", "Camera", "Health", "Loops"]) {
    await page.getByRole("navigation").getByRole("button", { name: tab }).click();
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    check(wide <= 0, `on a phone the tab ${tab} is no wider than the screen`);
    await shot(page, `phone-${tab.toLowerCase()}`);
  }
  const small = await page.evaluate(() => [...document.querySelectorAll("button, input, select")].filter((e) => e.offsetParent && !e.getAttribute("aria-label") && !e.closest("label") && !(e.innerText || e.title)).map((e) => e.outerHTML));
  check(small.length === 0, `every control has a name ${small.join(" ")}`);
  await page.context().close();
}

// Ten at once, one of them asleep: it takes nothing and holds nobody up.
async function many(browser) {
  const pages = [];
  for (let i = 0; i < 9; i++) pages.push(await open(browser, URL, { viewport: { width: 480, height: 360 } }, faults));
  const asleep = await open(browser, `${URL}licences.txt`, {}, faults);
  await asleep.evaluate((url) => {
    const socket = (window.asleep = new WebSocket(url));
    socket.onopen = () => socket.send(JSON.stringify({ type: "want", topics: ["cloud", "octomap", "fused", "pose", "keyframe", "nodes"] }));
  }, `ws://127.0.0.1:${PORT}/socket`);
  for (const page of pages) await until("each page to have the map", async () => (await stats(page)).fusedTiles > 0);
  const health = await (await fetch(`${URL}health`)).json();
  check(health.browsers.length === 10, "ten browsers at once");
  check(Math.max(...health.browsers.map((one) => one.batches_under_way)) <= 2, "no browser has more than two batches under way");
  for (const page of [...pages, asleep]) await page.context().close();
}

const browser = await launch(join(build, "web_modules"));
try {
  await live(browser);
  await recording(browser);
  check(faults.length === 0, `no error in the browser's console ${faults.join("; ")}`);
  console.log("page_test: all good");
} catch (error) {
  console.error(`FAILED: ${error.stack}\n${faults.join("\n")}`);
  process.exitCode = 1;
} finally {
  await browser.close();
}
process.exit();
