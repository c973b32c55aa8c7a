// What the page's tests share: programs that are started and surely ended, headless Chromium, waiting without fixed pauses.
import { spawn } from "node:child_process";
import { closeSync, mkdirSync, openSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

const FLAGS = [
  "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
  "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--disable-dev-shm-usage",
];
const running = new Set();
process.on("exit", () => running.forEach((child) => child.kill("SIGKILL")));

export function start(work, name, program, args, env = {}) {
  mkdirSync(work, { recursive: true });
  const log = openSync(join(work, `${name}.log`), "a");
  const child = spawn(program, args, { stdio: ["ignore", log, log], env: { ...process.env, ...env } });
  closeSync(log);
  child.title = name;
  child.ended = new Promise((resolve) => child.once("exit", (code, signal) => {
    running.delete(child);
    resolve(code ?? signal);
  }));
  child.once("error", (error) => console.error(`${name}: ${error.message}`));
  running.add(child);
  return child;
}

export async function stop(child, signal = "SIGTERM") {
  child.kill(signal);
  const timer = setTimeout(() => child.kill("SIGKILL"), 20_000);
  const result = await child.ended;
  clearTimeout(timer);
  return result;
}

export async function run(work, name, program, args) {
  const code = await start(work, name, program, args).ended;
  if (code !== 0) throw new Error(`${name} ended with ${code}:\n${readFileSync(join(work, `${name}.log`), "utf8").slice(-2000)}`);
}

// Asks until the answer is true (or anything like it), and gives it back. The time-out is for machines that are very busy.
export async function until(what, ask, timeoutMs = 300_000) {
  const deadline = Date.now() + timeoutMs;
  let last;
  for (;;) {
    try {
      last = await ask();
      if (last) return last;
    } catch (error) {
      last = error.message;
    }
    if (Date.now() > deadline) throw new Error(`waited ${timeoutMs / 1000} s for: ${what} (last: ${JSON.stringify(last)})`);
    await new Promise((resolve) => setTimeout(resolve, 250));
  }
}

export async function launch(modules) {
  const { chromium } = createRequire(resolve(modules, "package.json"))("playwright-core");
  return chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS });
}

// A page whose errors count as failures of the test.
export async function open(browser, url, options, faults) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, ...options });
  const page = await context.newPage();
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("console", (message) => {
    const text = message.text();
    // The browser's own words on a connection that was refused, which is part of the test; and on slow software drawing.
    if (message.type() === "error" && !/ERR_CONNECTION|WebSocket connection|ERR_EMPTY_RESPONSE|GPU stall/.test(text)) faults.push(text);
  });
  await page.goto(url);
  return page;
}

export const stats = (page) => page.evaluate(() => window.fusionSlam.stats());

export function check(holds, what) {
  if (!holds) throw new Error(`not so: ${what}`);
  console.log(`ok   ${what}`);
}
