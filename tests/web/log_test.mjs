import assert from "node:assert/strict";

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

/** The lines that are shown are copied, as they are at that time. */
async function linesAreCopied({ page, open }) {
  await open("log");
  const row = page.locator(".list-rows .row").first();
  await row.waitFor();
  await page.getByRole("button", { name: /^Copy/ }).click();
  const lines = (await page.evaluate(() => navigator.clipboard.readText())).split("\n");
  const shown = await row.locator(".log-text").innerText();
  assert.ok(
    lines.some((line) => line.includes(shown)),
    lines.join("\n"),
  );
}

/** A browser that forbids the clipboard: the page does not say that it copied. */
async function notCopied({ page, open }) {
  await page.addInitScript(() => {
    Object.defineProperty(navigator, "clipboard", {
      value: { writeText: () => Promise.reject(new Error("denied")) },
    });
    document.execCommand = () => false;
  });
  await open("log");
  await page.locator(".list-rows .row").first().waitFor();
  await page.getByRole("button", { name: /^Copy/ }).click();
  await page.getByRole("button", { name: "Not copied" }).waitFor();
}

const clipboard = {
  context: { permissions: ["clipboard-read", "clipboard-write"] },
};

export const tests = () => [
  { name: "log: lines arrive", body: linesArrive },
  { name: "log: lines are copied", body: linesAreCopied, settings: clipboard },
  { name: "log: lines that cannot be copied", body: notCopied },
];
