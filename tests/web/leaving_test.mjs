// Decisions about many devices that a user makes just before the page is left.
import assert from "node:assert/strict";

/** So many devices of an island 7 wait, for the page alone: their tuples come through the page's own WebSocket. */
async function addWaiting(page, devices) {
  await page.addInitScript((count) => {
    const Real = window.WebSocket;
    const wanted = new Map();
    const island = () => [["7:proxy.island", '{"id":7,"name":"big"}']];
    const waiting = () => Array.from({ length: count }, (_, index) => [`7:proxy.inbox.big.${index}`, '{"reason":"new"}']);
    const sent = { "*:*.island": island, "*:*.inbox.*.*": waiting };
    const first = 1_000_000; // no key of the server has such a number
    function deliver(number, tuples, call) {
      const k = Object.fromEntries(tuples.map(([key], index) => [first + index, key]));
      call({ data: JSON.stringify({ s: number, k, set: tuples.map(([, value], index) => [first + index, value, 1, 1]) }) });
    }
    window.WebSocket = class extends Real {
      set onmessage(call) {
        super.onmessage = (event) => {
          call(event);
          const frame = JSON.parse(event.data);
          if (frame.ok && frame.subscription && wanted.has(frame.id)) deliver(frame.subscription, wanted.get(frame.id)(), call);
        };
      }
      send(text) {
        const { id, pattern } = JSON.parse(text);
        if (sent[pattern]) wanted.set(id, sent[pattern]);
        super.send(text);
      }
    };
  }, devices);
}

async function approveAll(page, open) {
  await open("inbox?q=big");
  await page.locator(".list-rows .row").first().waitFor();
  await page.getByRole("button", { name: /^Select all/ }).click();
  await page.getByRole("button", { name: /^Approve \d/ }).click();
  await page.locator(".pending-decision").waitFor();
}

/** All that was decided goes with the page, as many names as requests that outlive it may carry. */
async function manyDecisionsLeave({ page, open }) {
  const devices = 4000;
  await addWaiting(page, devices);
  const names = [];
  page.on("request", (request) => {
    if (/\/api\/v1\/inbox$/.test(request.url())) names.push(...(request.postDataJSON().approve ?? []));
  });
  await approveAll(page, open);
  await page.evaluate(() => {
    const real = window.fetch;
    window.fetch = (path, init) => {
      if (path.endsWith("/inbox") && !init.keepalive) throw new Error("this request ends with the page");
      return real(path, init);
    };
  });
  await page.goto("about:blank");
  while (names.length < devices) await page.waitForTimeout(50);
  assert.equal(new Set(names).size, devices);
}

/** The browser asks before the page is left with more than that. */
async function tooManyAreAskedFor({ page, open, faults }) {
  await addWaiting(page, 10_000);
  await approveAll(page, open);
  await page.goto("about:blank").catch(() => {});
  assert.match(page.url(), /#\/inbox/);
  await page.locator(".pending-decision").waitFor();
  assert.deepEqual(faults.splice(0), ["a dialog: "]);
  await page.locator(".pending-decision").getByRole("button", { name: "Undo" }).click();
  await page.locator(".pending-decision").waitFor({ state: "detached" });
  await page.goto("about:blank");
  assert.equal(page.url(), "about:blank");
}

export const tests = () => [
  { name: "leaving: thousands of decisions leave with the page", body: manyDecisionsLeave },
  { name: "leaving: more than can leave with the page", body: tooManyAreAskedFor },
];
