import assert from "node:assert/strict";

/** Chromium without a screen never hides a page: the test says so in its place. */
async function hide(page, hidden) {
  await page.evaluate((value) => {
    Object.defineProperty(document, "hidden", { configurable: true, get: () => value });
    document.dispatchEvent(new Event("visibilitychange"));
  }, hidden);
}

async function aHiddenPageIsSilent({ page, open }) {
  const sent = [];
  const received = [];
  page.on("websocket", (socket) => {
    socket.on("framesent", ({ payload }) => sent.push(JSON.parse(payload)));
    socket.on("framereceived", ({ payload }) => received.push(JSON.parse(payload)));
  });
  /** The frames of the server from now on, up to and with the first that `last` accepts. */
  const receivedUntil = async (last) => {
    const start = received.length;
    while (!received.slice(start).some(last)) await page.waitForTimeout(50);
    const frames = received.slice(start);
    return frames.slice(0, frames.findIndex(last) + 1);
  };
  await open("devices/6541/dummy-rooms/living");
  await page.getByRole("switch", { name: "Passive" }).click();
  await page.locator(".row", { hasText: "light-1" }).locator(".quality-good").waitFor();
  const subscribed = sent.filter((frame) => frame.do === "subscribe").length;
  await hide(page, true);
  // The server says that it is alive when it had nothing else to say for five seconds: it sent nothing.
  await receivedUntil((frame) => frame.alive !== undefined);
  assert.equal(sent.filter((frame) => frame.do === "unsubscribe").length, subscribed);
  const before = sent.length;
  await hide(page, false);
  await receivedUntil((frame) => frame.snapshot !== undefined);
  await page.locator('.active-switch[aria-checked="false"]').waitFor();
  const again = sent.slice(before).filter((frame) => frame.do === "subscribe");
  assert.ok(again.length > 0);
  assert.ok(
    again.every((frame) => frame.passive),
    "nothing is woken by itself",
  );
}

/** Without a history, what was plotted is still there when the tab is shown again, and when another point is added. */
async function aPlotKeepsItsCurve({ page, open }) {
  await page.route(/\/api\/v1\/?$/, async (route) => {
    const response = await route.fetch();
    await route.fulfill({ response, json: { ...(await response.json()), history: false } });
  });
  await open("plots?k=6541:proxy.dummy-rooms.living.sensor.light-1");
  const plot = page.getByRole("slider");
  const readingAt = (time) =>
    plot.evaluate(async (element, at) => {
      element.focus();
      const step = async (key) => {
        element.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
        await new Promise(requestAnimationFrame);
      };
      await step("End");
      for (let left = 0; left < 100 && Number(element.getAttribute("aria-valuenow")) > at; left++) await step("ArrowLeft");
      return element.getAttribute("aria-valuetext");
    }, time);
  await page.getByRole("switch", { name: "Passive" }).click();
  await page.locator(".plot-legend td.reading", { hasText: /^[\d.,]+ lx$/ }).waitFor();
  await page.goto(page.url().replace("plots?", "plots?span=20&"));
  const reading = /light-1 [\d.,]+ lx/;
  /** Waits until the curve has a reading at a time; a time of null: at the one 1.5 s ago. */
  const hasReading = async (time) => {
    for (let round = 0; round < 60; round++) {
      const at = time ?? Date.now() / 1000 - 1.5;
      if (reading.test(await readingAt(at))) return at;
      await page.waitForTimeout(500);
    }
    return assert.fail(`no reading at ${time}: ${await readingAt(time)}`);
  };
  await page.waitForTimeout(4000);
  const known = await hasReading(null);
  await hide(page, true);
  await page.waitForTimeout(300);
  await hide(page, false);
  await page.waitForTimeout(1500);
  await hasReading(known);
  await page.goto(page.url().replace("light-1", "light-1,6541:proxy.dummy-rooms.bedroom.sensor.temperature-1"));
  await page.locator(".plot-legend", { hasText: "temperature-1" }).waitFor();
  await page.waitForTimeout(500);
  await hasReading(known);
}

export const tests = () => [
  { name: "hidden: a hidden tab has no subscriptions and wakes nothing", body: aHiddenPageIsSilent },
  { name: "hidden: a plot keeps its curve", body: aPlotKeepsItsCurve },
];
