import assert from "node:assert/strict";
import { publisher } from "./island.mjs";

const note = `${publisher}:page.note`;

async function panelOf(page, key) {
  const panel = page.locator(".panel");
  await panel.getByRole("heading", { name: key }).waitFor();
  await panel.locator(".tuple-facts").waitFor();
  return panel;
}

async function fact(panel, name) {
  return panel.locator(`dt:text-is("${name}") + dd`).innerText();
}

/** A set with media type, user time and expiry arrives as it was given. */
async function setWithEverything({ page, open, island }) {
  island.publish("page.note", "carpe diem");
  await open(`tuples/${note}`);
  const panel = await panelOf(page, note);
  await panel.getByLabel("New value").fill('{"motto":"festina lente"}');
  await panel.getByLabel("Media type").fill("application/json");
  await panel.getByLabel("User time").fill("2026-01-02T03:04:05");
  await panel.getByRole("button", { name: "Set", exact: true }).click();
  await panel.getByText("The owner answered: applied.").waitFor();
  await panel.locator(".content", { hasText: '"motto": "festina lente"' }).waitFor();
  assert.equal(await fact(panel, "Media type"), "application/json");
  assert.match(await fact(panel, "User time"), /^2026-01-02 03:04:05/);
}

/** In bytes: of a text, and of one so long that the page loads it when asked. */
async function sizes({ page, open, island }) {
  island.publish("page.note", "21 °C");
  await open(`tuples/${note}`);
  const panel = await panelOf(page, note);
  assert.equal(await fact(panel, "Size"), "6 bytes");
  await panel.getByLabel("New value").fill("x".repeat(20_000));
  await panel.getByRole("button", { name: "Set", exact: true }).click();
  await panel.getByRole("button", { name: "Show the bytes" }).click();
  await panel.locator(".content", { hasText: /^x{20000}$/ }).waitFor();
  assert.equal(await fact(panel, "Size"), "20,000 bytes (19.5 KiB)");
}

/** `image/*` is shown as a picture. */
async function picture({ page, open, island }) {
  island.publish("page.note", "carpe diem");
  await open(`tuples/${note}`);
  const panel = await panelOf(page, note);
  const drawing = '<svg xmlns="http://www.w3.org/2000/svg" width="40" height="20"><rect width="40" height="20"/></svg>';
  await panel.getByLabel("New value").fill(drawing);
  await panel.getByLabel("Media type").fill("image/svg+xml");
  await panel.getByRole("button", { name: "Set", exact: true }).click();
  const image = panel.getByRole("img", { name: "The value as a picture" });
  await image.waitFor();
  await page.waitForFunction((element) => element.complete && element.naturalWidth === 40, await image.elementHandle());
}

/** The value of a field of date and time, in the zone of the browser; Chromium refuses one that ends with `:00`. */
const fieldTime = (page, seconds) =>
  page.evaluate((ahead) => {
    const time = new Date(Date.now() + ahead * 1000);
    if (time.getSeconds() === 0) time.setSeconds(1);
    return new Date(time.getTime() - time.getTimezoneOffset() * 60_000).toISOString().slice(0, 19);
  }, seconds);

/** A value that expires says when, and is gone then. */
async function setWithExpiry({ page, open, island }) {
  island.publish("page.note", "carpe diem");
  await open(`tuples/${note}`);
  const panel = await panelOf(page, note);
  assert.equal(await fact(panel, "Expires"), "never");
  await panel.getByLabel("New value").fill("for a moment");
  await panel.getByLabel("Expires at").fill(await fieldTime(page, 20));
  await panel.getByRole("button", { name: "Set", exact: true }).click();
  await panel.locator('dt:text-is("Expires") + dd', { hasText: /\(in \d+ s\)/ }).waitFor();
  await panel.locator(".content", { hasText: "for a moment" }).waitFor();
  await panel.getByText("There is no such tuple.").waitFor({ timeout: 40_000 });
}

async function append({ page, open, island }) {
  island.publish("page.note", "carpe diem");
  await open(`tuples/${note}`);
  const panel = await panelOf(page, note);
  await panel.getByLabel("New value").fill("one");
  await panel.getByLabel("Media type").fill("text/markdown");
  await panel.getByRole("button", { name: "Set", exact: true }).click();
  await panel.locator(".content", { hasText: /^one$/ }).waitFor();
  await panel.getByLabel("New value").fill(" two");
  await panel.getByLabel("Media type").fill("text/html");
  await panel.getByRole("button", { name: "Append" }).click();
  await panel.getByText(/expected its media type text\/markdown/).waitFor();
  await panel.getByLabel("Media type").fill("text/markdown");
  await panel.getByRole("button", { name: "Append" }).click();
  await panel.locator(".content", { hasText: /^one two$/ }).waitFor();
  assert.equal(await fact(panel, "Media type"), "text/markdown");
}

/** A set that counts only for the value that was seen is refused after another one. */
async function onlyIfUnchanged({ page, open, island }) {
  island.publish("page.note", "carpe diem");
  await open(`tuples/${note}`);
  const panel = await panelOf(page, note);
  await panel.getByLabel(/only if it is still/).check();
  await panel.getByLabel("New value").fill("first");
  await panel.getByRole("button", { name: "Set", exact: true }).click();
  await panel.getByText("The owner answered: applied.").waitFor();
  await panel.getByLabel("New value").fill("second");
  await panel.getByRole("button", { name: "Set", exact: true }).click();
  await panel.getByText("The owner answered: applied.").waitFor({ state: "detached" });
  await panel.locator(".content", { hasText: /^first$/ }).waitFor();
}

async function readOnlyIsRefused({ page, open }) {
  await open("tuples/6541:proxy.dummy-rooms.living.status");
  const panel = await panelOf(page, "6541:proxy.dummy-rooms.living.status");
  await panel.getByLabel("New value").fill("x");
  await panel.getByRole("button", { name: "Set", exact: true }).click();
  await panel.getByText(/refused/).waitFor();
}

/** What a program that ended has published stays, marked. */
async function ownerAbsent({ page, open, island }) {
  island.publish("page.note", "carpe diem");
  await open(`tuples/${note}`);
  const panel = await panelOf(page, note);
  assert.match(await fact(panel, "Owner"), /present$/);
  await island.endOthers();
  await panel.getByText(/owner absent since \d/).waitFor();
  await page.locator("[role=treeitem].absent", { hasText: "owner absent since" }).waitFor();
}

/** Before its owner has sent all, it is not known whether there is such a tuple. */
async function comingIsNotMissing({ page, open }) {
  await page.addInitScript(() => {
    window.seen = [];
    new MutationObserver(() => {
      const text = document.querySelector(".panel > p")?.textContent;
      if (text && window.seen.at(-1) !== text) window.seen.push(text);
    }).observe(document, {
      subtree: true,
      childList: true,
      characterData: true,
    });
  });
  await open("tuples/6541:house.motto");
  await panelOf(page, "6541:house.motto");
  assert.deepEqual(await page.evaluate(() => window.seen.filter((text) => text !== "Loading")), []);
  await open("tuples/6541:house.nosuch");
  await page.locator(".panel").getByText("There is no such tuple.").waitFor();
}

async function filteredToNothing({ page, open }) {
  await open("tuples?q=nosuchtuple");
  await page.getByText("No tuple matches.").waitFor();
  await page.getByRole("button", { name: "Clear filter" }).click();
  await page.locator("[role=tree]").waitFor();
}

export const tests = () => [
  {
    name: "tuples: set with media type and user time",
    body: setWithEverything,
  },
  { name: "tuples: set with expiry", body: setWithExpiry },
  { name: "tuples: the size of a value", body: sizes },
  { name: "tuples: a picture", body: picture },
  { name: "tuples: append, with media type", body: append },
  { name: "tuples: a set for the value that was seen", body: onlyIfUnchanged },
  { name: "tuples: a tuple that cannot be set says so", body: readOnlyIsRefused },
  { name: "tuples: an owner that is absent", body: ownerAbsent },
  {
    name: "tuples: one that is on its way is not missing",
    body: comingIsNotMissing,
  },
  { name: "tuples: filtered to nothing", body: filteredToNothing },
];
