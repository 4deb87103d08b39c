import assert from "node:assert/strict";
import { settled, viewsOf } from "./browser.mjs";

const more = ["devices/6541/dummy-rooms/living", "tuples/6541:house.motto"];

/** What goes beyond the right edge and cannot be scrolled to. */
function beyondTheEdge() {
  const scrolls = (element) =>
    element &&
    (/auto|scroll|hidden/.test(getComputedStyle(element).overflowX) ||
      scrolls(element.parentElement));
  return [...document.querySelectorAll("body *")]
    .filter(
      (element) =>
        element.getBoundingClientRect().right > innerWidth + 1 &&
        element.getClientRects().length > 0,
    )
    .filter(
      (element) =>
        !scrolls(element.parentElement) && !element.closest(".spoken"),
    )
    .map((element) => element.outerHTML.slice(0, 120));
}

/** Touch targets that are smaller than 44 pixels in both directions. */
function smallTargets() {
  return [...document.querySelectorAll("button, select, input, nav a")]
    .filter(
      (element) =>
        element.getClientRects().length > 0 &&
        element.type !== "checkbox" &&
        element.type !== "range" &&
        !element.closest(".skip"),
    )
    .map((element) => ({
      box: element.getBoundingClientRect(),
      html: element.outerHTML.slice(0, 120),
    }))
    .filter(({ box }) => box.height < 43.5 && box.bottom > 0)
    .map(({ html }) => html);
}

async function fits({ page, open, picture }) {
  await open("overview");
  const views = (await viewsOf(page)).map(({ id }) => id);
  for (const address of [...views, ...more]) {
    await open(address);
    await settled(page);
    await picture(`narrow-${address.replace(/\W+/g, "-")}`);
    assert.equal(
      await page.evaluate(() => document.scrollingElement.scrollWidth),
      320,
      address,
    );
    assert.deepEqual(await page.evaluate(beyondTheEdge), [], address);
    assert.deepEqual(await page.evaluate(smallTargets), [], address);
  }
}

export const tests = () => [
  {
    name: "narrow: every view fits into 320 pixels, targets are 44",
    settings: {
      context: {
        viewport: { width: 320, height: 640 },
        hasTouch: true,
        isMobile: true,
      },
    },
    body: fits,
  },
];
