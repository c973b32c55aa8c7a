// Bundles the page into one folder: node build.mjs [OUT]. Runs on Node 18 and newer; no network.
import { build } from "esbuild";
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "dist");
mkdirSync(out, { recursive: true });
await build({
  entryPoints: [join(here, "src/main.ts")],
  outfile: join(out, "app.js"),
  bundle: true,
  minify: true,
  format: "esm",
  target: ["es2020"],
  legalComments: "none",
  absWorkingDir: here,
  logLevel: "warning",
});
for (const file of ["style.css", "icon.svg"]) copyFileSync(join(here, "src", file), join(out, file));
const licence = readFileSync(join(here, "node_modules/three/LICENSE"), "utf8");
writeFileSync(join(out, "licences.txt"), `app.js contains three.js:\n\n${licence}`);
copyFileSync(join(here, "src/index.html"), join(out, "index.html")); // last: with it the page is complete
