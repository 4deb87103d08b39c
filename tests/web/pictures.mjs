// Makes the pictures of the page in docs/pictures: node pictures.mjs FOLDER-OF-PROGRAMS FOLDER-OF-PICTURES (tests/web/pictures runs it).
import { spawn } from "node:child_process";
import { copyFile, mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { openBrowser } from "./browser.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const [programs, pictures] = process.argv.slice(2);
const address = "127.0.0.1:8648";
const url = `http://${address}/`;
/** A folder with the page in place of the one in the program. */
const files = process.env.RUBICON_PAGE_FILES;
/** Milliseconds between two rows of the tables, and their spans before and after now. */
const row = 10_000;
const past = 2 * 3_600_000;
const future = 600_000;

const folder = await mkdtemp(join(tmpdir(), "rubicon-pictures-"));
const configuration = join(folder, "home.yaml");
await copyFile(join(here, "pictures.yaml"), configuration);
const pause = (time) => new Promise((done) => setTimeout(done, time));

/** The same numbers each time. */
let seed = 7;
function noise(size) {
  seed = (seed * 16807) % 2147483647;
  return (seed / 2147483647 - 0.5) * size;
}
const wave = (minute, low, high, period) => low + ((high - low) * (1 - Math.cos((minute / period) * 2 * Math.PI))) / 2;
const within = (minute, period, from, to) => minute % period >= from && minute % period < to;

/** What the sensors of the house measure, by the minutes of the table. */
const columns = {
  living_temperature: (t) => (wave(t, 20.8, 21.6, 46) + noise(0.06)).toFixed(2),
  living_humidity: (t) => (wave(t, 43, 46, 70) + noise(0.6)).toFixed(1),
  living_light: (t) => (wave(t, 180, 340, 110) + (within(t, 90, 20, 55) ? 160 : 0) + noise(12)).toFixed(0),
  living_motion: (t) => (within(t, 26, 5, 14) || within(t, 41, 30, 36) ? "on" : "off"),
  kitchen_temperature: (t) => (wave(t, 20.2, 21.4, 64) + noise(0.08)).toFixed(2),
  kitchen_humidity: (t) => (wave(t, 44, 58, 75) + noise(0.8)).toFixed(1),
  kitchen_co2: (t) => (520 + (t % 58) * 8.5 * (t % 58 < 50 ? 1 : 0.2) + noise(14)).toFixed(0),
  fridge_power: (t) => (within(t, 24, 0, 9) ? 82 + noise(5) : 2.1 + noise(0.2)).toFixed(1),
  fridge_door: (t) => (within(t, 47, 18, 19) ? "open" : "closed"),
  bedroom_temperature: (t) => (wave(t, 18.1, 18.9, 80) + noise(0.05)).toFixed(2),
  bedroom_humidity: (t) => (wave(t, 48, 52, 90) + noise(0.5)).toFixed(1),
  bedroom_window: () => "closed",
  bedroom_co2: (t) => (610 + wave(t, 0, 90, 85) + noise(8)).toFixed(0),
  window_battery: () => "11",
};

/** What was measured goes into the history first; the island of the pictures plays the rest at its own pace. */
async function writeTables() {
  const begin = Date.now() - past;
  const head = ["time", ...Object.keys(columns)].join();
  const rowAt = (at) => [new Date(begin + at).toISOString(), ...Object.values(columns).map((value) => value(at / 60_000))].join();
  for (const [name, from, to] of [
    ["past", 0, past],
    ["sensors", past, past + future],
  ]) {
    const rows = Array.from({ length: (to - from) / row }, (_, index) => rowAt(from + index * row));
    await writeFile(join(folder, `${name}.csv`), [head, ...rows, ""].join("\n"));
  }
}

async function answers() {
  try {
    return (await fetch(url)).ok;
  } catch {
    return false;
  }
}

async function startIsland(...sets) {
  const words = [
    "run",
    configuration,
    ...[`web={listen: "${address}"${files ? `, files: "${files}"` : ""}}`, ...sets].flatMap((set) => ["--set", set]),
  ];
  const island = spawn(join(programs, "rubicon-proxy"), words, { cwd: folder, stdio: "inherit" });
  while (!(await answers())) {
    if (island.exitCode !== null) throw new Error(`the island ended with ${island.exitCode}`);
    await pause(50);
  }
  return island;
}

async function stopIsland(island) {
  const ended = new Promise((done) => island.once("exit", done));
  island.kill("SIGTERM");
  await ended;
}

/** Plays what was before into the history. */
async function fillHistory() {
  const island = await startIsland("networks.log-sensors.file=past.csv", "networks.log-sensors.speed=2000");
  const lineOf = async () => {
    const answer = await fetch(`${url}api/v1/tuples/6541/proxy.log-sensors.status`, { headers: { accept: "text/plain" } });
    return answer.ok ? JSON.parse(await answer.text()).line : "";
  };
  while ((await lineOf()) !== "ended") await pause(200);
  await pause(1000); // the history writes what it has once a second
  await stopIsland(island);
}

async function put(key, value) {
  const answer = await fetch(`${url}api/v1/tuples/6541/${key}`, { method: "PUT", body: value });
  if (!answer.ok) throw new Error(`${key}: ${await answer.text()}`);
}

const overview = {
  rooms: ["Living room", "Kitchen", "Bedroom"],
  pins: ["log-sensors.living.sensor.temperature-1", "log-sensors.kitchen.sensor.co2-1", "log-sensors.meter.sensor.power-1"],
};

/** Of ETS, as an export has it. */
const groups = [
  ["Hall ceiling light", "1/0/1", "DPST-1-1"],
  ["Hall ceiling light status", "1/0/2", "DPST-1-1"],
  ["Stairs light", "1/0/3", "DPST-1-1"],
  ["Stairs light status", "1/0/4", "DPST-1-1"],
  ["Living room dimmer", "1/1/1", "DPST-5-1"],
  ["Living room dimmer status", "1/1/2", "DPST-5-1"],
  ["Terrace shutter position", "2/0/1", "DPST-5-1"],
  ["Terrace shutter up/down", "2/0/2", "DPST-1-8"],
  ["Bath temperature", "3/0/1", "DPST-9-1"],
  ["Bath setpoint", "3/0/2", "DPST-9-1"],
  ["Bath humidity", "3/0/3", "DPST-9-7"],
  ["Outside brightness", "4/0/1", "DPST-9-4"],
  ["Wind", "4/0/2", "DPT-9"],
  ["Front door contact", "5/0/1", "DPST-1-19"],
  ["Garage gate", "5/0/2", ""],
];
const csv = [
  '"Group name";"Address";"Central";"Unfiltered";"Description";"DatapointType";"Security"',
  ...groups.map(([name, group, dpt]) => `"${name}";"${group}";"";"";"";"${dpt}";"Auto"`),
].join("\n");

const shots = {
  async overview(page) {
    await page.goto(`${url}#/overview`);
    await page.locator(".pinned-plots .spark").nth(2).waitFor();
    await page.locator(".room", { hasText: "Bedroom" }).waitFor();
  },
  async room(page) {
    await page.goto(`${url}#/overview/Living%20room`);
    await page.locator(".room-devices").waitFor();
    await page.locator(".spark").nth(3).waitFor();
  },
  async commissioning(page) {
    await page.goto(`${url}#/networks/import`);
    await page.getByLabel("Project or export of ETS").setInputFiles({ name: "house.csv", mimeType: "text/csv", buffer: Buffer.from(csv) });
    await page.getByLabel("Its id").fill("knx-house");
    await page.getByLabel("Address of the KNX interface").fill("192.168.1.10");
    await page.getByRole("button", { name: "Show what it becomes" }).click();
    await page.locator(".row", { hasText: "Garage gate" }).waitFor();
  },
  phone: (page) => shots.room(page),
};

const desk = (height) => ({ viewport: { width: 1180, height } });
const sizes = {
  overview: desk(770),
  room: desk(640),
  commissioning: desk(740),
  phone: { viewport: { width: 390, height: 745 }, hasTouch: true, isMobile: true },
};

await writeTables();
await fillHistory();
const island = await startIsland();
let browser;
try {
  await put("proxy.overview", JSON.stringify(overview));
  browser = await openBrowser(join(here, "../.."), folder);
  for (const [name, take] of Object.entries(shots)) {
    const { page, context } = await browser.session({ url }, { context: sizes[name] });
    await take(page);
    await pause(1000); // values arrive
    await page.screenshot({ path: join(pictures, `${name}.png`) });
    await context.close();
  }
} finally {
  await browser?.close();
  await stopIsland(island);
  await rm(folder, { recursive: true, force: true });
}
