import assert from "node:assert/strict";

const fontSize = (page, selector) =>
  page
    .locator(selector)
    .first()
    .evaluate((element) => Number.parseFloat(getComputedStyle(element).fontSize));

/** Whoever reads with large letters chooses them in the browser. Rows and columns grow with them. */
async function lettersOfTheBrowser({ page, open, context, picture }) {
  const session = await context.newCDPSession(page);
  await session.send("Page.setFontSizes", {
    fontSizes: { standard: 32, fixed: 26 },
  });
  await open("devices");
  const row = page.locator(".row", { hasText: "Hot water tank" });
  await row.waitFor();
  await picture("large-letters-devices");
  assert.equal(await fontSize(page, ":root"), 26);
  const cut = await page
    .locator(".list-rows .cell")
    .evaluateAll((cells) =>
      cells.filter((cell) => cell.scrollHeight > cell.parentElement.clientHeight + 1).map((cell) => cell.textContent),
    );
  assert.deepEqual(cut, []);
  const state = row.locator(".state").first();
  assert.ok(await state.evaluate((element) => element.closest(".cell").scrollWidth <= element.closest(".cell").clientWidth));
}

/** Below 16 pixels, some phones zoom into each field. */
async function fieldsOfPhones({ page, open }) {
  for (const address of ["devices", "devices/6541/dummy-rooms/living", "tuples"]) {
    await open(address);
    await page.locator("main input").first().waitFor();
    const small = await page
      .locator("input, select, textarea")
      .evaluateAll((fields) => fields.filter((field) => Number.parseFloat(getComputedStyle(field).fontSize) < 16).length);
    assert.equal(small, 0, address);
  }
}

export const tests = () => [
  {
    name: "sizes: letters are as large as in the browser",
    body: lettersOfTheBrowser,
  },
  {
    name: "sizes: fields of a phone are read without zoom",
    settings: {
      context: {
        viewport: { width: 390, height: 844 },
        hasTouch: true,
        isMobile: true,
      },
    },
    body: fieldsOfPhones,
  },
];
