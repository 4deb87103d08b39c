// Runs the tests of this folder against an island and a browser that it starts.
import { mkdir, mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { openBrowser } from "./browser.mjs";
import { Island } from "./island.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const root = join(here, "../..");
const files = [
  "rows",
  "keyboard",
  "accessible",
  "narrow",
  "sizes",
  "devices",
  "rooms",
  "commission",
  "zigbee",
  "commands",
  "tuples",
  "steering",
  "plots",
  "replay",
  "hostile",
  "lines",
  "leaving",
  "settings",
  "setup",
  "log",
  "islands",
  "example",
  "login",
  "hidden",
  "api_examples",
  "reconnect",
];

const words = process.argv.slice(2);
const long = words.includes("--long");
// `--part=1/2`: every second file, from the first on.
const [, part, parts] = words.find((word) => /^--part=/.test(word))?.match(/^--part=(\d+)\/(\d+)$/) ?? ["", "1", "1"];
const [programs, ...only] = words.filter((word) => !word.startsWith("--"));
const screens = join(root, parts === "1" ? "build/page-screens" : `build/page-screens-${part}`);
await rm(screens, { recursive: true, force: true });
await mkdir(screens, { recursive: true });
const folder = await mkdtemp(join(tmpdir(), "rubicon-page-"));
const island = new Island(programs, join(here, "island.yaml"), folder);
let passed = 0;
let failed = 0;

/** Runs one test in a context of its own; a picture shows where it failed. */
async function run(browser, name, settings, body) {
  if (only.length > 0 && !only.some((word) => name.includes(word))) return;
  const session = await browser.session(island, settings);
  try {
    await body({ ...session, island, browser });
    if (session.faults.length > 0) throw new Error(session.faults.join("\n"));
    passed++;
    console.log(`passed: ${name}`);
  } catch (error) {
    failed++;
    await session.page.screenshot({ path: join(screens, `failed-${name.replace(/\W+/g, "-")}.png`) }).catch(() => {});
    console.log(`FAILED: ${name}\n${error.stack}`);
  } finally {
    await session.context.close().catch(() => {});
    await island.endOthers();
  }
}

let browser;
try {
  await island.start();
  browser = await openBrowser(root, screens);
  for (const file of files.filter((_, at) => at % Number(parts) === Number(part) - 1)) {
    const { tests } = await import(`./${file}_test.mjs`);
    for (const test of tests(long)) {
      await run(browser, test.name, test.settings ?? {}, test.body);
      if (browser.runs()) continue;
      // The test that it ended in has failed. The others have a browser of their own.
      console.log("the browser ended; with DEBUG=pw:browser it says why");
      browser = await openBrowser(root, screens);
    }
  }
} catch (error) {
  failed++;
  console.log(`FAILED: ${error.stack}`);
} finally {
  await browser?.close();
  await island.stop();
  await rm(folder, { recursive: true, force: true });
}
console.log(`${passed} passed, ${failed} failed`);
process.exitCode = failed > 0 ? 1 : 0;
