import assert from "node:assert/strict";

/** Devices of the house and their rooms. */
const rooms = { bulb: "Living room", shutter: "Living room", stove: "Kitchen", meter: "Kitchen", boiler: "Cellar" };

/** A house with rooms, and its overview. */
async function enter({ page, island }) {
  const house = await island.startHouse();
  await page.goto(`${house.url}#/overview`);
  await page.locator(".room", { hasText: "5 devices" }).waitFor(); // the network: none has a room
  for (const [device, area] of Object.entries(rooms)) {
    const key = `proxy.dummy-house.${device}.description`;
    const body = JSON.stringify({ area });
    const answer = await fetch(`${house.url}api/v1/tuples/6545/${key}`, { method: "PUT", body });
    assert.equal(answer.status, 200, await answer.text());
  }
  await roomCard(page, "Kitchen").waitFor();
  return house;
}

const roomCard = (page, name) => page.getByRole("region", { name, exact: true });
const namesOf = (page) => page.locator(".room h3").allInnerTexts();

/** What a room measures and operates is on its card; a sensor is woken only when somebody asks. */
async function cards({ page, island, picture }) {
  await enter({ page, island });
  assert.deepEqual(await namesOf(page), ["Cellar", "Kitchen", "Living room"]);
  const kitchen = roomCard(page, "Kitchen");
  await kitchen.getByText("Temperature, humidity, doors, windows: not measured, nobody asks").waitFor();
  await kitchen.getByRole("button", { name: "Measure Kitchen" }).click();
  await kitchen.locator(".fact", { hasText: "temperature" }).getByText("20.4").waitFor(); // as people read it
  await kitchen.locator(".fact", { hasText: "humidity" }).getByText("47").waitFor();
  await kitchen.locator(".fact", { hasText: "doors, windows" }).getByText("open").waitFor();
  await picture("rooms");
  await kitchen.getByRole("link", { name: "Kitchen" }).click();
  await page.getByRole("heading", { name: "Kitchen" }).waitFor();
  await page.locator(".room-devices li", { hasText: "Tiled stove" }).waitFor();
  await page.locator(".tile", { hasText: "Tiled stove" }).waitFor();
  assert.equal(await page.locator(".tile", { hasText: "Shutter" }).count(), 0);
  await picture("room");
}

/** The island keeps the order and the curves: another browser and the command line see them. */
async function orderAndCurves({ page, island, browser }) {
  const { url, valueOf } = await enter({ page, island });
  await page.getByRole("button", { name: "Arrange" }).click();
  await page.getByRole("button", { name: "Move Kitchen forward" }).click();
  await page.waitForFunction(() => document.querySelector(".room h3")?.textContent === "Kitchen");
  await page.getByRole("button", { name: "Done" }).click();
  await page.goto(`${url}#/overview/Kitchen`);
  await page.getByRole("button", { name: "Tiled stove · temperature on the overview" }).click();
  await page.locator(".pin[aria-pressed=true]").waitFor();
  const kept = JSON.parse(await valueOf("proxy.overview"));
  assert.deepEqual(kept.rooms, ["Kitchen", "Cellar", "Living room"]);
  assert.deepEqual(kept.pins, ["dummy-house.stove.sensor.temperature-1"]);
  const other = await browser.session(island, {});
  try {
    await other.page.goto(`${url}#/overview`);
    await other.page.locator(".pinned-plots", { hasText: "Tiled stove · temperature" }).waitFor();
    assert.deepEqual(await namesOf(other.page), ["Kitchen", "Cellar", "Living room"]);
  } finally {
    await other.context.close();
  }
}

/** With the role view all is shown, the page says why nothing can be changed, and has no control. */
async function onlyLooking({ page, island }) {
  const { tokens, url } = await island.startGuarded();
  await page.goto(`${url}#/overview`);
  await page.getByLabel("Token").fill(tokens.view);
  await page.getByRole("button", { name: "Log in" }).click();
  await page.getByText("You look with the role view: to change something needs the role command.").waitFor();
  const rooms = page.locator(".room", { hasText: "dummy-rooms" });
  await rooms.locator(".tile", { hasText: "Living room" }).first().waitFor();
  assert.equal(await rooms.locator("button:not(.small), input").count(), 0);
  assert.equal(await page.getByRole("button", { name: "Arrange" }).count(), 0);
  await page.goto(`${url}#/networks/6541%2Fwsn-hall`);
  await page.getByText("needs the role admin").waitFor();
}

const tileOf = (page, name) => page.locator(".tile", { hasText: name });

/** A slider acts when it is let go, and not before; a lamp shows what it reported. */
async function lights({ page, island }) {
  const { valueOf } = await enter({ page, island });
  const lamp = tileOf(page, "Reading lamp");
  await lamp.getByRole("button", { name: "on", exact: true }).click();
  await lamp.getByRole("switch", { checked: true }).waitFor();
  const level = lamp.getByRole("slider", { name: "Brightness of Reading lamp" });
  const box = await level.boundingBox();
  await page.mouse.move(box.x + box.width * 0.1, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.6, box.y + box.height / 2, { steps: 8 });
  await page.waitForTimeout(300); // nothing is sent meanwhile, however long that is
  assert.equal(await valueOf("proxy.dummy-house.bulb.actuator.dimmer-1.command"), "");
  await page.mouse.up();
  await lamp.locator(".tile-value", { hasText: /^(5|6)\d %$/ }).waitFor();
  assert.match(await valueOf("proxy.dummy-house.bulb.actuator.dimmer-1.value"), /^(5|6)\d$/);
}

/** The wheel sends the colour of the place where the pointer is let go; keys have sliders for the same. */
async function colours({ page, island, picture }) {
  const { valueOf } = await enter({ page, island });
  await tileOf(page, "Reading lamp").getByRole("button", { name: "Colour of Reading lamp" }).click();
  const wheel = await page.locator(".wheel").boundingBox();
  await page.mouse.click(wheel.x + wheel.width - 2, wheel.y + wheel.height / 2); // a quarter to the right: 90 degrees
  await page.locator("dialog .state", { hasText: "confirmed" }).waitFor();
  assert.match(await valueOf("proxy.dummy-house.bulb.actuator.colourRgb-1.value"), /^#8[0-9a-f]ff0[0-9a-f]$/i);
  await picture("colour");
  await page.getByRole("slider", { name: "Saturation" }).press("Home"); // no colour at all
  await page.locator("dialog", { hasText: "#ffffff" }).waitFor();
}

/** Up, stop and down; a few steps of a thermostat are one command. */
async function blindAndHeating({ page, island }) {
  const { url, valueOf } = await enter({ page, island });
  await tileOf(page, "Shutter").getByRole("button", { name: "Shutter: down" }).click();
  while ((await valueOf("proxy.dummy-house.shutter.actuator.blindMove-1.command")) !== "down") await page.waitForTimeout(50);
  const stove = tileOf(page, "Tiled stove");
  for (let step = 0; step < 3; step++) await stove.getByRole("button", { name: "Tiled stove: warmer" }).click();
  await stove.locator(".target.chosen", { hasText: "21.5" }).waitFor();
  await stove.locator(".target:not(.chosen)", { hasText: "21.5 °C" }).waitFor();
  const target = "proxy.dummy-house.stove.actuator.temperatureSetpoint-1";
  assert.equal(await valueOf(`${target}.value`), "21.5");
  const { sequence } = await (await fetch(`${url}api/v1/tuples/6545/${target}.command`)).json();
  assert.equal(sequence, 2, "declared, then set once");
}

/** Why a command did not end well stands below its control, whole. */
async function troubles({ page, island }) {
  await enter({ page, island });
  const boiler = tileOf(page, "Boiler");
  await boiler.getByRole("button", { name: "on", exact: true }).click();
  const trouble = boiler.locator(".tile-trouble");
  await trouble.locator(".state", { hasText: "failed" }).waitFor();
  assert.ok(
    await trouble.evaluate((element) => element.scrollWidth <= element.clientWidth && element.scrollHeight <= element.clientHeight + 1),
  );
}

export const tests = () => [
  { name: "rooms: cards with values and controls", body: cards },
  { name: "rooms: order and curves are kept by the island", body: orderAndCurves },
  { name: "rooms: the role view looks", settings: { lines: true }, body: onlyLooking },
  { name: "rooms: a slider acts when it is let go", body: lights },
  { name: "rooms: the colour wheel", body: colours },
  { name: "rooms: blind and thermostat", body: blindAndHeating },
  { name: "rooms: why a command failed", body: troubles },
];
