import assert from "node:assert/strict";

async function enter({ page, island }, hash) {
  const house = await island.startHouse();
  await page.goto(`${house.url}#/${hash}`);
  return house;
}

const devicePage = (id) => `devices/6545/dummy-house/${id}`;

/** A device and a point get names, and the device a room; the island keeps them. */
async function names({ page, island, picture }) {
  const { url, valueOf } = await enter({ page, island }, devicePage("meter"));
  await page.getByRole("heading", { name: "Weather" }).waitFor();
  await page.getByRole("button", { name: "Name, room …" }).click();
  await page.getByLabel("Name", { exact: true }).fill("Window sill");
  await page.getByRole("combobox", { name: "Room" }).fill("Kitchen");
  await picture("name-and-room");
  await page.getByRole("button", { name: "Save" }).click();
  await page.getByRole("heading", { name: "Window sill" }).waitFor();
  const description = JSON.parse(await valueOf("proxy.dummy-house.meter.description"));
  assert.deepEqual([description.name, description.area], ["Window sill", "Kitchen"]);
  await page.locator(".row", { hasText: "humidity-1" }).locator(".point-name").click();
  await page.getByLabel("Name", { exact: true }).fill("Air outside");
  await page.getByLabel("Show its curve on the overview").check();
  await page.getByRole("button", { name: "Save" }).click();
  await page.locator(".row", { hasText: "Air outside" }).waitFor();
  const kept = JSON.parse(await valueOf("proxy.overview"));
  assert.deepEqual(kept.names, { "dummy-house.meter.sensor.humidity-1": "Air outside" });
  await page.goto(`${url}#/overview`);
  await page.locator(".pinned-plots", { hasText: "Air outside" }).waitFor();
}

/** One room for several devices, chosen in the list. */
async function severalGetARoom({ page, island, picture }) {
  const { valueOf } = await enter({ page, island }, "devices");
  for (const name of ["Shutter", "Boiler"]) await page.getByRole("checkbox", { name: `select ${name}` }).check();
  await page.getByRole("button", { name: "Room of 2 …" }).click();
  await page.getByRole("combobox", { name: "Room" }).fill("Cellar");
  await page.getByRole("button", { name: "Give the room" }).click();
  await page.getByText("2 devices in Cellar").first().waitFor();
  await picture("rooms-given");
  for (const device of ["shutter", "boiler"]) {
    assert.equal(JSON.parse(await valueOf(`proxy.dummy-house.${device}.description`)).area, "Cellar");
  }
}

/** Chosen rows are dragged together onto a room. */
async function dragged({ page, island }) {
  const { valueOf } = await enter({ page, island }, devicePage("boiler"));
  await page.getByRole("button", { name: "Name, room …" }).click();
  await page.getByRole("combobox", { name: "Room" }).fill("Cellar");
  await page.getByRole("button", { name: "Save" }).click();
  await page.goto(page.url().replace(/#.*/, "#/devices"));
  for (const name of ["Shutter", "Reading lamp"]) await page.getByRole("checkbox", { name: `select ${name}` }).check();
  const row = page.locator(".list-rows .row", { hasText: "Shutter" });
  const data = await page.evaluateHandle(() => new DataTransfer());
  await row.dispatchEvent("dragstart", { dataTransfer: data });
  const target = page.locator(".room-target", { hasText: "Cellar" });
  await page.getByText("Drop 2 devices on a room").waitFor();
  await target.dispatchEvent("drop", { dataTransfer: data });
  await page.getByText("2 devices in Cellar").first().waitFor();
  for (const device of ["shutter", "bulb"]) {
    assert.equal(JSON.parse(await valueOf(`proxy.dummy-house.${device}.description`)).area, "Cellar");
  }
  assert.equal(await page.locator(".room-targets").count(), 0);
}

/** A device is forgotten after a question, and ignored; the island lists it no longer. */
async function forgottenAndIgnored({ page, island }) {
  const { url } = await enter({ page, island }, devicePage("boiler"));
  for (const [device, name, verb] of [
    ["boiler", "Boiler", "Forget"],
    ["stove", "Tiled stove", "Ignore"],
  ]) {
    await page.goto(`${url}#/${devicePage(device)}`);
    await page.getByRole("heading", { name }).waitFor();
    await page.getByRole("button", { name: "Name, room …" }).click();
    await page.getByRole("button", { name: `${verb} …` }).click();
    await page.getByRole("button", { name: `${verb} ${name}` }).click();
    await page
      .getByText(verb === "Forget" ? `${name} is forgotten` : `${name} is ignored`)
      .first()
      .waitFor();
  }
  await page.goto(`${url}#/inbox/ignored`);
  await page.locator(".row", { hasText: "Tiled stove" }).waitFor();
}

/** The search knows what devices measure, and rooms. */
async function searchOfTypes({ page, island }) {
  await enter({ page, island }, devicePage("meter"));
  await page.getByRole("heading", { name: "Weather" }).waitFor();
  await page.keyboard.press("/");
  await page.keyboard.type("humid");
  await page.locator(".results li", { hasText: "type" }).click();
  await page.waitForURL(/devices\?type=humidity/);
  await page.locator(".row", { hasText: "Weather" }).waitFor();
  assert.equal(await page.locator(".row", { hasText: "Boiler" }).count(), 0);
}

export const tests = () => [
  { name: "commission: names of a device and of a point", body: names },
  { name: "commission: a room for several devices", body: severalGetARoom },
  { name: "commission: devices are dragged to a room", body: dragged },
  { name: "commission: a device is forgotten, another ignored", body: forgottenAndIgnored },
  { name: "commission: the search finds types", body: searchOfTypes },
];
