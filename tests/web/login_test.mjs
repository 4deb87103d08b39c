import assert from "node:assert/strict";

const lines = { lines: true }; // the console reports refused requests

async function logIn(page, token) {
  await page.getByLabel("Token").fill(token);
  await page.getByRole("button", { name: "Log in" }).click();
}

/** Nothing is shown without a token; each role sees what it may do; the cookie is not for scripts. */
async function rolesSeeWhatTheyMay({ page, island }) {
  const { tokens, url } = await island.startGuarded();
  await page.goto(`${url}#/devices/6541/dummy-rooms/living`);
  await page.getByLabel("Token").waitFor();
  assert.equal(await page.locator(".row").count(), 0);
  await logIn(page, "not-a-token");
  await page.getByRole("alert").filter({ hasText: /\w/ }).waitFor();
  await logIn(page, tokens.view);
  await page.locator(".row", { hasText: "lamp-1" }).locator(".state").first().waitFor();
  assert.equal(await page.locator(".control").count(), 0);
  assert.equal(await page.evaluate(() => document.cookie), "");
  await page.getByRole("button", { name: /^Log out view-/ }).click();
  await page.getByLabel("Token").waitFor();
  assert.equal(await page.locator(".row").count(), 0);
  await logIn(page, tokens.command);
  await page.locator(".row", { hasText: "lamp-1" }).locator(".control").waitFor();
}

/** A session that ends leaves the view as it was behind the login: what was typed, the filter, and the chosen row. */
async function aSessionEnds({ page, island }) {
  const { tokens, url, endSessions } = await island.startGuarded();
  await page.goto(`${url}#/devices/6541/dummy-rooms/living`);
  await logIn(page, tokens.command);
  const blind = page.locator(".row", { hasText: "blindPosition-1" });
  await blind.locator("input[type=number]").fill("37");
  await endSessions();
  const dialog = page.locator("dialog");
  await dialog.getByText("The session has ended.").waitFor();
  await blind.waitFor();
  assert.equal(await page.locator(".line-lost .row").count(), await page.locator(".row").count(), "values are not current");
  await page.keyboard.press("Escape");
  await page.keyboard.press("g");
  await page.keyboard.press("o");
  await logIn(page, "not-a-token");
  await dialog.getByRole("alert").filter({ hasText: /\w/ }).waitFor();
  await logIn(page, tokens.command);
  await dialog.waitFor({ state: "detached" });
  await page.locator(".shell.line-live").waitFor();
  assert.equal(await blind.locator("input[type=number]").inputValue(), "37");
  await blind.getByRole("button", { name: "Set" }).click();
  await blind.locator(".outcome", { hasText: "set to 37" }).waitFor();
}

export const tests = () => [
  { name: "login: each role sees what it may do", settings: lines, body: rolesSeeWhatTheyMay },
  { name: "login: a session that ends keeps the view", settings: lines, body: aSessionEnds },
];
