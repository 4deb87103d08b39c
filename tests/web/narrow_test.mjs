import assert from "node:assert/strict";
import { settled, viewsOf } from "./browser.mjs";

const more = ["devices/6541/dummy-rooms/living", "tuples/6541:house.motto", "overview/network%206541%2Fdummy-rooms"];

/** What goes beyond the right edge and cannot be scrolled to. */
export function beyondTheEdge() {
  const scrolls = (element) =>
    element && (/auto|scroll|hidden/.test(getComputedStyle(element).overflowX) || scrolls(element.parentElement));
  return [...document.querySelectorAll("body *")]
    .filter((element) => element.getBoundingClientRect().right > innerWidth + 1 && element.getClientRects().length > 0)
    .filter((element) => !scrolls(element.parentElement) && !element.closest(".spoken"))
    .map((element) => element.outerHTML.slice(0, 120));
}

/** Touch targets that are smaller than 44 pixels in both directions. */
export function smallTargets() {
  return [...document.querySelectorAll("button, select, input, nav a")]
    .filter(
      (element) =>
        element.getClientRects().length > 0 && element.type !== "checkbox" && element.type !== "range" && !element.closest(".skip"),
    )
    .map((element) => ({ box: element.getBoundingClientRect(), html: element.outerHTML.slice(0, 120) }))
    .filter(({ box }) => box.height < 43.5 && box.bottom > 0)
    .map(({ html }) => html);
}

async function fits({ page, open, picture }) {
  await open("overview");
  const views = (await viewsOf(page)).map(({ id }) => id);
  for (const address of [...views, ...more]) {
    await open(address);
    await settled(page);
    await picture(`narrow-${address.replace(/\W+/g, "-")}`);
    assert.equal(await page.evaluate(() => document.scrollingElement.scrollWidth), 320, address);
    assert.deepEqual(await page.evaluate(beyondTheEdge), [], address);
    assert.deepEqual(await page.evaluate(smallTargets), [], address);
    assert.ok((await page.locator("main h1").first().boundingBox()).width > 30, `${address} has no title`);
    assert.doesNotMatch(await page.locator("main").innerText(), /`/, address);
  }
}

const phone = {
  context: {
    viewport: { width: 320, height: 640 },
    hasTouch: true,
    isMobile: true,
  },
};

/** Neither beyond the screen, nor below something else, nor shortened. */
async function isWhole(page, locator) {
  await locator.waitFor();
  return locator.evaluate((element) => {
    const { left, right, top, bottom } = element.getBoundingClientRect();
    const { clientWidth, clientHeight } = document.documentElement;
    const shown = left >= 0 && right <= clientWidth && top >= 0 && bottom <= clientHeight;
    const above = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
    return shown && element.contains(above) && element.scrollWidth <= element.clientWidth;
  });
}

/** What was decided in the inbox, and what was written into the file, can be taken back on a phone. */
async function undoIsWhole({ page, island }) {
  const waiting = 'networks.dummy-new={type: dummy, simulate: {gate: {name: "Gate of the garden behind the house", keepalive: 1s}}}';
  const { url } = await island.startHouse(waiting, "discovery={rules: [{network: dummy-new, new-devices: ask}]}");
  const undo = page.getByRole("button", { name: "Undo", exact: true });
  for (const width of [320, 390]) {
    await page.setViewportSize({ width, height: 640 });
    await page.goto(`${url}#/inbox`);
    await page.getByRole("button", { name: "Approve dummy-new.gate" }).click();
    assert.ok(await isWhole(page, undo), `of a decision, ${width}`);
    await undo.click();
    await page.goto(`${url}#/networks/add`);
    await page.getByLabel("Kind of network").selectOption("dummy");
    await page.getByLabel("Its id").fill(`dummy-${width}`);
    await page.getByRole("button", { name: "Check …" }).click();
    await page.getByRole("button", { name: /^Write/ }).click();
    assert.ok(await isWhole(page, undo), `of a change of the file, ${width}`);
    await undo.click();
    await page.locator(".row", { hasText: `dummy-${width}` }).waitFor({ state: "detached" });
  }
}

/** The words of a button stand in its middle. */
async function theLogin({ page, island }) {
  const { url } = await island.startGuarded();
  await page.goto(url);
  const button = page.getByRole("button", { name: "Log in" });
  await button.waitFor();
  const off = await button.evaluate((element) => {
    const words = document.createRange();
    words.selectNodeContents(element);
    const middle = ({ left, width }) => left + width / 2;
    return middle(words.getBoundingClientRect()) - middle(element.getBoundingClientRect());
  });
  assert.ok(Math.abs(off) <= 1, String(off));
}

async function widthOf(locator) {
  return (await locator.boundingBox()).width;
}

/** With tokens, a chooser and a switch, the head has room for each; the rest is behind `More`. */
async function theHeadFits({ page, island }) {
  const { tokens, url } = await island.startGuarded();
  await page.goto(`${url}#/devices/6541/dummy-rooms/living`);
  await page.getByLabel("Token").fill(tokens.command);
  await page.getByRole("button", { name: "Log in" }).click();
  await page.locator(".row", { hasText: "light-1" }).waitFor();
  const turn = page.locator(".active-switch");
  await turn.click();
  await page.getByRole("switch", { name: "Active waking 1 sensor" }).waitFor();
  assert.match(await turn.innerText(), /Active\s*1/);
  assert.ok((await widthOf(page.getByLabel("Island"))) >= 75);
  assert.ok((await widthOf(page.getByRole("button", { name: "Search" }))) >= 40);
  assert.deepEqual(await page.evaluate(beyondTheEdge), []);
  await page.getByRole("button", { name: "More" }).click();
  await page.getByRole("button", { name: /^Theme/ }).waitFor();
  await page.getByRole("button", { name: /^Log out command-/ }).click();
  await page.getByLabel("Token").waitFor();
}

/** The state of the connection is a word, not only a colour: always for screen readers, and to be seen when it is lost. */
async function theConnectionIsAWord({ page, open, island }) {
  await open("devices/6541/dummy-rooms/living");
  const word = page.locator(".line-text");
  assert.equal(await word.innerText(), "connected");
  await island.kill();
  try {
    await page.locator(".shell.line-lost").waitFor();
    assert.match(await word.innerText(), /^connection lost/);
    assert.ok((await widthOf(word)) > 150);
    assert.deepEqual(await page.evaluate(beyondTheEdge), []);
  } finally {
    await island.start();
  }
}

/** Devices are chosen on a phone, and compared in a table that scrolls beside their names. */
async function devicesAreCompared({ page, open }) {
  await open("devices?q=room");
  await page.getByText("Filters, groups, order").click();
  await page.getByLabel("Group").waitFor();
  assert.deepEqual(await page.evaluate(beyondTheEdge), []);
  for (const name of ["Living room", "Bedroom"]) await page.getByRole("checkbox", { name: `select ${name}` }).check();
  await page.getByRole("link", { name: "Compare 2" }).click();
  await page
    .getByRole("columnheader", { name: "illuminance (lx)" })
    .or(page.getByRole("columnheader", { name: "light (lx)" }))
    .waitFor();
  const name = page.getByRole("gridcell", { name: "Bedroom" }).first();
  const list = page.locator(".list");
  assert.ok(await list.evaluate((element) => element.scrollWidth > element.clientWidth));
  await list.evaluate((element) => element.scrollTo(200, 0));
  await page.waitForFunction(() => document.querySelector(".list").scrollLeft > 0);
  assert.ok((await name.boundingBox()).x >= 0);
  assert.ok((await page.getByRole("columnheader").count()) > 4);
}

/** Numbers are typed on a pad for digits; what the device says and what became of commands is whole. */
async function aDeviceOnAPhone({ page, open }) {
  await open("devices/6541/dummy-rooms/tank");
  const row = (id) => page.locator(".row", { has: page.getByText(id, { exact: true }) });
  await page.getByRole("button", { name: "on", exact: true }).first().click();
  const outcome = row("boiler-1").locator(".outcome");
  await outcome.locator(".state", { hasText: "timed-out" }).waitFor();
  await outcome.getByText("no report of the device").waitFor();
  const cut = await row("boiler-1").evaluate((element) => {
    const low = element.getBoundingClientRect().bottom;
    return [...element.querySelectorAll(".outcome *")].some(
      (one) => one.getBoundingClientRect().bottom > low + 1 || one.scrollWidth > one.clientWidth + 1,
    );
  });
  assert.equal(cut, false);
  const blank = await page.locator(".row:has(.control)").evaluateAll((rows) =>
    rows.map((element) => {
      const shown = [...element.querySelectorAll("*")].filter((one) => one.getClientRects().length > 0 && one.textContent !== "");
      return element.getBoundingClientRect().bottom - Math.max(...shown.map((one) => one.getBoundingClientRect().bottom));
    }),
  );
  assert.ok(blank.length > 0 && blank.every((pixels) => pixels < 20), `blank below controls: ${blank}`);
  assert.equal(await row("valve-1").locator("input[type=number]").getAttribute("inputmode"), "numeric");
}

export const tests = () => [
  { name: "narrow: a device, its pad for numbers and whole reasons", settings: phone, body: aDeviceOnAPhone },
  { name: "narrow: undo is whole", settings: phone, body: undoIsWhole },
  { name: "narrow: the login", settings: { ...phone, lines: true }, body: theLogin },
  {
    name: "narrow: the head with tokens",
    settings: { ...phone, lines: true },
    body: theHeadFits,
  },
  {
    name: "narrow: the connection is a word",
    settings: { ...phone, lines: true },
    body: theConnectionIsAWord,
  },
  {
    name: "narrow: devices are compared",
    settings: phone,
    body: devicesAreCompared,
  },
  {
    name: "narrow: every view fits into 320 pixels, targets are 44",
    settings: phone,
    body: fits,
  },
];
