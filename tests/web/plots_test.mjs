// Plots of an island with a history: what was and what arrives are one curve.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { publisher } from "./island.mjs";

/** No lamp of another test drives it. */
const temperature = "6541:proxy.dummy-rooms.bedroom.sensor.temperature-1";
const reading = (page) => page.locator(".plot-legend td.reading").first();
const settled = (page) => page.locator(".strip.loading").waitFor({ state: "detached" });

/** Lines with a value. */
async function rowsOfFile(page) {
  const coming = page.waitForEvent("download");
  await page.getByRole("button", { name: "CSV" }).click();
  const [, ...lines] = (await readFile(await (await coming).path(), "utf8")).trim().split("\n");
  return lines.filter((line) => !line.endsWith(",gap"));
}

/** Values of before the page was loaded come from the history, those of after it live, each once. */
async function joinsHistoryAndLive({ page, open }) {
  await open(`plots?k=${temperature}&span=900`);
  await page.locator(".plot canvas").first().waitFor();
  await page.keyboard.press("a");
  const seen = new Set();
  while (seen.size < 3) {
    const before = await reading(page).textContent();
    if (/ °C$/.test(before)) seen.add(before);
    await page.waitForFunction((text) => document.querySelector(".plot-legend td.reading").textContent !== text, before);
  }
  const answered = page.waitForResponse(/\/api\/v1\/history\?/);
  await page.reload();
  await answered;
  await page.locator(".plot canvas").first().waitFor();
  await settled(page);
  const past = (await rowsOfFile(page)).length;
  assert.ok(past >= 2, `${past} values of before; without history there is the last one`);
  await page.keyboard.press("a");
  await page.waitForFunction(() => / °C$/.test(document.querySelector(".plot-legend td.reading").textContent));
  const now = await reading(page).textContent();
  await page.waitForFunction((text) => document.querySelector(".plot-legend td.reading").textContent !== text, now);
  const rows = await rowsOfFile(page);
  assert.ok(rows.length > past, `${rows.length} rows after ${past}`);
  const times = rows.map((row) => Date.parse(row.split(",")[0]));
  assert.deepEqual(
    times,
    [...new Set(times)].sort((a, b) => a - b),
  );
  const plot = page.getByRole("slider", { name: /temperature-1/ });
  await plot.focus();
  await page.keyboard.press("End");
  for (let steps = 0; steps < 5; steps++) {
    if (/temperature-1 [\d.,]+ °C/.test(await plot.getAttribute("aria-valuetext"))) return;
    await page.keyboard.press("ArrowLeft");
  }
  assert.fail("no value of before at the crosshair");
}

/** What the history knows of a point that is gone stays a curve, and ends where it was known last. */
async function pointThatIsGone({ page, open, island }) {
  const path = `${publisher}:house.kitchen.oven.sensor.temperature-1`;
  island.publish("house.kitchen.oven.sensor.temperature-1.value", "212.5");
  await open("overview");
  const known = async (key) => {
    const now = Date.now() / 1000;
    const answer = await fetch(`/api/v1/history?key=${key}&from=${now - 600}&to=${now + 10}&buckets=1000`);
    return (await answer.json()).series?.[0]?.v?.length > 0;
  };
  while (!(await page.evaluate(known, `${path}.value`))) await page.waitForTimeout(300);
  await island.endOthers();
  await open(`tuples?q=kitchen.oven`);
  await page.waitForFunction(() => document.querySelectorAll(".leaf").length === 0 || document.querySelector(".leaf .tone-bad") !== null);
  const answered = page.waitForResponse(/\/api\/v1\/history\?/);
  await open(`plots?k=${path}`);
  await answered;
  await page.locator(".plot-legend .swatch path").waitFor({ state: "attached" });
  await settled(page);
  await page.locator(".plot-legend td.reading", { hasText: "no good value" }).waitFor();
  const rows = await rowsOfFile(page);
  assert.ok(
    rows.some((row) => row.endsWith(",212.5")),
    rows.join("\n"),
  );
}

export const tests = () => [
  { name: "plots: the history and what arrives are one curve", body: joinsHistoryAndLive },
  { name: "plots: a point that is gone", body: pointThatIsGone },
];
