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

export const tests = () => [{ name: "login: each role sees what it may do", settings: lines, body: rolesSeeWhatTheyMay }];
