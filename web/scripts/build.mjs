// Builds web/dist: the script of the page, that of its plots, one style sheet, one page, the licences of what they
// contain. The names of scripts and style sheet carry their hash, so that browsers may keep them for ever.
//   node scripts/build.mjs [--watch] [--out FOLDER]
import { createHash } from "node:crypto";
import { mkdir, readFile, readdir, rm, writeFile } from "node:fs/promises";
import { basename, dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import * as esbuild from "esbuild";
import { plotsTrimmed, smaller } from "./smaller.mjs";

const web = join(dirname(fileURLToPath(import.meta.url)), "..");
const outAt = process.argv.indexOf("--out");
const out = outAt > 0 ? process.argv[outAt + 1] : join(web, "dist");

const watching = process.argv.includes("--watch");

const common = {
  absWorkingDir: web,
  outdir: out,
  bundle: true,
  minify: true,
  charset: "utf8",
  format: "esm",
  target: ["chrome123", "firefox121", "safari17.5"],
  legalComments: "none",
  metafile: true,
  write: false,
  logLevel: "warning",
};

/** `page.js` with its hash: page-0123456789ab.js */
function hashed(path, contents) {
  const hash = createHash("sha256").update(contents).digest("hex").slice(0, 12);
  return path.replace(/\.(js|css)$/, `-${hash}.$1`);
}

/** The library of plots is a file of its own, which the page fetches when it shows the first plot. */
const plots = await esbuild.build({
  ...common,
  stdin: { contents: 'export { default } from "uplot";', resolveDir: web, sourcefile: "uplot.js" },
  plugins: [plotsTrimmed],
});
const plotsScript = await smaller(plots.outputFiles[0].text);
const plotsFile = { path: hashed(join(out, "uplot.js"), plotsScript), contents: plotsScript };
const plotsApart = {
  name: "plots apart",
  setup: (build) => build.onResolve({ filter: /^uplot$/ }, () => ({ path: `./${basename(plotsFile.path)}`, external: true })),
};

const options = {
  ...common,
  entryPoints: { page: "src/main.tsx" },
  // Elements as calls of h(): shorter than those that tsc checks (react-jsx).
  tsconfigRaw: { compilerOptions: { jsx: "react", jsxFactory: "h", jsxFragmentFactory: "Fragment" } },
  inject: ["scripts/elements.js"],
  plugins: [plotsApart],
};

/** Packages whose files are in the bundle, by the bundler's own list. */
function packagesOf(metafile) {
  const names = [metafile, plots.metafile]
    .flatMap(({ inputs }) => Object.keys(inputs))
    .map((path) => /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(path)?.[1]);
  return [...new Set(names.filter(Boolean))].sort();
}

async function licences(metafile) {
  const parts = ["The page of Rubicon contains the following software.\n"];
  for (const name of packagesOf(metafile)) {
    const folder = join(web, "node_modules", name);
    const about = JSON.parse(await readFile(join(folder, "package.json"), "utf8"));
    const file = (await readdir(folder)).find((entry) => /^licen[cs]e/i.test(entry));
    if (!file) throw new Error(`${name} has no licence file`);
    const text = (await readFile(join(folder, file), "utf8")).replaceAll("\r\n", "\n").trim();
    parts.push(`${"-".repeat(80)}\n${name} ${about.version} (${about.license})\n\n${text}\n`);
  }
  return parts.join("\n");
}

async function write(result) {
  await rm(out, { recursive: true, force: true });
  await mkdir(out, { recursive: true });
  let page = await readFile(join(web, "src/index.html"), "utf8");
  for (const file of result.outputFiles) {
    const contents = watching || !file.path.endsWith(".js") ? file.contents : await smaller(file.text);
    const path = hashed(file.path, contents);
    await writeFile(path, contents);
    page = page.replace(file.path.endsWith(".js") ? "page.js" : "page.css", path.slice(out.length + 1));
  }
  await writeFile(plotsFile.path, plotsFile.contents);
  await writeFile(join(out, "index.html"), page);
  await writeFile(join(out, "licences.txt"), await licences(result.metafile));
}

const writer = { name: "write", setup: (build) => build.onEnd((result) => (result.errors.length === 0 ? write(result) : undefined)) };

if (watching) {
  const context = await esbuild.context({ ...options, plugins: [plotsApart, writer] });
  await context.watch();
} else {
  await write(await esbuild.build(options));
}
