import assert from "node:assert/strict";
import { tabTo, viewsOf } from "./browser.mjs";

/** Without a pause between them, however long the page takes for each. */
async function press(page, keys) {
  await Promise.all(keys.split(" ").map((key) => page.keyboard.press(key)));
}

/** The list behind `?` names a way to every view of the rail, and it works. */
async function everyViewIsReached({ page, open }) {
  await open("overview");
  const views = await viewsOf(page);
  assert.ok(views.length >= 3);
  await press(page, "?");
  const listed = await page
    .locator(".shortcuts div")
    .evaluateAll((rows) =>
      rows.map((row) => [[...row.querySelectorAll("kbd")].map((key) => key.textContent).join(" "), row.querySelector("dd").textContent]),
    );
  await press(page, "Escape");
  await page.locator("dialog").waitFor({ state: "detached" });
  for (const { id, title } of views) {
    const keys = listed.find(([, what]) => what === `go to ${title}`)?.[0];
    assert.ok(keys, `no keys for ${title}`);
    await press(page, keys);
    await page.locator(`nav.rail a[aria-current=page][href^="#/${id}"]`).waitFor({ state: "attached" });
    assert.match(await page.title(), new RegExp(`^${title}`));
  }
}

/** Down the list, into a device, to its control, set it, and back. */
async function aCommandByKeys({ page, open }) {
  await open("overview");
  await press(page, "g d");
  await page.locator(".row", { hasText: "Hot water tank" }).waitFor();
  const index = async () => page.locator(".row.active").getAttribute("aria-rowindex");
  const before = Number(await index());
  await press(page, "j j k");
  assert.equal(Number(await index()), before + 1);
  await press(page, "/");
  await page.keyboard.type("living");
  await page.locator("[role=option]", { hasText: "Living room" }).waitFor();
  await press(page, "Enter");
  await page.getByRole("heading", { name: "Living room" }).waitFor();
  await page.locator(".control").first().waitFor();
  await press(page, "c");
  await page.waitForFunction(() => document.activeElement?.closest(".control"));
  await press(page, "Escape");
  await press(page, "Escape");
  await page.waitForFunction(() => location.hash.startsWith("#/devices") && !location.hash.includes("living"));
}

/** Not the first control of the page: Enter would then set another actuator. */
async function theControlOfTheRow({ page, open }) {
  await open("devices/6541/dummy-rooms/living");
  await page.locator(".row", { hasText: "rate" }).locator(".control").waitFor();
  const active = page.locator(".row.active");
  for (let step = 0; step < 12 && !/^rate/.test(await active.innerText()); step++) await press(page, "j");
  await press(page, "c");
  await page.waitForFunction(() => /^rate/.test(document.activeElement?.closest(".row")?.innerText ?? ""));
}

async function pinByKey({ page, open }) {
  await open("devices?q=Bedroom");
  await page.locator(".row", { hasText: "Bedroom" }).waitFor();
  await page.keyboard.press("Space");
  await page.locator(".row.group", { hasText: "Pinned" }).waitFor();
}

/** The row goes to the top, and stays the one that keys act on. */
async function theActiveRowStays({ page, open }) {
  await open("devices");
  const remote = page.locator(".row", { hasText: "Remote control" });
  await remote.waitFor();
  const active = page.locator(".row.active");
  for (let step = 0; step < 12 && !/Remote control/.test(await active.innerText()); step++) await press(page, "j");
  await page.keyboard.press("Space");
  await page.locator(".row.group", { hasText: "Pinned" }).waitFor();
  await page.locator(".row.active", { hasText: "Remote control" }).waitFor();
  await page.keyboard.press("Space");
  await page.locator(".row.group", { hasText: "Pinned" }).waitFor({ state: "detached" });
  await page.locator(".row.active", { hasText: "Remote control" }).waitFor();
}

async function wakingByKey({ page, open }) {
  await open("devices/6541/dummy-rooms/living");
  await page.locator(".row", { hasText: "light-1" }).waitFor();
  await press(page, "a");
  await page.locator('.active-switch[aria-checked="true"]', { hasText: "waking 1 sensor" }).waitFor();
  await page.locator(".row", { hasText: "light-1" }).locator(".quality-good").waitFor();
  await press(page, "a");
  await page.locator('.active-switch[aria-checked="false"]').waitFor();
}

/** The tree by arrows: into a branch and out of it. */
async function treeByArrows({ page, open }) {
  const rows = (level) => page.locator(`[role=treeitem][aria-level='${level}']`);
  const activeAt = (level, state = "") => page.locator(`[role=treeitem].active[aria-level='${level}']${state}`).waitFor();
  await open("tuples");
  // The first child is then a closed branch: all of the owner has arrived.
  await rows(2).filter({ hasText: "house" }).waitFor();
  await press(page, "Home ArrowLeft");
  await activeAt(1, "[aria-expanded=false]");
  await rows(2).first().waitFor({ state: "detached" });
  await press(page, "ArrowRight");
  await rows(2).filter({ hasText: "house" }).waitFor();
  await press(page, "ArrowRight");
  await activeAt(2, ":not([aria-expanded=true])");
  await press(page, "ArrowLeft");
  await activeAt(1);
}

/** A row of the tree that keys or an address choose is in sight. */
async function treeRowsAreInSight({ page, open }) {
  const inSight = (text) =>
    page.waitForFunction((wanted) => {
      const row = document.querySelector("[role=treeitem].active");
      const list = document.querySelector("[role=tree]");
      if (!row || row.querySelector(".part").textContent !== wanted) return false;
      const [box, around] = [row.getBoundingClientRect(), list.getBoundingClientRect()];
      return list.getAttribute("aria-activedescendant") === row.id && box.top >= around.top && box.bottom <= around.bottom;
    }, text);
  await open("tuples/6541:proxy.dummy-rooms.tank");
  await page
    .locator("[role=treeitem][aria-selected=true][aria-expanded=true]", {
      hasText: "tank",
    })
    .waitFor();
  await inSight("tank");
  await page.locator("[role=tree]").focus();
  await press(page, "ArrowRight ArrowLeft");
  await inSight("tank");
  await press(page, "ArrowLeft ArrowLeft"); // closes it, then to what is around it
  await inSight("dummy-rooms");
  await open("tuples/6541:proxy.wsn-hall.status");
  await inSight("status");
}

/** The work of log, settings and tuples; other views have tests of their own by keys. */
async function workByKeys({ page, open }) {
  await open("overview");
  await press(page, "g l");
  await page.locator(".list-rows .row").first().waitFor();
  await press(page, "f");
  await page.locator('button[aria-pressed="true"]', { hasText: "Go on" }).waitFor();
  await press(page, "f Home Enter");
  await page.getByRole("complementary", { name: "The whole line" }).waitFor();
  await press(page, "g s");
  await page.locator(".configuration").waitFor();
  await tabTo(page, "Check the file");
  await press(page, "Enter");
  await page.locator(".notice", { hasText: "equals what is in force" }).waitFor();
  await press(page, "g t");
  await tabTo(page, "Key or value");
  await page.keyboard.type("house.motto");
  await page.locator("[role=option]", { hasText: "6541:house.motto" }).waitFor();
  await press(page, "Escape Enter");
  await page.locator(".panel .tuple-form").waitFor();
  await tabTo(page, "New value");
  await page.keyboard.type("semper idem");
  await tabTo(page, "Set");
  await press(page, "Enter");
  await page.locator(".panel").getByText("The owner answered: applied.").waitFor();
  await page.locator(".panel .content", { hasText: "semper idem" }).waitFor();
}

/** Tab reaches each control of the frame of the page, and shows where it is. */
async function tabShowsTheFocus({ page, open }) {
  await open("overview");
  const seen = new Set();
  for (let step = 0; step < 40; step++) {
    await page.keyboard.press("Tab");
    const at = await page.evaluate(() => {
      const element = document.activeElement;
      const style = getComputedStyle(element);
      return {
        name: element.getAttribute("aria-label") || element.textContent.trim(),
        outline: style.outlineStyle !== "none" && Number.parseFloat(style.outlineWidth) > 0,
        body: element === document.body,
      };
    });
    if (at.body) continue;
    assert.ok(at.outline, `no outline at ${at.name}`);
    seen.add(at.name);
  }
  for (const name of ["Island", "Keyboard", "Overview", "Devices", "Tuples"])
    assert.ok(
      [...seen].some((text) => text.startsWith(name)),
      `${name} is not reached: ${[...seen].join(", ")}`,
    );
}

/** The way back leads to the list as it was: filtered, grouped, in its order, with what was chosen. */
async function backToTheList({ page, open }) {
  const at = (hash) => page.waitForFunction((wanted) => location.hash === wanted, hash);
  await open("devices?q=room&group=network&sort=-name");
  const living = page.locator(".row", { hasText: "Living room" });
  await living.waitFor();
  await living.getByRole("checkbox").check();
  await page.locator(".row", { hasText: "Bedroom" }).getByRole("checkbox").check();
  await living.getByText("Living room").click();
  await page.getByRole("heading", { name: "Living room" }).waitFor();
  await press(page, "Escape");
  await at("#/devices?q=room&group=network&sort=-name");
  assert.equal(await page.getByRole("checkbox", { checked: true }).count(), 2);
  await open("devices?q=room");
  await open("tuples?q=motto");
  await page.locator("[role=option]", { hasText: "house.motto" }).click();
  await page.locator(".panel").getByRole("link", { name: "Close" }).click();
  await at("#/tuples?q=motto");
  await open("networks?q=dummy");
  await page.locator(".row", { hasText: "dummy-rooms" }).click();
  await page.locator(".panel").waitFor();
  await press(page, "Escape Escape");
  await at("#/networks?q=dummy");
}

/** What is beside a list scrolls by its own keys, and the list stays where it is. */
async function thePanelScrolls({ page, open }) {
  await open("networks/6541%2Fdummy-rooms");
  const panel = page.getByRole("complementary", { name: "dummy-rooms" });
  await panel.locator(".counters").first().waitFor();
  const active = () => page.locator(".row.active").textContent();
  const before = await active();
  await panel.focus();
  await press(page, "End");
  await page.waitForFunction(() => document.querySelector("aside.panel").scrollTop > 0);
  await press(page, "ArrowUp ArrowDown");
  assert.equal((await active()).slice(0, 8), before.slice(0, 8));
  assert.ok(await panel.evaluate((element) => element === document.activeElement));
}

export const tests = () => [
  { name: "keyboard: back to the list as it was", body: backToTheList },
  { name: "keyboard: a panel scrolls", settings: { context: { viewport: { width: 1280, height: 360 } } }, body: thePanelScrolls },
  { name: "keyboard: every view is reached", body: everyViewIsReached },
  { name: "keyboard: list, search, device, control and back", body: aCommandByKeys },
  { name: "keyboard: the control of the row", body: theControlOfTheRow },
  { name: "keyboard: pin a device", body: pinByKey },
  { name: "keyboard: the active row stays when it is pinned", body: theActiveRowStays },
  { name: "keyboard: wake sensors and let them sleep", body: wakingByKey },
  { name: "keyboard: log, settings and tuples", body: workByKeys },
  { name: "keyboard: the tree by arrows", body: treeByArrows },
  {
    name: "keyboard: the chosen row of the tree is in sight",
    settings: { context: { viewport: { width: 1280, height: 320 } } },
    body: treeRowsAreInSight,
  },
  {
    name: "keyboard: Tab reaches every control and shows where it is",
    body: tabShowsTheFocus,
  },
];
