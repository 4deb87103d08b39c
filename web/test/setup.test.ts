import assert from "node:assert/strict";
import { test } from "node:test";
import dummy from "../../src/networks/dummy/sample.yaml";
import knx from "../../src/networks/knx/sample.yaml";
import log from "../../src/networks/log/sample.yaml";
import salad from "../../src/networks/salad/sample.yaml";
import wsn from "../../src/networks/wsn/sample.yaml";
import zigbee from "../../src/networks/zigbee/sample.yaml";
import { chosen, type ImportPoint, isUncertain, withChoices } from "../src/core/knx_import";
import { optionsText, readSample, scalar } from "../src/core/sample";

const samples = { dummy, knx, log, salad, wsn, zigbee };

test("the sample of a type becomes fields, with what it says of each", () => {
  const { fields, blocks } = readSample(knx);
  const of = (key: string) => fields.find((field) => field.key === key);
  assert.deepEqual(of("host"), {
    key: "host",
    value: "192.168.1.10",
    about: "the KNX IP interface or router; `rubicon knx discover` finds it",
    optional: false,
  });
  assert.deepEqual(of("port"), { key: "port", value: "3671", about: "", optional: true });
  assert.equal(of("local-port")?.value, "0");
  assert.equal(of("local-port")?.about, "a fixed UDP port of this host, for firewalls");
  assert.equal(of("secured-groups")?.value, "[1/2/7]");
  assert.equal(of("capture")?.value, "{keep: 10min, size: 1MB}");
  assert.equal(of("type"), undefined);
  assert.match(blocks, /^groups: .*\n {2}1\/0\/1: \{dpt: 1\.001/);
  assert.match(blocks, /\nexpose: /);
});

test("an about that goes on in the next line is one text, and a source in quotes stays quoted", () => {
  const broker = readSample(zigbee).fields.find(({ key }) => key === "broker");
  assert.equal(broker?.value, "localhost:1883");
  assert.match(broker?.about ?? "", /MQTT broker of Zigbee2MQTT with a password and TLS/);
  const source = readSample(wsn).fields.find(({ key }) => key === "source");
  assert.equal(source?.value, '"serial@/dev/ttyUSB0:telosb"');
  assert.equal(readSample(log).fields.find(({ key }) => key === "comment")?.value, '"#"');
});

test("no sample has an option that the form loses", () => {
  for (const [type, text] of Object.entries(samples)) {
    const { fields, blocks } = readSample(text);
    const options = [...text.matchAll(/^ {2}(?:# )?([a-z][\w-]*):(?:\s|$)/gim)].map(([, key]) => key).filter((key) => key !== "type");
    const found = [...fields.map(({ key }) => key), ...[...blocks.matchAll(/^([a-z][\w-]*):/gim)].map(([, key]) => key)];
    assert.deepEqual(found.sort(), options.sort(), type);
    for (const { key, value } of fields) assert.ok(!/ {2}|#(?!")/.test(value), `${type}: ${key}: ${value}`);
  }
});

test("options are written in the order of the fields, empty ones are left out", () => {
  assert.equal(
    optionsText(
      "knx",
      [
        ["via", " tunnel "],
        ["host", ""],
      ],
      "capture:\n  keep: 1min\n\n",
    ),
    "type: knx\nvia: tunnel\ncapture:\n  keep: 1min\n",
  );
});

test("a text is quoted where YAML would read another one", () => {
  assert.deepEqual(["192.168.1.10", "hall.lan:3671", "a b", "x: y", "", "#1", "null"].map(scalar), [
    "192.168.1.10",
    "hall.lan:3671",
    '"a b"',
    '"x: y"',
    '""',
    '"#1"',
    '"null"',
  ]);
});

const point = (address: string, more: Partial<ImportPoint> = {}): ImportPoint => ({
  address,
  state: "",
  name: "",
  room: "",
  dpt: "1.001",
  kind: "actuator",
  point: "p",
  unit: "",
  ...more,
});

test("uncertain are addresses without a whole type, and those that the island says something of", () => {
  assert.deepEqual(
    [point("1/0/1"), point("1/0/2", { dpt: "" }), point("1/0/3", { dpt: "9.*" }), point("1/0/4", { notes: ["by its name"] })].map(
      isUncertain,
    ),
    [false, true, true, true],
  );
});

test("a choice that equals the file is none", () => {
  const some = chosen({}, point("1/0/1"), { kind: "sensor" });
  assert.deepEqual(some, { "1/0/1": { kind: "sensor" } });
  assert.deepEqual(chosen(some, point("1/0/1"), { kind: "actuator" }), {});
  assert.deepEqual(chosen(some, point("1/0/1"), { leave: true }), { "1/0/1": { kind: "sensor", leave: true } });
  assert.deepEqual(chosen({ "1/0/1": { leave: true } }, point("1/0/1"), { leave: undefined }), {});
});

test("what is left out stays as a row, and what was noted stays with it", () => {
  const base = [point("1/0/1", { dpt: "", notes: ["?"] }), point("1/0/2")];
  const now = withChoices(base, [point("1/0/1", { dpt: "9.001", point: "temperature" })]);
  assert.deepEqual(now, [point("1/0/1", { dpt: "9.001", point: "temperature", notes: ["?"] }), point("1/0/2")]);
});
