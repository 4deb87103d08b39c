import assert from "node:assert/strict";

/** An error in the file is shown with its place, and nothing changes. */
async function anErrorHasItsPlace({ page, open, island }) {
  await open("settings");
  await page.locator(".configuration").waitFor();
  await island.edit((file) => file.replace("silence: 4s", "silence: often"));
  await page.getByRole("button", { name: "Check the file" }).click();
  const fault = page.locator(".faults tbody tr", { hasText: "silence" });
  await fault.waitFor();
  assert.match(await fault.locator("td").first().innerText(), /\d+:\d+/);
  await page.getByRole("button", { name: "Reload …" }).click();
  await page
    .getByText(/^Refused: 1 error/)
    .first()
    .waitFor();
  await island.edit((file) => file.replace("silence: often", "silence: 4s"));
}

/** A reload shows first what it would change. */
async function reloadsWithPreview({ page, open, island }) {
  await open("settings");
  await page.locator(".configuration").waitFor();
  await island.edit((file) => file.replace('area: "<b>Lab</b>"', "area: Cellar"));
  await page.getByRole("button", { name: "Reload …" }).click();
  const preview = page.getByRole("dialog");
  await preview.locator(".changes li", { hasText: "evil" }).waitFor();
  await preview.getByRole("button", { name: "Reload now" }).click();
  await page
    .getByText(/^Reload(ed)?: 1 change/)
    .first()
    .waitFor();
  await open("devices?q=Cellar");
  await page.locator(".row", { hasText: "Cellar" }).waitFor();
}

export const tests = () => [
  { name: "settings: an error has its place, and nothing changes", body: anErrorHasItsPlace },
  { name: "settings: a reload with preview", body: reloadsWithPreview },
];
