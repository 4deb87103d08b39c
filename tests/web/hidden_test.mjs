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

export const tests = () => [{ name: "hidden: a hidden tab has no subscriptions and wakes nothing", body: aHiddenPageIsSilent }];
