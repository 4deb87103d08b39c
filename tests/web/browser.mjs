// Chromium, and pages in it that watch for what must not happen.
import { createRequire } from "node:module";
import { join } from "node:path";

const program = "/usr/bin/chromium-headless-shell";
const flags = ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking"];

export async function openBrowser(root, screens) {
  const require = createRequire(join(root, "web/package.json"));
  const { chromium } = require("playwright-core");
  const axe = require.resolve("axe-core/axe.min.js");
  const browser = await chromium.launch({ executablePath: program, args: flags });
  return {
    axe,
    close: () => browser.close(),
    runs: () => browser.isConnected(),
    session: (island, settings) => openPage(browser, island, settings, screens),
  };
}

/** A page of the island. `faults` collects errors, messages of the console and dialogs. */
async function openPage(browser, island, settings, screens) {
  const context = await browser.newContext({
    viewport: { width: 1280, height: 800 },
    bypassCSP: settings.axe ?? false,
    ...settings.context,
  });
  const page = await context.newPage();
  page.setDefaultTimeout(Number(process.env.T ?? 20_000));
  const faults = [];
  page.on("pageerror", (error) => faults.push(error.stack));
  page.on("dialog", (dialog) => {
    faults.push(`a dialog: ${dialog.message()}`);
    void dialog.dismiss();
  });
  page.on("console", (message) => {
    if (message.type() === "error" && !settings.lines) faults.push(`console: ${message.text()}`);
  });
  return {
    context,
    page,
    faults,
    /** Opens an address of the page and waits until the connection is up. */
    async open(hash) {
      await page.goto(`${island.url}#/${hash}`);
      await page.locator(".line.tone-good").waitFor({ state: "attached" });
    },
    picture: (name) => page.screenshot({ path: join(screens, `${name}.png`) }),
  };
}

/** Waits until nothing is on its way any more. */
export async function settled(page) {
  await page.waitForFunction(() => !document.querySelector(".skeleton"));
}

/** Goes on by Tab until what has this name has the focus. */
export async function tabTo(page, name) {
  for (let step = 0; step < 60; step++) {
    await page.keyboard.press("Tab");
    const at = await page.evaluate(() => {
      const { ariaLabel, placeholder, textContent } = document.activeElement;
      return ariaLabel ?? (placeholder || textContent.trim());
    });
    if (at === name) return;
  }
  throw new Error(`${name} is not reached`);
}

/** The views of the rail, as they are; those that a narrow screen keeps behind `More`, too. */
export async function viewsOf(page) {
  const more = page.locator("nav.rail > button");
  if ((await more.count()) > 0) await more.click();
  return page.locator("nav.rail a").evaluateAll((links) =>
    links.map((link) => ({
      id: link.getAttribute("href").replace(/^#\//, "").split("?")[0],
      title: link.querySelector("span").textContent,
    })),
  );
}
