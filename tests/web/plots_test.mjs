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

/** Columns of the drawing, from left to right, that have the colour of the curve: of the first and the last, and the longest run without. */
const columnsOf = (page) =>
  page.evaluate(() => {
    const canvas = document.querySelector(".plot canvas");
    const { width, height } = canvas;
    const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
    const [red, green, blue] = document
      .querySelector(".swatch path")
      .getAttribute("stroke")
      .match(/\w\w/g)
      .map((part) => Number.parseInt(part, 16));
    const has = (x) => {
      for (let at = 4 * x; at < data.length; at += 4 * width)
        if (data[at + 3] > 200 && Math.abs(data[at] - red) + Math.abs(data[at + 1] - green) + Math.abs(data[at + 2] - blue) < 60)
          return true;
      return false;
    };
    const drawn = Array.from({ length: width }, (_, x) => x).filter(has);
    const gaps = drawn.slice(1).map((x, index) => x - drawn[index]);
    return { width, drawn: drawn.length, gap: Math.max(...gaps) };
  });

/** While the quality was not good there is no curve, no value at the crosshair, and a gap in the file. */
async function gapsAreGaps({ page, open, island }) {
  await island.startTape();
  const path = "6543:proxy.log-tape.room.sensor.temperature-1";
  await open(`plots?k=${path}&span=20`);
  await page.locator(".plot-legend td.reading", { hasText: / °C$/ }).waitFor();
  await page.locator(".plot-legend td.reading", { hasText: "no good value" }).waitFor();
  await page.locator(".plot-legend td.reading", { hasText: / °C$/ }).waitFor();
  await page.waitForTimeout(2000); // the curve goes on
  const { width, drawn, gap } = await columnsOf(page);
  assert.ok(gap > width / 20 && drawn > width / 10, JSON.stringify({ width, drawn, gap }));
  const coming = page.waitForEvent("download");
  await page.getByRole("button", { name: "CSV" }).click();
  const lines = (await readFile(await (await coming).path(), "utf8")).trim().split("\n").slice(1);
  const place = lines.findIndex((line) => line.endsWith(",gap"));
  assert.ok(place > 0 && place < lines.length - 1, lines.join("\n"));
  const [before, at, after] = lines.slice(place - 1, place + 2).map((line) => Date.parse(line.split(",")[0]));
  assert.ok(before < at && after - at > 2000, lines.join("\n"));
  const plot = page.getByRole("slider", { name: /temperature-1/ });
  await plot.focus();
  await page.keyboard.press("End");
  const said = new Set();
  for (let steps = 0; steps < 80 && said.size < 3; steps++) {
    const word = (await plot.getAttribute("aria-valuetext")).includes("no good value") ? "gap" : "value";
    if ([...said].at(-1)?.startsWith(word) !== true) said.add(`${word} ${said.size}`);
    await page.keyboard.press("ArrowLeft");
    await page.evaluate(() => new Promise(requestAnimationFrame));
  }
  assert.deepEqual([...said], ["value 0", "gap 1", "value 2"]);
}

/** A history that cannot be written is named on the overview, and where its curves are; what other components say of one is not. */
async function historyThatFails({ page, open, island }) {
  const reason = "no space left on the disk";
  const own = await island.startUnwritten(reason);
  const other = `${publisher}:web.history.status`;
  island.publish("web.history.status", '{"state":"failing","reason":"as anybody may say"}');
  await open(`tuples/${other}`);
  await page.locator(".panel .content", { hasText: "as anybody may say" }).waitFor();
  const warning = page.getByText(`The history of attic is not written: ${reason}`);
  const warnings = page.getByText("is not written");
  await open("overview");
  await warning.waitFor();
  assert.equal(await warnings.count(), 1);
  await open(`plots?k=${temperature}`);
  await page.locator(".plot canvas").first().waitFor();
  assert.equal(await warnings.count(), 0);
  await page.goto(`${own}#/plots?k=${temperature}`);
  await warning.waitFor();
}

/** A point that does not exist is named, in place of an empty axis; beside one that does, it has no value. */
async function pointThatNeverWas({ page, open }) {
  await open("plots?k=6541:proxy.dummy-rooms.attic.sensor.light-9");
  await page.getByText("No such point: proxy.dummy-rooms.attic.sensor.light-9").waitFor();
  assert.equal(await page.locator(".plot canvas").count(), 0);
  await open(`plots?k=6541:proxy.dummy-rooms.attic.sensor.light-9,${temperature}`);
  await page.locator(".plot canvas").first().waitFor();
  await page.locator(".plot-legend tr", { hasText: "light-9" }).locator(".reading", { hasText: "no such point" }).waitFor();
  await page.getByRole("button", { name: "Remove Bedroom" }).click();
  await page.getByText(/^No such point/).waitFor();
}

export const tests = () => [
  { name: "plots: a point that never was", body: pointThatNeverWas },
  {
    name: "plots: the history and what arrives are one curve",
    body: joinsHistoryAndLive,
  },
  { name: "plots: gaps where the quality was not good", body: gapsAreGaps },
  { name: "plots: a point that is gone", body: pointThatIsGone },
  { name: "plots: a history that cannot be written", body: historyThatFails },
];
