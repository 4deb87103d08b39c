/** What the island logs appears while one looks. */
async function linesArrive({ page, open, context, island }) {
  await open("log");
  const other = await context.newPage();
  await other.goto(`${island.url}#/devices/6541/dummy-rooms/bedroom`);
  const dimmer = other.locator(".row", { has: other.locator(".point-name", { hasText: "dimmer-1" }) });
  await dimmer.locator("input[type=number]").fill("55");
  await dimmer.getByRole("button", { name: "Set" }).click();
  await dimmer.locator(".outcome .state", { hasText: "assumed" }).waitFor();
  await page.locator(".list-rows .row", { hasText: "dimmer-1" }).filter({ hasText: "assumed" }).first().waitFor();
}

export const tests = () => [{ name: "log: lines arrive", body: linesArrive }];
