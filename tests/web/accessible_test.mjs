import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { settled, viewsOf } from "./browser.mjs";

const more = [
  "devices/6541/dummy-rooms/remote",
  "devices/6541/dummy-rooms/living",
  "devices/compare?d=6541/dummy-rooms/living,6541/dummy-rooms/bedroom",
  "tuples/6541:proxy.dummy-rooms.living.status",
  "tuples?q=living",
  "overview/network%206541%2Fdummy-rooms",
];
const standards = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

/** What axe finds on the page as it is; empty if nothing. */
export async function findingsOf(page, axe) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate((values) => globalThis.axe.run(document, { runOnly: { type: "tag", values } }), standards);
  return violations.map(
    ({ id, nodes }) =>
      `${id}: ${nodes
        .map(({ html, failureSummary }) => `${html.slice(0, 160)} (${failureSummary.split("\n").slice(1).join(" ").trim()})`)
        .slice(0, 3)
        .join("; ")}`,
  );
}

const noFindings =
  (theme, size) =>
  async ({ page, open, browser, picture }) => {
    const axe = await readFile(browser.axe, "utf8");
    await open("overview");
    const views = (await viewsOf(page)).map(({ id }) => id);
    const found = [];
    for (const address of [...views, ...more]) {
      await open(address);
      await settled(page);
      await page.waitForTimeout(300); // for the picture: values arrive
      await picture(`${theme}-${size}-${address.replace(/\W+/g, "-")}`);
      for (const finding of await findingsOf(page, axe)) found.push(`${address}: ${finding}`);
    }
    await page.keyboard.press("?");
    for (const finding of await findingsOf(page, axe)) found.push(`the list of keys: ${finding}`);
    await page.keyboard.press("Escape");
    await page.keyboard.press("/");
    await page.keyboard.type("liv");
    for (const finding of await findingsOf(page, axe)) found.push(`the search: ${finding}`);
    assert.deepEqual(found, []);
  };

/** Values are not current while the line is lost, but readable. */
async function lostAndReadable({ page, open, browser, island, picture }) {
  const axe = await readFile(browser.axe, "utf8");
  const found = [];
  for (const address of ["overview", "devices", "devices/6541/dummy-rooms/living", "tuples?q=living"]) {
    await open(address);
    await settled(page);
    await page.waitForTimeout(300); // values arrive
    await island.kill();
    try {
      await page.locator(".shell.line-lost").waitFor();
      await picture(`lost-${address.replace(/\W+/g, "-")}`);
      for (const finding of await findingsOf(page, axe)) found.push(`${address}: ${finding}`);
    } finally {
      await island.start();
    }
  }
  assert.deepEqual(found, []);
}

const sizes = {
  desk: { viewport: { width: 1280, height: 800 } },
  phone: { viewport: { width: 360, height: 740 }, hasTouch: true, isMobile: true },
  wall: { viewport: { width: 3840, height: 2160 } },
};

const lost = (long) =>
  (long ? ["light", "dark"] : ["light"]).map((theme) => ({
    name: `accessible: axe finds nothing while the connection is lost, ${theme}`,
    settings: { axe: true, lines: true, context: { colorScheme: theme } },
    body: lostAndReadable,
  }));

export const tests = (long) => [...views(long), ...lost(long)];

const views = (long) =>
  (long ? Object.keys(sizes) : ["desk"]).flatMap((size) =>
    (long ? ["light", "dark"] : ["light"]).map((theme) => ({
      name: `accessible: axe finds nothing in any view, ${theme}, ${size}`,
      settings: { axe: true, context: { ...sizes[size], colorScheme: theme } },
      body: noFindings(theme, size),
    })),
  );
