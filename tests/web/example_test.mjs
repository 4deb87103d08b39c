import assert from "node:assert/strict";

/** The island of the examples as its users see it first. */
async function asItIsFirst({ page, island, picture }) {
  const url = await island.startExample();
  await page.goto(`${url}#/devices?group=network`);
  await page.locator(".row", { hasText: "Kitchen air" }).locator(".quality-good").waitFor();
  await page.locator(".row", { hasText: "BED" }).locator(".state", { hasText: "good" }).first().waitFor();
  await picture("example-devices");
  const hour = page.waitForResponse((response) => response.url().includes("/history?"));
  await page.locator(".row", { hasText: "Living room" }).click();
  assert.equal((await (await hour).json()).bucket, 60, "a curve of an hour is not coarser than minutes");
  const row = (name) => page.locator(".row", { hasText: name });
  await page.locator(".active-switch").click();
  await row("lamp-1").getByRole("button", { name: "on", exact: true }).click();
  await row("lamp-1").locator(".outcome", { hasText: "confirmed" }).waitFor();
  await row("blindPosition-1").locator("input[type=number]").fill("40");
  await row("blindPosition-1").getByRole("button", { name: "Set" }).click();
  await row("blindPosition-1").locator(".outcome", { hasText: "confirmed" }).waitFor();
  await row("light-1").locator(".quality-good").waitFor();
  const curve = await row("light-1").locator(".spark path").first().getAttribute("d");
  assert.ok(curve.length > 200, curve);
  await picture("example-device");
}

export const tests = () => [
  { name: "example: its devices, and a command", settings: { context: { viewport: { width: 1280, height: 580 } } }, body: asItIsFirst },
];
