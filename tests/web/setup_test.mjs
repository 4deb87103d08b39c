import assert from "node:assert/strict";
import { readFile, readdir, writeFile } from "node:fs/promises";
import { deflateRawSync } from "node:zlib";
import { join } from "node:path";
import { findingsOf } from "./accessible_test.mjs";
import { tabTo } from "./browser.mjs";
import { beyondTheEdge, smallTargets } from "./narrow_test.mjs";

const csv = [
  '"Group name";"Address";"Central";"Unfiltered";"Description";"DatapointType";"Security"',
  '"Light";"1/-/-";"";"";"";"";"Auto"',
  '"Hall";"1/0/-";"";"";"";"";"Auto"',
  '"Ceiling switch";"1/0/1";"";"";"";"DPST-1-1";"Auto"',
  '"Ceiling status";"1/0/2";"";"";"";"DPST-1-1";"Auto"',
  '"Outside";"1/0/3";"";"";"";"DPT-9";"Auto"',
  '"<img src=x onerror=alert(1)>";"1/0/4";"";"";"";"";"Auto"',
  '"Spare";"1/0/5";"";"";"";"DPST-1-1";"Auto"',
  '"Beyond";"99/0/4";"";"";"";"";"Auto"',
].join("\n");

const upload = (name, content = csv) => ({ name, mimeType: "application/octet-stream", buffer: Buffer.from(content) });

/** A zip archive with one entry; a project as far as its name goes. */
function zipOf(name, content) {
  const packed = deflateRawSync(content, { level: 9 });
  const crc = crcOf(content);
  const head = Buffer.alloc(26);
  head.writeUInt16LE(20, 0);
  head.writeUInt16LE(8, 4);
  head.writeUInt32LE(crc, 10);
  head.writeUInt32LE(packed.length, 14);
  head.writeUInt32LE(content.length, 18);
  head.writeUInt16LE(name.length, 22);
  const local = Buffer.concat([Buffer.from("PK\x03\x04"), head, Buffer.from(name), packed]);
  const central = Buffer.concat([Buffer.from("PK\x01\x02"), Buffer.from([20, 0]), head, Buffer.alloc(14), Buffer.from(name)]);
  const end = Buffer.alloc(18);
  end.writeUInt16LE(1, 4);
  end.writeUInt16LE(1, 6);
  end.writeUInt32LE(central.length, 8);
  end.writeUInt32LE(local.length, 12);
  return Buffer.concat([local, central, Buffer.from("PK\x05\x06"), end]);
}

function crcOf(bytes) {
  let crc = -1;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit++) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

const rowOf = (page, address) => page.locator(".row", { has: page.getByLabel(`Import ${address}`) });

async function fillIn(page, id, host = "127.0.0.1") {
  await page.getByLabel("Its id").fill(id);
  await page.getByLabel("Address of the KNX interface").fill(host);
}

/** A project becomes a network: what each address becomes, choices, the patch, the reload, and back. */
async function anImport({ page, island, picture }) {
  const { url } = await island.startHouse();
  const file = join(island.folder, "house.yaml");
  const before = await readFile(file, "utf8");
  await page.goto(`${url}#/networks`);
  await page.getByRole("link", { name: "Import KNX …" }).click();
  await page.getByLabel("Project or export of ETS").setInputFiles(upload("flat.csv"));
  await fillIn(page, "knx-hall");
  await page.getByRole("button", { name: "Show what it becomes" }).click();
  await page.getByText("1 error: not imported").waitFor();
  await page.getByText("1 finding").click();
  await page.getByText("line 9:").waitFor();
  assert.match(await rowOf(page, "1/0/1").innerText(), /state 1\/0\/2[\s\S]*1_0_1\.actuator\.switch-1/);
  assert.match(await rowOf(page, "1/0/4").innerText(), /<img src=x[\s\S]*bytesInput-1/);
  await page.getByLabel("Only the 3 uncertain").check();
  await rowOf(page, "1/0/5").waitFor({ state: "detached" });
  await page.getByLabel("Type of 1/0/3").fill("9.001");
  await page.keyboard.press("Tab");
  await rowOf(page, "1/0/3").getByText("1_0_3.sensor.temperature-1 °C").waitFor();
  await page.getByLabel("Type of 1/0/4").fill("77.1");
  await page.keyboard.press("Tab");
  await page.getByRole("alert").getByText("there is no data point type '77.1'").waitFor();
  assert.equal(await page.getByLabel("Type of 1/0/4").inputValue(), "77.1");
  await page.getByLabel("Type of 1/0/4").fill("1.001");
  await page.keyboard.press("Tab");
  await page.getByLabel("Kind of 1/0/4").selectOption("actuator");
  await rowOf(page, "1/0/4").getByText("1_0_4.actuator.switch-1").waitFor();
  await page.getByLabel("Only the 3 uncertain").uncheck();
  await page.getByLabel("Import 1/0/5").uncheck();
  await rowOf(page, "1/0/5").getByText("left out").waitFor();
  await picture("knx-import");
  await page.getByRole("button", { name: "Check …" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByText("network knx-hall: is added").waitFor();
  assert.match(await dialog.locator("pre").innerText(), /knx-hall:\n {4}import: knx-hall\.groups\.yaml\n {4}type: knx/);
  await picture("knx-import-check");
  assert.equal(await readFile(file, "utf8"), before);
  await dialog.getByRole("button", { name: "Write house.yaml and reload" }).click();
  await page.locator(".row", { hasText: "knx-hall" }).waitFor();
  const groups = await readFile(join(island.folder, "knx-hall.groups.yaml"), "utf8");
  assert.match(groups, /1\/0\/3: \{dpt: 9\.001/);
  assert.match(groups, /1\/0\/4: \{dpt: 1\.001, kind: actuator/);
  assert.doesNotMatch(groups, /1\/0\/5/);
  assert.ok((await readFile(file, "utf8")).startsWith(before), "what was there stays as it was");
  assert.equal(await readFile(`${file}.previous`, "utf8"), before);
  // Again, into the network that is there.
  await page.getByRole("link", { name: "Import KNX …" }).click();
  await page.getByLabel("Into").selectOption("knx-hall");
  await page.getByLabel("Project or export of ETS").setInputFiles(upload("newer.csv", csv.replace("Outside", "Roof")));
  await page.getByRole("button", { name: "Show what it becomes" }).click();
  await page.getByText("Ids, types and kinds of the group file that the network has are kept.").waitFor();
  assert.equal(await page.getByLabel("Type of 1/0/3").inputValue(), "9.001");
  await page.getByRole("button", { name: "Check …" }).click();
  await dialog.getByRole("button", { name: "Write house.yaml and reload" }).click();
  await page.getByText("The addresses are there.").first().waitFor();
  assert.match(await readFile(file, "utf8"), /import: knx-hall\.groups-2\.yaml/);
  await page.locator(".notice", { hasText: "The addresses are there." }).getByRole("button", { name: "Undo" }).click();
  await page.getByText("The previous file is in force again.").first().waitFor();
  assert.match(await readFile(file, "utf8"), /import: knx-hall\.groups\.yaml/);
}

/** Each bad file has its own reason, and the page stays usable. */
async function badFiles({ page, island }) {
  const { url } = await island.startHouse();
  await page.goto(`${url}#/networks/import`);
  const field = page.getByLabel("Project or export of ETS");
  await fillIn(page, "knx");
  const refused = async (file, why) => {
    await field.setInputFiles(file);
    await page.getByRole("button", { name: "Show what it becomes" }).click();
    await page.getByRole("alert").getByText(why).first().waitFor();
  };
  await refused(upload("accounts.csv", "Date;Amount;Text\n2026-01-01;12.50;Bread\n"), "accounts.csv");
  await refused(upload("photo.csv", "\x89PNG\r\n\x1a\n\0\0"), "photo.csv");
  await refused(upload("bomb.knxproj", zipOf("P-0001/0.xml", Buffer.alloc(48 << 20, 32))), "bomb.knxproj");
  await refused(upload("cut.knxproj", Buffer.from("PK\x03\x04 and no more")), "cut.knxproj");
  const huge = join(island.folder, "huge.csv");
  await writeFile(huge, Buffer.alloc((32 << 20) + 1, 65));
  await refused(huge, "The file has 33 MB, more than 32");
  await page.getByLabel("Password of the project").waitFor({ state: "detached" });
  const address = (index) => `${index >> 11}/${(index >> 8) & 7}/${index & 255}`;
  const many = Array.from({ length: 5000 }, (_, index) => `"${"ä".repeat(100)}";"${address(index + 1)}";"";"";"";"DPST-1-1";"Auto"`);
  await field.setInputFiles(upload("many.csv", [csv.split("\n")[0], ...many].join("\n")));
  await page.getByRole("button", { name: "Show what it becomes" }).click();
  await rowOf(page, "0/0/1").first().waitFor();
  await page.getByRole("button", { name: "Check …" }).click();
  const alert = page.getByRole("alert").filter({ hasText: /The group file has 1\.\d MB, more than the 0\.9 that can be set here/ });
  await alert.locator("code", { hasText: "import: hall.yaml" }).waitFor();
  await field.setInputFiles(upload("flat.csv"));
  await page.getByRole("button", { name: "Show what it becomes" }).click();
  await rowOf(page, "1/0/1").waitFor();
}

/** What the island finds in the new file is said before anything is written. */
async function aForm({ page, island, picture }) {
  const { url } = await island.startHouse();
  const file = join(island.folder, "house.yaml");
  const before = await readFile(file, "utf8");
  await page.goto(`${url}#/networks/add`);
  const dialog = page.getByRole("dialog");
  const check = async (id) => {
    await page.getByLabel("Its id").fill(id);
    await page.getByRole("button", { name: "Check …" }).click();
  };
  const refused = async (why) => {
    await dialog.getByText(why).waitFor();
    assert.equal(await dialog.getByRole("button", { name: /^Write/ }).count(), 0);
    await dialog.getByRole("button", { name: "Back" }).click();
  };
  await page.getByLabel("Kind of network").selectOption("wsn");
  await page.getByLabel("source").waitFor();
  await page.getByText(/^\d+ more option/).click();
  assert.match(await page.locator(".field", { hasText: "share-clients" }).innerText(), /clients at a time/);
  await picture("add-network");
  await page.getByLabel("Kind of network").selectOption("dummy");
  await check("dummy-house");
  await refused(/has a network dummy-house already/);
  await page.getByLabel("seed").fill("often");
  await check("dummy-lab");
  await refused(/networks\.dummy-lab\.seed/);
  await page.getByLabel("seed").fill("7");
  await page.getByRole("button", { name: "Insert those of the sample" }).click();
  await page.getByLabel("More options, in YAML").fill("simulate:\n  bench: {name: Bench, sensors: {temperature-1: {value: 20}}}\n");
  await writeFile(file, `${before}limits: {queue: 500}\n`);
  await check("dummy-lab");
  await refused(/was changed and is not in force: reload it first/);
  await writeFile(file, before);
  await check("dummy-lab");
  await dialog.getByText("network dummy-lab: is added").waitFor();
  await picture("add-network-check");
  await dialog.getByRole("button", { name: "Write house.yaml and reload" }).click();
  await page.locator(".row", { hasText: "dummy-lab" }).waitFor();
  assert.ok((await readFile(file, "utf8")).startsWith(before));
  await page.goto(`${url}#/settings`);
  await page.getByRole("button", { name: "Previous file …" }).click();
  await dialog.getByText("network dummy-lab: is removed").waitFor();
  await dialog.getByRole("button", { name: "Write house.yaml and reload" }).click();
  await page.getByText("The previous file is in force again.").first().waitFor();
  assert.equal(await readFile(file, "utf8"), before);
}

/** A name that another network has. */
async function takenName({ page, island }) {
  const { url } = await island.startHouse('networks.wsn-motes={type: wsn, source: "network@127.0.0.1:19202", share: "9002"}');
  await page.goto(`${url}#/networks/add`);
  await page.getByLabel("Kind of network").selectOption("wsn");
  await page.getByLabel("source").fill('"network@127.0.0.1:19203"');
  await page.getByLabel("Its id").fill("wsn-motes");
  await page.getByRole("button", { name: "Check …" }).click();
  await page
    .getByRole("dialog")
    .getByText(/the island has a network wsn-motes already/)
    .waitFor();
}

/** Where the file cannot be written, the page says why and gives the patch. */
async function fixedFile({ page, island }) {
  const { url } = await island.startHouse();
  const groupFiles = async () => (await readdir(island.folder)).filter((name) => /groups/.test(name));
  const before = await groupFiles();
  await page.route("**/tuples/*/proxy.settings.status", async (request) => {
    const response = await request.fetch();
    const tuple = await response.json();
    const status = JSON.parse(tuple.value);
    status.file.fixed = "/etc/rubicon: Permission denied";
    await request.fulfill({ response, json: { ...tuple, value: JSON.stringify(status) } });
  });
  await page.goto(`${url}#/networks/import`);
  await page.getByLabel("Project or export of ETS").setInputFiles(upload("flat.csv"));
  await fillIn(page, "knx-hall");
  await page.getByRole("button", { name: "Show what it becomes" }).click();
  await rowOf(page, "1/0/1").waitFor();
  await page.getByRole("button", { name: "Check …" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByText("The island cannot write house.yaml (/etc/rubicon: Permission denied).").waitFor();
  assert.equal(await dialog.getByRole("button", { name: /^Write/ }).count(), 0);
  const saved = page.waitForEvent("download");
  await dialog.getByRole("button", { name: "Save the group file" }).click();
  assert.match((await saved).suggestedFilename(), /^knx-hall\.groups(-\d+)?\.yaml$/);
  assert.deepEqual(await groupFiles(), before);
}

async function onlyAdmins({ page, island }) {
  const { tokens, url } = await island.startGuarded();
  await page.goto(`${url}#/networks`);
  await page.getByLabel("Token").fill(tokens.command);
  await page.getByRole("button", { name: "Log in" }).click();
  await page.locator(".row", { hasText: "dummy-rooms" }).waitFor();
  assert.equal(await page.getByRole("link", { name: "Add a network …" }).count(), 0);
  await page.goto(`${url}#/networks/import`);
  await page.getByText("needs the role admin").waitFor();
}

/** By keys alone, from the list to the file. */
async function byKeys({ page, island }) {
  const { url } = await island.startHouse();
  await page.goto(`${url}#/networks`);
  await page.locator(".row", { hasText: "dummy-house" }).waitFor();
  await tabTo(page, "Add a network …");
  await page.keyboard.press("Enter");
  await page.getByLabel("Its id").waitFor();
  await page.getByLabel("Kind of network").focus();
  await page.keyboard.type("dummy");
  await page.getByLabel("Its id").focus();
  await page.keyboard.type("dummy-keys");
  await page.getByLabel("More options, in YAML").focus();
  await page.keyboard.type("simulate: {one: {name: One}}");
  await tabTo(page, "Check …");
  await page.keyboard.press("Enter");
  await page.getByRole("dialog").getByText("network dummy-keys: is added").waitFor();
  await tabTo(page, "Write house.yaml and reload");
  await page.keyboard.press("Enter");
  await page.locator(".row", { hasText: "dummy-keys" }).waitFor();
}

/** Both views with what they show, for axe and for a narrow screen. */
const inEachSize = (narrow) =>
  async function looks({ page, island, browser, picture }) {
    const { url } = await island.startHouse();
    const axe = await readFile(browser.axe, "utf8");
    const look = async (name) => {
      await picture(`setup-${narrow ? "narrow" : "dark"}-${name}`);
      assert.deepEqual(await findingsOf(page, axe), [], name);
      if (!narrow) return;
      assert.equal(await page.evaluate(() => document.scrollingElement.scrollWidth), 320, name);
      assert.deepEqual(await page.evaluate(beyondTheEdge), [], name);
      assert.deepEqual(await page.evaluate(smallTargets), [], name);
    };
    await page.goto(`${url}#/networks`);
    await page.getByRole("link", { name: "Add a network …" }).click();
    await page.getByLabel("Its id").waitFor();
    await page.getByText(/^\d+ more option/).click();
    await look("form");
    await page.goto(`${url}#/networks/import`);
    await page.getByLabel("Project or export of ETS").setInputFiles(upload("flat.csv"));
    await fillIn(page, "knx-hall");
    await look("upload");
    await page.getByRole("button", { name: "Show what it becomes" }).click();
    await rowOf(page, "1/0/1").waitFor();
    await page.getByText("1 finding").click();
    await look("preview");
    await page.getByRole("button", { name: "Check …" }).click();
    await page.getByRole("dialog").getByText("network knx-hall: is added").waitFor();
    await look("check");
  };

const narrow = { viewport: { width: 320, height: 640 }, hasTouch: true, isMobile: true };

export const tests = () => [
  { name: "setup: a KNX export becomes a network, and back", settings: { lines: true }, body: anImport },
  { name: "setup: bad files have a reason each", settings: { lines: true }, body: badFiles },
  { name: "setup: a network is added by a form, and taken back", settings: { lines: true }, body: aForm },
  { name: "setup: a name that is taken", settings: { lines: true }, body: takenName },
  { name: "setup: a file that cannot be written", body: fixedFile },
  { name: "setup: only for the role admin", settings: { lines: true }, body: onlyAdmins },
  { name: "setup: by keys alone", body: byKeys },
  { name: "setup: axe in the dark", settings: { axe: true, context: { colorScheme: "dark" } }, body: inEachSize(false) },
  { name: "setup: 320 pixels", settings: { axe: true, context: narrow }, body: inEachSize(true) },
];
