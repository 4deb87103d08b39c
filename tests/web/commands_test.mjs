import assert from "node:assert/strict";

function rowOf(page, point) {
  return page.locator(".row", { has: page.locator(".point-name", { hasText: point }) });
}

async function outcomeIs(page, point, state) {
  await rowOf(page, point).locator(".outcome .state", { hasText: state }).waitFor();
}

/** Turns an actuator of two words: a switch where its value is known, else a button for each word. */
async function turn(row) {
  await row.getByRole("button", { name: "on", exact: true }).or(row.getByRole("switch")).first().click();
}

async function confirmed({ page, open }) {
  await open("devices/6541/dummy-rooms/living");
  const lamp = rowOf(page, "lamp-1");
  await turn(lamp);
  await outcomeIs(page, "lamp-1", "confirmed");
  await lamp.locator(".value", { hasText: /^o(n|ff)$/ }).waitFor();
}

/** While a command is under way, the control and the value show what the device reported. */
async function noEcho({ page, open }) {
  await open("devices/6541/dummy-rooms/living");
  const blind = rowOf(page, "blindPosition-1");
  await blind.locator("input[type=number]").fill("40");
  await blind.getByRole("button", { name: "Set" }).click();
  await blind.locator(".outcome", { hasText: /sent|queued/ }).waitFor();
  assert.equal(await blind.locator(".value", { hasText: "40" }).count(), 0);
}

/** The first command waits for a device that does not answer, for as long as the second page needs to open. */
async function superseded({ page, open, context, island }) {
  await open("devices/6541/dummy-rooms/remote");
  await page.locator(".thing .state", { hasText: "unreachable" }).waitFor();
  await page.locator(".ttl select").selectOption("86400");
  const set = async (at, value) => {
    await at.locator("input[type=number]").fill(value);
    await at.getByRole("button", { name: "Set" }).click();
  };
  await set(rowOf(page, "led-1"), "1");
  await outcomeIs(page, "led-1", "queued");
  const other = await context.newPage();
  await other.goto(`${island.url}#/devices/6541/dummy-rooms/remote`);
  await rowOf(other, "led-1").locator("input[type=number]").waitFor();
  await set(rowOf(other, "led-1"), "0");
  await page.locator(".spoken", { hasText: "superseded" }).waitFor({ state: "attached" });
  await outcomeIs(other, "led-1", "expired");
}

async function assumed({ page, open }) {
  await open("devices/6541/dummy-rooms/bedroom");
  const dimmer = rowOf(page, "dimmer-1");
  await dimmer.locator("input[type=number]").fill("30");
  await dimmer.getByRole("button", { name: "Set" }).click();
  await outcomeIs(page, "dimmer-1", "assumed");
  await dimmer.locator(".value", { hasText: "30" }).waitFor();
}

async function timedOut({ page, open }) {
  await open("devices/6541/dummy-rooms/tank");
  await turn(rowOf(page, "boiler-1"));
  await outcomeIs(page, "boiler-1", "timed-out");
  await page.goto(`${page.url().split("#")[0]}#/overview`);
  await page.locator(".card", { hasText: "Needs attention" }).locator("li", { hasText: "boiler-1" }).waitFor();
}

/** A slider whose value is not known stands nowhere. */
async function unknownValue({ page, open }) {
  await open("devices/6541/dummy-rooms/tank");
  const slider = rowOf(page, "valve-1").getByRole("slider");
  assert.equal(await slider.getAttribute("aria-valuetext"), "unknown");
  await rowOf(page, "valve-1").locator("input[type=number]").fill("50");
  await rowOf(page, "valve-1").locator("input[type=range]:not(.unknown, [aria-valuetext])").waitFor();
}

async function failed({ page, open }) {
  await open("devices/6541/dummy-rooms/tank");
  const valve = rowOf(page, "valve-1");
  await valve.locator("input[type=number]").fill("50");
  await valve.getByRole("button", { name: "Set" }).click();
  await outcomeIs(page, "valve-1", "failed");
  await page.goto(`${page.url().split("#")[0]}#/overview`);
  await page.locator(".card", { hasText: "Needs attention" }).locator("li", { hasText: "valve-1" }).waitFor();
}

/** The device has it and has not reported yet. */
async function sent({ page, open }) {
  await open("devices/6541/dummy-rooms/living");
  const blind = rowOf(page, "blindPosition-1");
  await blind.locator("input[type=number]").fill("35");
  await blind.getByRole("button", { name: "Set" }).click();
  await outcomeIs(page, "blindPosition-1", /^sent$/);
}

/** The field accepts it, the island does not: the page shows the island's reason. */
async function refused({ page, open }) {
  await open("devices/6541/dummy-rooms/bedroom");
  const dimmer = rowOf(page, "dimmer-1");
  await dimmer.locator("input[type=number]").evaluate((field) => field.removeAttribute("max"));
  await dimmer.locator("input[type=number]").fill("900");
  await dimmer.getByRole("button", { name: "Set" }).click();
  await outcomeIs(page, "dimmer-1", "refused");
  await dimmer.locator(".outcome", { hasText: "100" }).waitFor();
}

/** A device that does not answer: the command waits as long as the user chose, then expires. */
async function expired({ page, open }) {
  await open("devices/6541/dummy-rooms/remote");
  await page.locator(".thing .state", { hasText: "unreachable" }).waitFor();
  const led = rowOf(page, "led-1");
  await led.locator("input[type=number]").fill("1");
  await led.getByRole("button", { name: "Set" }).click();
  await outcomeIs(page, "led-1", "queued");
  await outcomeIs(page, "led-1", "expired");
}

/** What the island refused is still in the field; it can be discarded. */
async function theDraftStays({ page, open }) {
  await open("devices/6541/dummy-rooms/bedroom");
  const dimmer = rowOf(page, "dimmer-1");
  const field = dimmer.locator("input[type=number]");
  await field.evaluate((element) => element.removeAttribute("max"));
  await field.fill("901");
  await dimmer.getByRole("button", { name: "Set" }).click();
  await dimmer.locator(".outcome", { hasText: "set to 901" }).locator(".state", { hasText: "refused" }).waitFor();
  assert.equal(await field.inputValue(), "901");
  await page.goto(`${page.url().split("#")[0]}#/overview`);
  await page.goBack();
  assert.equal(await field.inputValue(), "901");
  await dimmer.getByRole("button", { name: /^Discard/ }).click();
  await page.waitForFunction(() => document.activeElement?.matches(".control input") && document.activeElement.value !== "901");
}

/** The choice is shown beside the command that waits, and ends with the page of the device. */
async function patienceIsPerDevice({ page, open }) {
  await open("devices/6541/dummy-rooms/remote");
  const waits = page.locator(".ttl select");
  await waits.selectOption("86400");
  const led = rowOf(page, "led-1");
  await led.locator("input[type=number]").fill("1");
  await led.getByRole("button", { name: "Set" }).click();
  await led.locator(".outcome", { hasText: /waits until \d{4}-/ }).waitFor();
  await page.goto(`${page.url().split("#")[0]}#/devices/6541/dummy-rooms/tank`);
  await page.getByRole("heading", { name: "Hot water tank" }).waitFor();
  assert.equal(await waits.inputValue(), "5");
  await page.goBack();
  await page.getByRole("heading", { name: "Remote control" }).waitFor();
  assert.equal(await waits.inputValue(), "5");
  await led.locator("input[type=number]").fill("0");
  await led.getByRole("button", { name: "Set" }).click();
  await outcomeIs(page, "led-1", "expired");
}

export const tests = () => [
  { name: "commands: confirmed", body: confirmed },
  { name: "commands: no echo of what is commanded", body: noEcho },
  { name: "commands: superseded by another page", body: superseded },
  { name: "commands: assumed", body: assumed },
  { name: "commands: timed-out, and on the overview", body: timedOut },
  { name: "commands: a value that is not known", body: unknownValue },
  { name: "commands: failed, and on the overview", body: failed },
  { name: "commands: sent", body: sent },
  { name: "commands: refused, with the reason of the island", body: refused },
  { name: "commands: queued and expired", body: expired },
  { name: "commands: what was refused stays in its field", body: theDraftStays },
  { name: "commands: how long they wait is chosen for one device", body: patienceIsPerDevice },
];
