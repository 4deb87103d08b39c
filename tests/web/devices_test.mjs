import assert from "node:assert/strict";
import { publisher } from "./island.mjs";

const names = (page) => page.locator(".list-rows .device-name").allTextContents();

async function filteredToNothing({ page, open }) {
  await open("devices?q=nosuchdevice");
  await page.getByText("No device matches.").waitFor();
  await page.getByRole("button", { name: "Clear filter" }).click();
  await page.locator(".row", { hasText: "Hot water tank" }).waitFor();
  assert.ok(!page.url().includes("nosuchdevice"));
}

/** The order by a column and back the other way; it is in the address, so that it can be sent. */
async function sorts({ page, open, island }) {
  await open("devices");
  await page.locator(".row", { hasText: "Hot water tank" }).waitFor();
  const up = await names(page);
  await page.getByRole("columnheader", { name: "Name" }).getByRole("button").click();
  await page.locator('[role=columnheader][aria-sort="descending"]').waitFor();
  assert.deepEqual(await names(page), [...up].reverse());
  const address = page.url();
  await page.goto(`${island.url}#/overview`);
  await page.goto(address);
  await page.locator(".row", { hasText: "Hot water tank" }).waitFor();
  assert.deepEqual(await names(page), [...up].reverse());
}

/** Points come after the list of devices. */
async function ofAType({ page, open }) {
  await open("devices?type=temperature");
  await page.locator(".row", { hasText: "Bedroom" }).waitFor();
  const fresh = await names(page);
  assert.ok(fresh.length > 0 && fresh.length < 5, String(fresh));
  await page.reload();
  await page.locator(".row", { hasText: "Bedroom" }).waitFor();
  assert.deepEqual(await names(page), fresh);
}

async function groups({ page, open }) {
  await open("devices");
  await page.getByLabel("Group").selectOption("place");
  const groups = page.locator(".row.group");
  await groups.first().waitFor();
  assert.deepEqual(
    (await groups.allTextContents()).map((text) => text.trim()),
    ["<b>Lab</b> 1", "no room 4"],
  );
}

async function compares({ page, open }) {
  await open("devices");
  for (const name of ["Living room", "Bedroom"]) await page.getByLabel(`select ${name}`).check();
  await page.getByRole("link", { name: "Compare 2" }).click();
  await page.getByRole("heading", { name: "Compared devices" }).waitFor();
  for (const column of [/^dimmer/, /^lamp/, /^light/, /^temperature/]) await page.getByRole("columnheader", { name: column }).waitFor();
  assert.equal(await page.locator(".list-rows .row").count(), 2);
}

/** What a program publishes in the shape of a line or a device is neither. */
async function otherTuples({ page, open, island }) {
  island.publish("robot.arm.status", "idle", publisher + 1);
  island.publish("robot.arm.left.status", '{"status":"unreachable"}');
  await open(`tuples/${publisher}:robot.arm.left.status`);
  await page.locator(".panel .content", { hasText: "unreachable" }).waitFor();
  await open("networks");
  await page.locator(".row", { hasText: "dummy-rooms" }).waitFor();
  assert.equal(await page.locator(".row", { hasText: "arm" }).count(), 0);
  await open("devices");
  await page.locator(".row", { hasText: "Hot water tank" }).waitFor();
  assert.equal(await page.locator(".row", { hasText: "left" }).count(), 0);
}

/** A long list is not held up by the values of all its points. */
async function listComesFirst({ page, open }) {
  const frames = [];
  const before = new Promise((asked) => {
    const take = ({ payload }) => {
      const frame = JSON.parse(payload);
      if (frame.pattern === "*:*.*.*.*.*.value") asked([...frames]);
      frames.push(frame);
    };
    page.on("websocket", (socket) => {
      socket.on("framesent", take);
      socket.on("framereceived", take);
    });
  });
  await open("devices");
  const { id } = (await before).find((frame) => frame.pattern === "*:*.*.*.description");
  const devices = (await before).find((frame) => frame.id === id && frame.ok)?.subscription;
  assert.ok((await before).some((frame) => frame.s === devices && frame.snapshot !== undefined));
}

export const tests = () => [
  { name: "devices: other tuples of their shape are none", body: otherTuples },
  { name: "devices: the list comes before the values", body: listComesFirst },
  { name: "devices: filtered to nothing", body: filteredToNothing },
  { name: "devices: of a type, from an address", body: ofAType },
  { name: "devices: sorted, by an address that can be sent", body: sorts },
  { name: "devices: grouped", body: groups },
  { name: "devices: chosen ones are compared", body: compares },
];
