import assert from "node:assert/strict";

/** The island dies and returns: the page says so, keeps place and forms, and shows values again. */
async function heals({ page, open, island }) {
  await open("devices/6541/dummy-rooms/living");
  const blind = page.locator(".row", { hasText: "blindPosition-1" });
  await blind.locator("input[type=number]").fill("55");
  await page.locator(".shell.line-live").waitFor();
  await island.kill();
  await page.locator(".shell.line-lost").waitFor();
  await page.locator(".line", { hasText: "connection lost" }).waitFor();
  await page.locator(".spoken", { hasText: "connection lost" }).waitFor({ state: "attached" });
  assert.equal(await page.getByRole("heading", { name: "Living room" }).count(), 1);
  await blind.getByRole("button", { name: "Set" }).click();
  await blind.locator(".outcome", { hasText: "connection" }).waitFor();
  await blind.locator("input[type=number]").fill("56");
  await island.start();
  await page.locator(".shell.line-live").waitFor();
  assert.equal(await blind.locator("input[type=number]").inputValue(), "56");
  await blind.getByRole("button", { name: "Set" }).click();
  await blind.locator(".outcome", { hasText: /sent|queued|confirmed|timed-out/ }).waitFor();
}

/** Rows keep their place over a reconnection. */
async function keepsThePlace({ page, open, island }) {
  let snapshots = 0;
  page.on("websocket", (socket) => socket.on("framereceived", ({ payload }) => (snapshots += "snapshot" in JSON.parse(payload) ? 1 : 0)));
  await open("tuples?q=proxy.dummy-rooms");
  const list = page.locator(".list");
  await page.locator("[role=option]").nth(20).waitFor();
  await list.evaluate((element) => (element.scrollTop = 600));
  await page.waitForFunction(() => document.querySelector(".list").scrollTop === 600);
  const before = snapshots;
  assert.ok(before > 0);
  await island.kill();
  await page.locator(".shell.line-lost").waitFor();
  await island.start();
  await page.locator(".shell.line-live").waitFor();
  while (snapshots < 2 * before) await page.waitForTimeout(50); // all subscriptions have their snapshots again
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  await page.locator("[role=option]").nth(20).waitFor();
  assert.equal(await list.evaluate((element) => element.scrollTop), 600);
}

const lines = { lines: true };

export const tests = () => [
  { name: "reconnect: the island is killed and started", settings: lines, body: heals },
  { name: "reconnect: rows keep their place", settings: lines, body: keepsThePlace },
];
