import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const manual = join(dirname(fileURLToPath(import.meta.url)), "../../docs/api.md");

/** The JavaScript of docs/api.md, as it stands there, shows the values of sensors as they change. */
async function javaScriptShowsValues({ page, open }) {
  const [, code] = /```js\n([^]*?)```/.exec(await readFile(manual, "utf8"));
  const lines = [];
  page.on("console", (message) => lines.push(message.text()));
  await open("devices/6541/dummy-rooms/living"); // watching is passive: this page has its sensor send
  await page.keyboard.press("a");
  await page.getByRole("switch", { name: "Active" }).waitFor();
  const twice = page.waitForEvent("console", {
    predicate: (message) =>
      lines.filter((line) => line.startsWith("6541:proxy.dummy-rooms.living.sensor.light-1.value ")).length > 1 && message,
  });
  await page.evaluate(`(() => {${code}})()`);
  await twice;
  const [key, value] = lines.find((line) => line.includes(".light-1.value")).split(" ");
  assert.equal(key, "6541:proxy.dummy-rooms.living.sensor.light-1.value");
  assert.ok(Number(value) > 0, value);
}

export const tests = () => [{ name: "api: the JavaScript of the manual", body: javaScriptShowsValues }];
