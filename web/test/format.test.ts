import assert from "node:assert/strict";
import { test } from "node:test";
import {
  formatAge,
  formatBytes,
  formatFullTime,
  formatNumber,
  formatRate,
  formatTime,
  formatValue,
  hexDump,
  prettyJson,
  typeWords,
  unitSign,
} from "../src/core/format";

test("numbers keep the digits that were sent, in the locale", () => {
  assert.equal(formatNumber("21.50", "en"), "21.50");
  assert.equal(formatNumber("21.50", "de"), "21,50");
  assert.equal(formatNumber("101325.5", "en"), "101,325.5");
  assert.equal(formatNumber("2000", "en"), "2000");
  assert.equal(formatNumber("-3", "en"), "-3");
});

test("what is no plain number is shown as it is", () => {
  for (const value of ["on", "", "1e9", "0x12", "12:30", "1.", " 7", "123456789012345678901", "<b>1</b>", "NaN", "-"])
    assert.equal(formatNumber(value, "en"), value);
});

test("a value is a number only where its point says so, and a leading zero is part of it", () => {
  assert.equal(formatValue("1234567", "integer", "en"), "1,234,567");
  assert.equal(formatValue("21.50", "real", "de"), "21,50");
  assert.equal(formatValue("1234567", "text", "en"), "1234567");
  assert.equal(formatValue("1234567", "", "en"), "1234567");
  for (const type of ["integer", "real", "text", ""]) assert.equal(formatValue("0071", type, "en"), "0071");
  assert.equal(formatValue("0.50", "real", "en"), "0.50");
});

test("ages have one unit", () => {
  const ages: [number, string][] = [
    [-3, "now"],
    [0, "now"],
    [1.4, "now"],
    [12, "12 s"],
    [89, "89 s"],
    [90, "2 min"],
    [5399, "90 min"],
    [5400, "2 h"],
    [86400, "24 h"],
    [129600, "2 d"],
  ];
  for (const [seconds, text] of ages) assert.equal(formatAge(seconds), text);
});

test("times are in the zone, which full times name; other days carry their date", () => {
  const time = Date.UTC(2026, 10, 22, 11, 4, 31, 47) / 1000;
  assert.equal(formatTime(time, time * 1000, "en-GB", "Europe/Stockholm"), "12:04:31");
  assert.equal(formatTime(time, time * 1000 + 86_400_000, "en-GB", "Europe/Stockholm"), "2026-11-22 12:04:31");
  assert.equal(formatFullTime(time, "UTC"), "2026-11-22 11:04:31.047 UTC");
  assert.equal(formatTime(0), "");
  assert.equal(formatFullTime(0), "");
});

test("bytes and rates are short", () => {
  assert.deepEqual([0, 1023, 1024, 1_500_000, 5e9].map(formatBytes), ["0 B", "1023 B", "1.0 KiB", "1.4 MiB", "4.7 GiB"]);
  assert.deepEqual(
    [0, 0.04, 0.25, 9.96, 1234].map((rate) => formatRate(rate, "en")),
    ["0", "0", "0.3", "10", "1,234"],
  );
});

test("units and types are what people write", () => {
  assert.equal(unitSign("Cel"), "°C");
  assert.equal(unitSign("1"), "");
  assert.equal(unitSign("furlong"), "furlong");
  assert.equal(typeWords("colourTemperatureMired"), "colour temperature mired");
});

test("only objects and lists count as JSON", () => {
  assert.equal(prettyJson('{"a":[1]}'), '{\n  "a": [\n    1\n  ]\n}');
  for (const text of ["7", '"a"', "null", "{", "on"]) assert.equal(prettyJson(text), null);
});

test("bytes are dumped 16 a line, with what can be printed, up to a limit", () => {
  const bytes = new Uint8Array([0x00, 0x41, 0x7f, 0xff, ...new Array<number>(16).fill(0x2e)]);
  assert.equal(hexDump(bytes).split("\n").length, 2);
  assert.match(hexDump(bytes), /^000000 {2}00 41 7f ff 2e .* ·A··\.+\n000010 {2}2e 2e 2e 2e +\.\.\.\.$/);
  assert.match(hexDump(new Uint8Array(40), 16), /\n… 24 more bytes$/);
});
