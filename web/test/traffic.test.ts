import assert from "node:assert/strict";
import { test } from "node:test";
import { bytesOf, isGroup, jsonLines, pcapOf, readPassing } from "../src/core/traffic";

test("telegrams and packets become rows, whatever is missing", () => {
  const telegram = readPassing(
    "knx",
    '{"time":5,"service":"write","source":"1.1.4","address":"1/2/7","own":true,"hex":"0c1a","name":"Hall","value":"21.0","unit":"°C"}',
    1,
  );
  assert.deepEqual(telegram && { ...telegram, raw: "" }, {
    id: 1,
    time: 5,
    out: true,
    kind: "write",
    from: "1.1.4",
    to: "1/2/7",
    name: "Hall",
    value: "21.0 °C",
    hex: "0c1a",
    raw: "",
  });
  const packet = readPassing("wsn", '{"time":5,"direction":"out","kind":"sampling","mote":7,"hex":"7e","text":"light"}', 2);
  assert.deepEqual([packet?.out, packet?.from, packet?.to, packet?.value], [true, "", "7", "light"]);
  assert.equal(readPassing("wsn", '{"direction":"in","kind":"config"}', 3)?.from, "");
  const set = readPassing(
    "zigbee",
    '{"time":5,"direction":"out","topic":"living/ceiling/set","bytes":14,"text":"{\\"state\\":\\"ON\\"}"}',
    4,
  );
  assert.deepEqual([set?.out, set?.kind, set?.name, set?.value], [true, "set", "living/ceiling", '{"state":"ON"}']);
  const list = readPassing("zigbee", '{"time":5,"direction":"in","topic":"bridge/devices","bytes":300}', 5);
  assert.deepEqual([list?.out, list?.kind, list?.name, list?.value], [false, "bridge", "devices", "300 bytes"]);
  const state = readPassing("zigbee", '{"time":5,"direction":"in","topic":"living/ceiling","bytes":2,"text":"{}"}', 6);
  assert.deepEqual([state?.kind, state?.name], ["state", "living/ceiling"]);
  assert.equal(readPassing("knx", "no JSON", 4), null);
  assert.equal(readPassing("knx", "3", 5), null);
  assert.equal(jsonLines(packet ? [packet, packet] : []).split("\n").length, 3);
});

test("group addresses of all levels", () => {
  for (const good of ["1/2/7", "31/7/255", "1/2047", "65535"]) assert.ok(isGroup(good), good);
  for (const bad of ["", "0/0/0", "32/0/1", "1/8/1", "1/1/256", "1.1.4", "1/2/3/4", "a/b/c", "1//2"]) assert.ok(!isGroup(bad), bad);
});

test("a capture is a file that Wireshark reads", () => {
  const cemi = "2900bce011040a070300800c1a";
  const file = pcapOf([{ time: 1795369403_500_000_000, out: false, cemi }]);
  const view = new DataView(file.buffer);
  assert.equal(view.getUint32(0, true), 0xa1b2c3d4);
  assert.equal(view.getUint32(24, true), 1795369403);
  assert.equal(view.getUint32(28, true), 500_000);
  const length = view.getUint32(32, true);
  assert.equal(length, 34 + cemi.length / 2);
  assert.equal(file.length, 24 + 16 + length);
  const packet = new DataView(file.buffer, 40);
  let sum = 0;
  for (let at = 0; at < 20; at += 2) sum += packet.getUint16(at);
  assert.equal((sum & 0xffff) + (sum >>> 16), 0xffff);
  assert.equal(packet.getUint16(30), 0x0530);
  assert.deepEqual([...file.slice(40 + 34)], [...bytesOf(cemi)]);
});
