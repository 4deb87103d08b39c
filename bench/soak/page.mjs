// The list of devices of a large island in Chromium; prints one line of JSON: node bench/soak/page.mjs URL DEVICES TEXT
// TEXT is typed into the filter, one letter each 200 ms. Frames are counted by requestAnimationFrame.
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
const { chromium } = createRequire(join(root, "web/package.json"))("playwright-core");
const flags = ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking"];
const [url, devices, text] = [process.argv[2], Number(process.argv[3]), process.argv[4]];
const patience = 300_000;

const rounded = (value) => Number(value.toFixed(1));

function framesOf(times) {
  const sorted = [...times].sort((a, b) => a - b);
  const at = (part) => rounded(sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))] ?? 0);
  return { frames: times.length, median_ms: at(0.5), p95_ms: at(0.95), longest_ms: at(1) };
}

/** Counts frames until the function that it returns is called. */
async function countFrames(page) {
  await page.evaluate(() => {
    const times = (globalThis.frameTimes = []);
    let last = 0;
    globalThis.countsFrames = true;
    const frame = (now) => {
      if (last) times.push(now - last);
      last = now;
      if (globalThis.countsFrames) requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  });
  return async () =>
    framesOf(
      await page.evaluate(() => {
        globalThis.countsFrames = false;
        return globalThis.frameTimes;
      }),
    );
}

const rowsAre = (page, count) =>
  page.waitForFunction((wanted) => document.querySelector("[role=grid]")?.getAttribute("aria-rowcount") === String(wanted + 1), count, {
    timeout: patience,
  });

async function opened(browser) {
  const page = await (await browser.newContext({ viewport: { width: 1280, height: 800 } })).newPage();
  page.setDefaultTimeout(patience);
  await page.goto(`${url}/#/devices`);
  await rowsAre(page, devices);
  const listed = await page.evaluate(() => performance.now());
  await page.waitForFunction(() => [...document.querySelectorAll("[role=grid] [role=row]")].slice(1).every((row) => /\d\.\d/.test(row.textContent)));
  return { page, listed_s: rounded(listed / 1000), values_s: rounded((await page.evaluate(() => performance.now())) / 1000) };
}

/** Scrolls by a row in each frame, and by a tenth of the list in each twentieth. */
async function scrolled(page, seconds) {
  const end = await countFrames(page);
  const rows = await page.evaluate(
    (span) =>
      new Promise((done) => {
        const list = document.querySelector("[role=grid]");
        const began = performance.now();
        let most = 0;
        let count = 0;
        const frame = () => {
          list.scrollTop += ++count % 20 ? 37 : list.scrollHeight / 10;
          if (list.scrollTop + list.clientHeight >= list.scrollHeight - 1) list.scrollTop = 0;
          most = Math.max(most, list.querySelectorAll("[role=row]").length);
          if (performance.now() - began < span) requestAnimationFrame(frame);
          else done(most);
        };
        requestAnimationFrame(frame);
      }),
    seconds * 1000,
  );
  return { ...(await end()), rows_in_document: rows };
}

async function filtered(page) {
  const end = await countFrames(page);
  await page.getByRole("searchbox").first().pressSequentially(text, { delay: 200 });
  const typed = Date.now();
  await page.waitForFunction(
    (all) => Number(document.querySelector("[role=grid]")?.getAttribute("aria-rowcount") ?? 0) < all,
    devices,
    { timeout: patience },
  );
  const took = Date.now() - typed;
  await page.waitForTimeout(1000);
  const shown = Number(await page.locator("[role=grid]").getAttribute("aria-rowcount")) - 1;
  return { ...(await end()), shown, after_last_letter_ms: took };
}

async function heapOf(page) {
  const session = await page.context().newCDPSession(page);
  await session.send("HeapProfiler.collectGarbage");
  await session.send("Performance.enable");
  const { metrics } = await session.send("Performance.getMetrics");
  return rounded(metrics.find(({ name }) => name === "JSHeapUsedSize").value / 1e6);
}

const browser = await chromium.launch({ executablePath: "/usr/bin/chromium-headless-shell", args: flags });
try {
  const { page, ...opening } = await opened(browser);
  const resting = await countFrames(page);
  await page.waitForTimeout(3000);
  const figures = { ...opening, heap_mb: await heapOf(page), resting: await resting(), scrolling: await scrolled(page, 10), filtering: await filtered(page) };
  console.log(JSON.stringify(figures));
} finally {
  await browser.close();
}
