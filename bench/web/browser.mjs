// The page in Chromium before an island of generated devices: prints lines of JSON (bench/README.md, "The page").
//   node bench/web/browser.mjs PROGRAM DEVICES SECONDS
// PROGRAM is rubicon-bench-web, whose islands are started on loopback: run it by `rubicon-bench-web --only browser`.
import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
const { chromium } = createRequire(join(root, "web/package.json"))("playwright-core");
const flags = ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking"];
const [program, devices, seconds] = [process.argv[2], Number(process.argv[3]), Number(process.argv[4])];
const rounds = 5;

const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
const rounded = (value, digits = 1) => Number(value.toFixed(digits));

function percentile(values, part) {
  const sorted = [...values].sort((a, b) => a - b);
  return rounded(sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))] ?? 0);
}

/** A process of PROGRAM that is an island with its page. */
async function startIsland(port = 0) {
  const island = spawn(program, ["--island", String(devices), String(port)], { stdio: ["pipe", "pipe", "inherit"] });
  const lines = createInterface({ input: island.stdout })[Symbol.asyncIterator]();
  const ready = await lines.next();
  if (ready.done) throw new Error("the island does not start");
  return {
    port: Number(ready.value.split(" ")[1]),
    async rate(updates) {
      island.stdin.write(`rate ${updates}\n`);
      await lines.next();
    },
    end(signal) {
      const ended = new Promise((done) => island.once("exit", done));
      island.kill(signal);
      return ended;
    },
  };
}

/** Opens the list of devices in a fresh context, as a first visit. */
async function openList(browser, island) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 } });
  const page = await context.newPage();
  page.setDefaultTimeout(120_000);
  await page.goto(`http://127.0.0.1:${island.port}/#/devices`);
  await page.waitForFunction(
    (count) => document.querySelector("[role=grid]")?.getAttribute("aria-rowcount") === String(count + 1),
    devices,
  );
  const listed = await page.evaluate(() => performance.now());
  await page.waitForFunction(() =>
    [...document.querySelectorAll("[role=grid] [role=row]")].slice(1).every((row) => /\d\.\d/.test(row.textContent)),
  );
  const valued = await page.evaluate(() => performance.now());
  const painted = await page.evaluate(() => performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? 0);
  return { context, page, listed, valued, painted };
}

async function opening(browser, island) {
  const runs = [];
  for (let i = 0; i < rounds; i++) {
    const { context, painted, listed, valued } = await openList(browser, island);
    runs.push({ painted, listed, valued });
    await context.close();
  }
  const of = (name) => runs.map((run) => run[name]);
  return {
    first_contentful_paint_ms: percentile(of("painted"), 0.5),
    listed_ms: percentile(of("listed"), 0.5),
    listed_worst_ms: percentile(of("listed"), 1),
    values_shown_ms: percentile(of("valued"), 0.5),
  };
}

/** Times between animation frames while the list is scrolled by some rows in each of them, or rests. */
function frameTimes(page, span, scroll) {
  return page.evaluate(
    ([span, scroll]) =>
      new Promise((done) => {
        const list = document.querySelector("[role=grid]");
        const times = [];
        const began = performance.now();
        let last = 0;
        let step = 37;
        let mostRows = 0;
        const frame = (now) => {
          if (last) times.push(now - last);
          last = now;
          if (scroll) {
            const before = list.scrollTop;
            list.scrollTop += step;
            if (list.scrollTop === before) step = -step;
          }
          mostRows = Math.max(mostRows, list.querySelectorAll("[role=row]").length);
          if (performance.now() - began < span) requestAnimationFrame(frame);
          else done({ times, mostRows });
        };
        requestAnimationFrame(frame);
      }),
    [span, scroll],
  );
}

/** The list filtered by a word that becomes longer and shorter again, as somebody types it. */
async function filtering(page) {
  const frames = frameTimes(page, 6000, false);
  for (const word of ["7", "77", "777", "7777", "777", "77", "7", ""]) {
    await page.evaluate((q) => (location.hash = q ? `#/devices?q=${q}` : "#/devices"), word);
    await sleep(600);
  }
  const { times } = await frames;
  return {
    frame_ms: { p50: percentile(times, 0.5), p95: percentile(times, 0.95), p99: percentile(times, 0.99), most: percentile(times, 1) },
  };
}

async function metricsOf(session) {
  const { metrics } = await session.send("Performance.getMetrics");
  return Object.fromEntries(metrics.map(({ name, value }) => [name, value]));
}

async function drawing(page, island, rate, scroll) {
  await island.rate(rate);
  await sleep(1000);
  const session = await page.context().newCDPSession(page);
  await session.send("Performance.enable");
  const before = await metricsOf(session);
  const { times, mostRows } = await frameTimes(page, seconds * 1000, scroll);
  const after = await metricsOf(session);
  const share = (name) => rounded(((after[name] - before[name]) / (after.Timestamp - before.Timestamp)) * 100);
  return {
    frames_per_second: rounded((times.length / times.reduce((sum, time) => sum + time, 0)) * 1000),
    frame_ms: { p50: percentile(times, 0.5), p95: percentile(times, 0.95), p99: percentile(times, 0.99) },
    busy_percent: share("TaskDuration"),
    processor_percent: share("ThreadTime"),
    script_percent: share("ScriptDuration"),
    layout_and_style_percent: rounded(share("LayoutDuration") + share("RecalcStyleDuration")),
    rows_in_document: mostRows,
    heap_mb: await heapOf(page),
  };
}

/** The heap of the page after a collection of garbage, in MB. */
async function heapOf(page) {
  const session = await page.context().newCDPSession(page);
  await session.send("HeapProfiler.collectGarbage");
  await session.send("Performance.enable");
  return rounded((await metricsOf(session)).JSHeapUsedSize / 1e6);
}

/** The island is killed, and started again at the same port. */
async function restart(page, island) {
  const isUp = () => document.querySelector(".line.tone-good") !== null;
  const died = Date.now();
  await island.end("SIGKILL");
  await page.waitForFunction(() => document.querySelector(".line.tone-good") === null);
  const noticed = Date.now() - died;
  const next = await startIsland(island.port);
  const ready = Date.now();
  await page.waitForFunction(isUp);
  return { island: next, figures: { noticed_ms: noticed, connected_ms: Date.now() - ready } };
}

/** Each finding is one line. */
const report = (finding) => console.log(JSON.stringify(finding));

async function measure(browser) {
  const island = await startIsland();
  report({ browser: `Chromium ${browser.version()}`, devices, points: devices * 5 });
  report({ opening: await opening(browser, island) });
  const { page } = await openList(browser, island);
  const renderer = await page.evaluate(() => {
    const gl = document.createElement("canvas").getContext("webgl");
    const names = gl?.getExtension("WEBGL_debug_renderer_info");
    return names ? gl.getParameter(names.UNMASKED_RENDERER_WEBGL) : "software, no WebGL";
  });
  report({ renderer, heap_mb_after_opening: await heapOf(page) });
  for (const rate of [1000, 10000]) {
    report({ [`scrolling_${rate}`]: await drawing(page, island, rate, true) });
    report({ [`resting_${rate}`]: await drawing(page, island, rate, false) });
  }
  report({ filtering_10000: await filtering(page) });
  await island.rate(0);
  report({ heap_mb_after_updates: await heapOf(page) });
  const restarted = await restart(page, island);
  report({ restart: restarted.figures });
  await restarted.island.end("SIGTERM");
}

const browser = await chromium.launch({ executablePath: "/usr/bin/chromium-headless-shell", args: flags });
try {
  await measure(browser);
} finally {
  await browser.close();
}
