import assert from "node:assert/strict";

const devices = 10_000;

/** Another component with many devices, for the page alone: their tuples come through the page's own WebSocket. */
async function addDevices(page, count = devices, points = 0) {
  await page.addInitScript(
    ([count, points]) => {
      const Real = window.WebSocket;
      window.WebSocket = class extends Real {
        set onmessage(call) {
          super.onmessage = (event) => {
            call(event);
            const frame = JSON.parse(event.data);
            if (frame.error?.code === "busy") window.busy = (window.busy ?? 0) + 1;
            if (frame.ok && frame.subscription && this.wanted?.get(frame.id)) this.wanted.get(frame.id)(frame.subscription, call);
          };
        }
        send(text) {
          const request = JSON.parse(text);
          this.wanted ??= new Map();
          window.patterns = [...(window.patterns ?? []), request.pattern];
          const leaf = /^\*:\*\.(?:\*\.\*\.(description|status)|(island))$/
            .exec(request.pattern ?? "")
            ?.slice(1)
            .find(Boolean);
          if (request.do === "subscribe" && leaf) this.wanted.set(request.id, (number, call) => deliver(number, leaf, call));
          super.send(text);
        }
      };
      function deliver(number, leaf, call) {
        if (leaf === "island") {
          const set = [[1_000_000, '{"id":7,"name":"big"}', 1, 1]];
          call({ data: JSON.stringify({ s: number, k: { 1_000_000: "7:proxy.island" }, set }) });
          return;
        }
        const keys = {};
        const set = [];
        const sensors = Array.from({ length: points }, (_, one) => `temperature-${one}`);
        for (let index = 0; index < count; index++) {
          keys[1_000_000 + index] = `7:proxy.big.${index}.${leaf}`;
          set.push([
            1_000_000 + index,
            leaf === "status"
              ? '{"status":"reachable","since":1}'
              : JSON.stringify({ name: `Device ${index}`, capabilities: [index % 1000 ? "temperature" : "smoke"], sensors }),
            1,
            1,
          ]);
        }
        call({ data: JSON.stringify({ s: number, k: keys, set }) });
        if (leaf === "status") window.changeStatus = () => call({ data: JSON.stringify({ s: number, set: set.slice(0, 1) }) });
      }
    },
    [count, points],
  );
}

async function rowsIn(page) {
  return page.locator(".list-rows > [role=row]").count();
}

async function onlyVisibleRowsExist({ page, open }) {
  await addDevices(page);
  await open("devices");
  const list = page.locator(".list");
  await page.waitForFunction((count) => Number(document.querySelector(".list")?.getAttribute("aria-rowcount")) > count, devices);
  const room = Math.ceil((await list.evaluate((element) => element.clientHeight)) / 30) + 1 + 16;
  assert.ok((await rowsIn(page)) <= room, `${await rowsIn(page)} rows, room for ${room}`);
  await list.evaluate((element) => (element.scrollTop = 5000 * 30));
  await page.locator('[aria-rowindex="5010"]').waitFor();
  assert.ok((await rowsIn(page)) <= room);
  await list.focus();
  await page.keyboard.press("End");
  const last = await list.getAttribute("aria-rowcount");
  await page.locator(`.row.active[aria-rowindex="${last}"]`).waitFor();
  assert.ok((await rowsIn(page)) <= room);
}

/** Scrolls by five rows a frame, with a change of a device in each. */
function scrollWithChanges(page, frames) {
  return page.evaluate(
    (frames) =>
      new Promise((done) => {
        const list = document.querySelector(".list");
        const step = () => {
          if (frames-- === 0) return done();
          list.scrollTop += 5 * 30;
          window.changeStatus();
          requestAnimationFrame(step);
        };
        requestAnimationFrame(step);
      }),
    frames,
  );
}

/** Rows that are left behind when what was on its way in the browser is done: at most as many as `few`, else what the last of ten counts says. */
async function rowsLeftBehind(page, few) {
  for (let more = 9; ; more--) {
    const count = await countLeftBehind(page);
    if (count <= few || more === 0) return count;
    await page.waitForTimeout(200);
  }
}

/** Rows that are in memory, but no more in the document, after a collection of garbage. */
async function countLeftBehind(page) {
  const session = await page.context().newCDPSession(page);
  const { result } = await session.send("Runtime.evaluate", { expression: "HTMLDivElement.prototype" });
  const { objects } = await session.send("Runtime.queryObjects", { prototypeObjectId: result.objectId });
  const counted = await session.send("Runtime.callFunctionOn", {
    objectId: objects.objectId,
    functionDeclaration: 'function () { return this.filter((one) => !one.isConnected && one.matches(".row")).length; }',
    returnByValue: true,
  });
  await session.detach();
  return counted.result.value;
}

/** What still holds a row of before must not hold, by its handlers, those that were drawn with it, and so on. */
async function rowsThatLeftAreGivenUp({ page, open }) {
  await addDevices(page);
  await open("devices?q=Device");
  const listed = () =>
    page.waitForFunction((count) => Number(document.querySelector(".list")?.getAttribute("aria-rowcount")) > count, devices);
  await listed();
  const window = await rowsIn(page);
  await scrollWithChanges(page, 60);
  const first = await rowsLeftBehind(page, 2 * window);
  assert.ok(first <= 2 * window, `${first} rows are held, of ${window} in the document`);
  // The second time, the first call of the list draws rows already.
  await page.keyboard.press("g");
  await page.keyboard.press("n");
  await page.getByRole("grid", { name: "Networks" }).waitFor();
  await page.keyboard.press("g");
  await page.keyboard.press("d");
  await listed();
  await scrollWithChanges(page, 60);
  const second = await rowsLeftBehind(page, 2 * window);
  assert.ok(second <= 2 * window, `${second} rows are held, of ${window} in the document`);
}

/** Each pause in a large list asks for the rows that are shown then; those of before are given back. */
async function scrollingHasSubscriptionsForAllRows({ page, open }) {
  await addDevices(page);
  await open("devices?q=Device");
  await page.waitForFunction((count) => Number(document.querySelector(".list")?.getAttribute("aria-rowcount")) > count, devices);
  await page.locator(".list").focus();
  for (let pages = 0; pages < 6; pages++) {
    await page.keyboard.press("PageDown");
    await page.waitForFunction(() => {
      const name = document.querySelector(".row.active")?.textContent.match(/Device (\d+)/)?.[1];
      return name !== undefined && window.patterns.includes(`7:proxy.big.${name}.*.*.*`);
    });
  }
  assert.equal(await page.evaluate(() => window.busy ?? 0), 0);
}

/** A connection has too few tuples for all their values. */
async function veryManyDevicesHaveValuesWhereTheyAreShown({ page, open }) {
  const count = 25_000;
  await addDevices(page, count, 10);
  await open("devices?sort=-quality&quality=bad");
  await page.getByText(/^There are too many points to know all/).waitFor();
  await page.waitForFunction((count) => Number(document.querySelector(".list")?.getAttribute("aria-rowcount")) > count, count);
  await page.waitForFunction(() => window.patterns.some((one) => /^\d+:proxy\.[\w-]+\.[\w-]+\.\*\.\*\.\*$/.test(one)));
  assert.equal(await page.getByRole("combobox", { name: "Quality" }).count(), 0);
  await page.getByRole("combobox", { name: "Type", exact: true }).selectOption("smoke");
  await page.waitForFunction(() => {
    const rows = Number(document.querySelector(".list")?.getAttribute("aria-rowcount"));
    return rows >= 25 && rows < 100;
  });
  await open("overview");
  await page.getByText(/each room has its values on its own page/).waitFor();
  const asked = await page.evaluate(() => window.patterns.filter((one) => one?.endsWith(":*.*.*.*.*.value")));
  assert.deepEqual(asked, []);
}

/** The tree of a large island opens without a subscription to all of it. */
async function aLargeTreeIsAskedByBranch({ page, open }) {
  await addDevices(page);
  await open("tuples");
  const branch = (name) =>
    page
      .locator("[role=treeitem]", {
        has: page.locator(".part", { hasText: name }),
      })
      .first();
  await branch(/^7/).locator(".count").waitFor();
  await branch(/^7/).click();
  await branch(/^proxy$/).click();
  await branch(/^big$/).click();
  await branch(/^3$/).click();
  await page.waitForFunction(() => window.patterns.includes("7:proxy.big.3.**"));
  await page.getByRole("searchbox").fill("Device 77");
  await page.getByText(/^Of islands with more than/).waitFor();
  await page.locator("[role=option]", { hasText: "proxy.big.77." }).first().waitFor();
  assert.ok(!(await page.evaluate(() => window.patterns.includes("7:**"))));
}

/** Changes of the document come in at most one batch an animation frame, beside those of the ages once a second. */
async function oneRedrawAFrame({ page, open }) {
  await open("devices/6541/dummy-rooms/living");
  await page.getByRole("switch", { name: "Passive" }).click();
  const { batches, frames, ages } = await page.evaluate(
    () =>
      new Promise((done) => {
        let batches = 0;
        let frames = 0;
        const begun = performance.now();
        const observer = new MutationObserver(() => batches++);
        observer.observe(document.querySelector(".list"), { subtree: true, childList: true, characterData: true, attributes: true });
        const step = () => {
          if (++frames < 120) return requestAnimationFrame(step);
          observer.disconnect();
          done({ batches, frames, ages: Math.ceil((performance.now() - begun) / 1000) + 1 });
        };
        requestAnimationFrame(step);
      }),
  );
  assert.ok(batches <= frames + ages, `${batches} batches in ${frames} frames`);
}

/** Many sets of one tuple are merged on their way to a page that shows it, but the last one arrives. */
async function theLastValueArrives({ page, open }) {
  const last = 39;
  const values = [];
  page.on("websocket", (socket) =>
    socket.on("framereceived", ({ payload }) => {
      for (const [, value] of JSON.parse(payload).set ?? []) if (/^value-/.test(value)) values.push(value);
    }),
  );
  await open("tuples/6541:house.motto");
  const content = page.locator(".panel .content");
  await content.waitFor();
  assert.doesNotMatch(await content.textContent(), /^value-/);
  const answers = await page.evaluate(
    (last) =>
      new Promise((done) => {
        const socket = new WebSocket(`ws://${location.host}/api/v1/ws`);
        const answers = [];
        socket.onopen = () => {
          for (let id = 0; id <= last; id++)
            socket.send(JSON.stringify({ id: id + 1, do: "set", key: "6541:house.motto", value: `value-${id}` }));
        };
        socket.onmessage = ({ data }) => {
          const { id, ok } = JSON.parse(data);
          if (id === undefined) return;
          answers.push(ok);
          if (id > last) done(answers);
        };
      }),
    last,
  );
  assert.equal(answers.filter(Boolean).length, last + 1);
  await page.locator(".panel .content", { hasText: new RegExp(`^value-${last}$`) }).waitFor();
  assert.ok(new Set(values).size <= last, `${new Set(values).size} values arrived: none was merged`);
}

export const tests = () => [
  { name: "rows: of ten thousand devices only the visible ones are in the document", body: onlyVisibleRowsExist },
  { name: "rows: those that left the list are given up", body: rowsThatLeftAreGivenUp },
  {
    name: "rows: scrolling a large list on a large screen",
    settings: { context: { viewport: { width: 3840, height: 2160 } } },
    body: scrollingHasSubscriptionsForAllRows,
  },
  { name: "rows: the tree of a large island", body: aLargeTreeIsAskedByBranch },
  { name: "rows: very many devices", body: veryManyDevicesHaveValuesWhereTheyAreShown },
  { name: "rows: one redraw an animation frame", body: oneRedrawAFrame },
  { name: "rows: the last of many values arrives", body: theLastValueArrives },
];
