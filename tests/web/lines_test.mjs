import assert from "node:assert/strict";
import { tabTo } from "./browser.mjs";

/** A line that is not up is on the overview with its reason, until it is up; what waits then is counted there. */
async function aLineComesUp({ page, open, island }) {
  await open("overview");
  const card = page.locator(".card", { hasText: "Needs attention" });
  await card.locator("li", { hasText: "wsn-hall" }).locator("a", { hasText: "19202" }).waitFor();
  island.startMotes();
  await card.locator("li", { hasText: "wsn-hall" }).waitFor({ state: "detached" });
  await page.locator(".card", { hasText: "Inbox" }).getByText("3 devices wait for a decision.").waitFor();
  await page.locator("nav.rail a", { hasText: "Inbox" }).locator(".mark", { hasText: "3" }).waitFor();
}

/** A user who repaired a line need not wait; what came of the attempt is shown until the line is up. */
async function aLineIsReopened({ page, open, island }) {
  await open("networks");
  await page.locator(".list-rows .row", { hasText: "wsn-hall" }).click();
  const panel = page.locator("aside.panel");
  const button = panel.getByRole("button", { name: "Open now" });
  const state = panel.locator(".outcome .state", { hasText: /failed|refused/ });
  do {
    await button.click(); // refused during an attempt of the line itself
    await state.waitFor();
  } while (!/failed/.test(await state.textContent()));
  await panel.locator(".outcome", { hasText: "19202" }).waitFor();
  island.startMotes();
  await panel.locator("header .state", { hasText: "up" }).waitFor();
  assert.equal(await button.count(), 0);
}

/** A decision can be taken back for ten seconds; then the device is listed. */
async function aDeviceIsApproved({ page, open, island }) {
  island.startMotes();
  await open("inbox");
  const mote = page.locator(".list-rows .row").first();
  await mote.getByRole("button", { name: "Approve" }).click();
  await page.locator(".pending-decision").getByRole("button", { name: "Undo" }).click();
  await page.locator(".pending-decision").waitFor({ state: "detached" });
  await mote.getByRole("button", { name: "Approve" }).click();
  await open("devices?network=wsn-hall");
  await page.locator(".list-rows .row").first().waitFor();
  assert.equal(await page.locator(".list-rows .row").count(), 1);
}

/** What a user ignored is listed behind its link, and can be approved there. */
async function anIgnoredDeviceIsApproved({ page, open, island }) {
  island.startMotes();
  await open("inbox");
  const rows = page.locator(".list-rows .row");
  await rows.first().waitFor();
  const before = await rows.count();
  await rows.first().getByRole("button", { name: "Ignore" }).click();
  await page.goto("about:blank");
  await open("inbox");
  await page.getByRole("link", { name: "1 is ignored" }).first().click();
  await page.getByRole("heading", { name: "Ignored devices" }).waitFor();
  await rows.first().getByText("user").waitFor();
  assert.equal(await rows.count(), 1);
  assert.equal(await rows.getByRole("button", { name: "Ignore" }).count(), 0);
  await rows.getByRole("button", { name: "Approve" }).click();
  await page.goto("about:blank");
  await open("inbox/ignored");
  await page.getByText("No device is ignored.").waitFor();
  await page.keyboard.press("Escape");
  await page.getByRole("heading", { name: "Inbox" }).waitFor();
  await rows.nth(before - 2).waitFor();
  assert.equal(await rows.count(), before - 1);
}

/** The page of the traffic with a line that was up and is down, and another one that has not been up yet. */
async function openTwoLines({ page, open, island }) {
  await open("networks");
  island.startMotes();
  const state = page.locator(".row", { hasText: "wsn-hall" }).locator(".state");
  await comesUp(island, "6541/proxy.wsn-hall");
  await state.filter({ hasText: "up" }).waitFor(); // else what the page shows next may be of before
  await island.endOthers();
  await state.filter({ hasText: /down|connecting/ }).waitFor();
  await island.startNeighbour(', wsn-shed: {type: wsn, source: "network@127.0.0.1:19203", board: EM1000}');
  await open("traffic");
  await shows(page, "6541/wsn-hall");
}

const shows = (page, path) => page.waitForFunction((one) => document.querySelector(".toolbar select")?.value === one, path);

const aMoment = () => new Promise((done) => setTimeout(done, 200));

/** The state of a line, or "" where it is not known; `network` = ISLAND/KEY. */
async function lineOf(island, network) {
  const answer = await fetch(`${island.url}api/v1/tuples/${network}.status`, { headers: { accept: "text/plain" } });
  return answer.ok ? JSON.parse(await answer.text()).line : "";
}

/** Until it is up, without the pauses between attempts. */
async function comesUp(island, network) {
  for (let line = ""; line !== "up"; await aMoment()) {
    await fetch(`${island.url}api/v1/tuples/${network}.property.line.command`, { method: "PUT", body: "reopen" });
    line = await lineOf(island, network);
  }
}

/** Of two networks, that whose line comes up first is shown, and remains. */
async function theLineThatIsUpComesFirst({ page, open, island }) {
  await openTwoLines({ page, open, island });
  island.startMotes(19203);
  await comesUp(island, "6542/proxy.wsn-shed");
  await shows(page, "6542/wsn-shed");
  island.startMotes();
  await page.getByRole("button", { name: "Watch" }).first().click();
  await page.locator(".strip", { hasText: "watching wsn-shed" }).waitFor();
  await page.getByRole("button", { name: "Stop" }).first().click();
  await open("traffic?network=6541/wsn-hall");
  await shows(page, "6541/wsn-hall");
}

/** A line that is down can be watched: another one that comes up does not take its place. */
async function aLineThatIsDownIsWatched({ page, open, island }) {
  await openTwoLines({ page, open, island });
  await page.getByRole("button", { name: "Watch" }).first().click();
  await page.locator(".strip", { hasText: "the line of the network is down" }).waitFor();
  island.startMotes(19203);
  await comesUp(island, "6542/proxy.wsn-shed");
  await page.locator('option[value="6542/wsn-shed"]').waitFor({ state: "attached" });
  island.startMotes();
  await comesUp(island, "6541/proxy.wsn-hall");
  await page.locator(".strip", { hasText: "watching wsn-hall" }).waitFor();
  await page.getByRole("button", { name: "Stop" }).first().click();
}

/** What was decided is sent when the page is left, also within the ten seconds. */
async function aDecisionOutlivesThePage({ page, open, island }) {
  island.startMotes();
  await open("inbox");
  await page.locator(".list-rows .row").first().waitFor();
  await page.getByRole("button", { name: /^Select all/ }).click();
  await page.getByRole("button", { name: /^Approve \d/ }).click();
  await page.locator(".pending-decision").waitFor();
  await page.goto("about:blank");
  await open("devices?network=wsn-hall");
  await page.locator(".list-rows .row").nth(1).waitFor();
}

/** A list for which the server has no time is sent again. */
async function aBusyServerIsAskedAgain({ page, open, island, faults }) {
  island.startMotes();
  await open("devices?network=wsn-hall");
  const rows = page.locator(".list-rows .row");
  await rows.nth(1).waitFor();
  await page.evaluate(async () => {
    const { devices } = await (await fetch("/api/v1/devices?network=wsn-hall")).json();
    const ignore = devices.map(({ address }) => `wsn-hall.${address}`);
    await fetch("/api/v1/inbox", { method: "POST", body: JSON.stringify({ ignore, island: 6541 }) });
  });
  let asked = 0;
  const body = JSON.stringify({ error: { code: "busy", text: "more than 50 commands in a second" } });
  await page.route("**/api/v1/inbox", (route) => {
    if (route.request().method() !== "POST" || asked++ > 0) return route.continue();
    return route.fulfill({ status: 429, contentType: "application/json", body });
  });
  await open("inbox/ignored");
  await rows.nth(1).waitFor();
  await page.getByRole("button", { name: /^Select all/ }).click();
  await page.getByRole("button", { name: /^Approve \d/ }).click();
  await page.getByText("No device is ignored.").waitFor();
  assert.equal(asked, 2);
  assert.match(faults.splice(0).join("\n"), /^console: [^\n]* 429 [^\n]*$/); // Chromium reports the answer
}

/** The packets of the motes are shown while a page asks for them. Motes send when they begin: the page watches before. */
async function packetsAreShown({ page, open, island }) {
  island.startMotes();
  await open("traffic");
  await page.getByRole("button", { name: "Watch" }).first().waitFor();
  await island.endOthers();
  await page.getByRole("button", { name: "Watch" }).first().click();
  await page.locator(".strip", { hasText: "the line of the network is down" }).waitFor();
  island.startMotes();
  await page.locator(".list-rows .row").first().waitFor();
  await page.goto(page.url().replace("#/traffic", "#/overview"));
  await page.getByRole("heading", { name: "Overview" }).waitFor();
  await page.goBack();
  await page.getByRole("button", { name: "Stop" }).first().waitFor();
  await page.locator(".list-rows .row").first().waitFor(); // what passed is still there
  await page.getByRole("button", { name: "Stop" }).first().click();
}

/** Traffic is watched and left by keys: by its own key, and by its button. */
async function trafficByKeys({ page, open, island }) {
  island.startMotes();
  await open("overview");
  for (const key of ["g", "m"]) await page.keyboard.press(key);
  const button = (name) => page.locator(".toolbar").getByRole("button", { name, exact: true });
  const watching = page.locator(".strip", { hasText: "watching wsn-hall" });
  await button("Watch").waitFor();
  await page.keyboard.press("w");
  await watching.waitFor();
  await page.keyboard.press("w");
  await watching.waitFor({ state: "detached" });
  await tabTo(page, "Watch");
  await page.keyboard.press("Enter");
  await watching.waitFor();
  await page.locator(".toolbar button:focus", { hasText: "Stop" }).waitFor();
  await page.keyboard.press("Enter");
  await watching.waitFor({ state: "detached" });
  await button("Watch").waitFor();
}

export const tests = () => [
  { name: "traffic: by keys", body: trafficByKeys },
  { name: "lines: one is down and comes up", body: aLineComesUp },
  { name: "lines: one is opened by a user", body: aLineIsReopened },
  { name: "inbox: a decision, taken back and made", body: aDeviceIsApproved },
  { name: "traffic: packets of motes", body: packetsAreShown },
  { name: "traffic: the line that is up comes first", body: theLineThatIsUpComesFirst },
  { name: "traffic: a line that is down is watched", body: aLineThatIsDownIsWatched },
  { name: "inbox: an ignored device is approved", body: anIgnoredDeviceIsApproved },
  { name: "inbox: a decision outlives the page", body: aDecisionOutlivesThePage },
  { name: "inbox: a busy server is asked again", body: aBusyServerIsAskedAgain },
];
