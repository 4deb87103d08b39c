import assert from "node:assert/strict";

const name = "<img src=x onerror=alert(1)>";

/** What a device calls itself is text wherever it appears. */
async function namesAreText({ page, open }) {
  await open("devices");
  await page.locator(".row", { hasText: name }).waitFor();
  await open("devices/6541/dummy-rooms/evil");
  await page.getByRole("heading", { name }).waitFor();
  await page.getByText("Description and status").click();
  await page.locator(".raw pre", { hasText: name }).waitFor();
  await page.keyboard.press("/");
  await page.keyboard.type("onerror");
  await page.locator("[role=option]", { hasText: name }).waitFor();
  await page.keyboard.press("Escape");
  await open("devices/compare?d=6541/dummy-rooms/evil");
  await page.locator(".row", { hasText: name }).waitFor();
  await open("tuples/6541:proxy.dummy-rooms.evil.description");
  await page.locator(".content", { hasText: name }).waitFor();
  assert.equal(await page.locator("img").count(), 0);
  assert.equal(await page.locator("main b").count(), 0);
}

/** Addresses from elsewhere. */
async function addressesAreText({ page, open }) {
  for (const address of [
    "devices/6541/dummy-rooms/%3Cimg%20src=x%20onerror=alert(1)%3E",
    "devices?q=%3Cscript%3Ealert(1)%3C/script%3E",
    "tuples/%3Cb%3Ex",
    "nosuchview",
    "%E0%A4%A",
    "devices/6541/dummy-rooms/toString",
    "devices?sort=__proto__",
  ]) {
    await open(address);
    await page.locator("main > *").first().waitFor();
    assert.equal(await page.locator("main img, main script").count(), 0, address);
  }
}

export const tests = () => [
  { name: "hostile: a device whose name is markup", body: namesAreText },
  { name: "hostile: addresses with markup and nonsense", body: addressesAreText },
];
