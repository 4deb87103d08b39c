import assert from "node:assert/strict";

/** Another island comes, is chosen, and goes. */
async function twoIslands({ page, open, island }) {
  await open("overview");
  await page.locator("tbody tr", { hasText: "home" }).waitFor();
  assert.equal(await page.locator("tbody tr").count(), 1);
  await island.startNeighbour();
  await page.locator("tbody tr", { hasText: "shed" }).waitFor();
  await open("devices");
  await page.locator(".row", { hasText: "Lawn mower" }).waitFor();
  await page.locator(".row", { hasText: "Hot water tank" }).waitFor();
  await page.getByLabel("Island").selectOption({ label: "shed · 6542" });
  await page.locator(".row", { hasText: "Hot water tank" }).waitFor({ state: "detached" });
  assert.match(page.url(), /island=6542/);
  await page.locator(".row", { hasText: "Lawn mower" }).click();
  await page.getByRole("heading", { name: "Lawn mower" }).waitFor();
  const mower = page.locator(".row", { has: page.locator(".control") }).first();
  await mower.getByRole("button", { name: "on", exact: true }).click();
  await mower.locator(".outcome .state", { hasText: "confirmed" }).waitFor();
}

/** Without an island, the page names the command that says why. */
async function noIsland({ page, island }) {
  const url = await island.startAlone();
  for (const view of ["overview", "devices"]) {
    await page.goto(`${url}#/${view}`);
    await page.getByRole("heading", { name: "No island found." }).waitFor();
    const folder = process.env.RUBICON_FOLDER;
    await page.getByText(`The server looks in folder ${folder}, space empty.`).waitFor();
    await page.getByText(`rubicon doctor --folder ${folder} --space empty`, { exact: true }).waitFor();
  }
}

export const tests = () => [
  { name: "islands: two on one page", body: twoIslands },
  { name: "islands: none", body: noIsland },
];
