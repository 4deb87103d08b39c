// Views that steer the island: settings, inbox, recordings; and those that watch it: networks, plots, log, traffic.
import assert from "node:assert/strict";
import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { tabTo } from "./browser.mjs";

const notice = (page, text) => page.locator(".notice", { hasText: text }).waitFor();

/** Writes the configuration file of the island, reads it again by the page, and puts it back at the end. */
async function withConfiguration({ page, open, island }, change, body) {
  const path = join(island.folder, "island.yaml");
  const before = await readFile(path, "utf8");
  const reload = async () => {
    await open("settings");
    await page.locator(".configuration").waitFor();
    await page.getByRole("button", { name: "Reload …" }).click();
  };
  const confirm = async () => {
    await page.getByRole("button", { name: "Reload now" }).click();
    await notice(page, "Reloaded");
  };
  await writeFile(path, change(before));
  try {
    await reload();
    await body({ confirm });
  } finally {
    await writeFile(path, before);
    await reload();
    await page
      .locator("dialog, .notice", {
        hasText: /A reload makes|equals what is in force/,
      })
      .first()
      .waitFor();
    if ((await page.locator("dialog").count()) > 0) await confirm();
  }
}

const more = `
recorders: {all: {file: test.rec, patterns: ["proxy.**"]}}
`;
const rule = "rules: [{network: dummy-new, new-devices: ask}, ";
const newNetwork = `networks:
  dummy-new:
    type: dummy
    simulate: {shed: {name: Shed, actuators: {switch-1: {behaviour: obey}}}, well: {name: Well, sensors: {level-1: {}}}, gate: {name: Gate, sensors: {contact-1: {}}}}
`;

/** A reload brings devices that wait and a recorder; the page shows first what it would change. */
async function reloadInboxRecorder(session) {
  const { page, open } = session;
  await withConfiguration(
    session,
    (text) => text.replace("rules: [", rule).replace("networks:\n", newNetwork) + more,
    async ({ confirm }) => {
      await page.locator("dialog li", { hasText: "dummy-new" }).first().waitFor();
      await confirm();
      await decides(page, open);
      await records(page, open);
    },
  );
}

async function decides(page, open) {
  await open("inbox?q=dummy-new");
  await page.locator(".row", { hasText: "Gate" }).waitFor();
  assert.equal(await page.locator(".list-rows .row").count(), 3);
  await page.keyboard.press("e");
  await page.locator(".pending", { hasText: "ignored in" }).waitFor();
  await page.keyboard.press("u");
  await page.locator(".pending").waitFor({ state: "detached" });
  await page.getByRole("button", { name: "Approve dummy-new.gate" }).click();
  await page.locator("button:focus", { hasText: "Undo" }).press("Enter");
  await page.locator("button:focus", { hasText: "Approve" }).waitFor();
  assert.equal(await page.locator(".list-rows .row").count(), 3, "taken back before it was sent");
  // The filter of the list is none of the pattern: it goes to the whole inbox.
  await page.getByRole("searchbox").fill("gate");
  await page.locator(".row", { hasText: "Well" }).waitFor({ state: "detached" });
  await page.getByRole("textbox", { name: "By pattern" }).fill("dummy-new.*");
  await page.locator(".pattern").getByRole("button", { name: "Approve 3" }).waitFor();
  await page.getByRole("textbox", { name: "By pattern" }).fill("dummy-new.?e*");
  await page.locator(".pattern").getByRole("button", { name: "Approve 1" }).waitFor();
  await page.getByRole("searchbox").fill("dummy-new");
  await page.locator(".pattern").getByRole("button", { name: "Approve 1" }).click();
  await page.locator(".row", { hasText: "Well" }).waitFor({ state: "detached" });
  assert.equal(await page.locator(".list-rows .row").count(), 2);
  await open("devices?network=dummy-new");
  await page.locator(".row", { hasText: "Well" }).waitFor();
}

async function records(page, open) {
  await open("recordings");
  const card = page.getByRole("region", { name: "Recorder all" });
  await card.locator(".state", { hasText: "recording" }).waitFor();
  await tabTo(page, "Text of a mark in all");
  await page.keyboard.type("lamp replaced");
  await tabTo(page, "Mark");
  await page.keyboard.press("Enter");
  await card.locator("p", { hasText: "mark lamp replaced" }).locator(".state", { hasText: "confirmed" }).waitFor();
  await card.getByRole("button", { name: "Stop all" }).press("Enter");
  await card.locator("header .state", { hasText: "stopped" }).waitFor();
}

async function aNetworkByKeys({ page, open }) {
  await open("networks");
  await page.locator(".row", { hasText: "dummy-rooms" }).waitFor();
  await page.keyboard.press("Enter");
  const panel = page.getByRole("complementary", { name: "dummy-rooms" });
  await panel.locator(".counters").first().waitFor();
  assert.match(await panel.textContent(), /Attempts/);
  await page.keyboard.press("Escape");
  await panel.waitFor({ state: "detached" });
}

/** A point is chosen, crossed, zoomed and left, all by keys. */
async function aPlotByKeys({ page, open }) {
  await open("plots");
  await page.getByRole("button", { name: "Choose points" }).press("Enter");
  const field = page.locator("dialog input[type=search]");
  await field.fill("living light");
  const box = page.getByRole("checkbox", { name: /light-1/ });
  await box.press(" ");
  await page.keyboard.press("Escape");
  await page.locator(".plot canvas").first().waitFor();
  await page.keyboard.press("a");
  const plot = page.getByRole("slider", { name: /light-1/ });
  await page.locator(".plot-legend td.reading", { hasText: /^[\d.,]+ lx$/ }).waitFor();
  assert.equal(await plot.getAttribute("aria-valuetext"), "no crosshair");
  await plot.focus();
  await page.keyboard.press("End");
  await page.waitForFunction(() => /light-1 [\d.,]+ lx/.test(document.querySelector(".plot").getAttribute("aria-valuetext")));
  const end = Number(await plot.getAttribute("aria-valuenow"));
  await page.keyboard.press("Shift+ArrowLeft");
  await page.waitForFunction((time) => Number(document.querySelector(".plot").getAttribute("aria-valuenow")) < time - 100, end);
  const before = page.url();
  await page.keyboard.press("+");
  await page.waitForFunction(() => location.hash.includes("from="));
  await page.keyboard.press("0");
  await page.waitForFunction((url) => location.href === url, before);
}

async function theLog({ page, open }) {
  await open("log");
  await page.locator(".row", { hasText: "is up" }).first().waitFor();
  await page.getByRole("searchbox").fill("no such line");
  await page.getByText("No line matches.").waitFor();
  await page.getByRole("button", { name: "Clear filter" }).click();
  const line = page.locator(".list-rows .row").first();
  await line.click();
  await page.getByRole("complementary", { name: "The whole line" }).waitFor();
}

export const tests = () => [
  {
    name: "steering: a reload with preview, the inbox, a recorder",
    body: reloadInboxRecorder,
  },
  { name: "steering: a network by keys", body: aNetworkByKeys },
  { name: "steering: a plot by keys", body: aPlotByKeys },
  { name: "steering: the log", body: theLog },
];
