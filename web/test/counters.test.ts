import assert from "node:assert/strict";
import { test } from "node:test";
import { arrivalsOf, CounterRates, kindOf, lossesOf } from "../src/core/counters";
import { Tuple } from "../src/core/store";

function counter(name: string, value: string): Tuple {
  const tuple = new Tuple(`1:proxy.knx.property.${name}.value`, 1, `proxy.knx.property.${name}.value`);
  tuple.value = value;
  return tuple;
}

function counters(...all: [string, string][]): Map<string, Tuple> {
  return new Map(all.map(([name, value]) => [name, counter(name, value)]));
}

test("counters of all networks are told apart by what they count", () => {
  for (const name of ["dropped-readings", "refused-busy", "telegrams-lost", "bad-crc", "undeliverable", "share-dropped-gone", "lost-motes"])
    assert.equal(kindOf(name, "0"), "loss", name);
  for (const name of ["secure-plain-frames", "secure-forbidden", "data-secure-plain-dropped", "data-secure-no-key", "data-secure-other"])
    assert.equal(kindOf(name, "0"), "loss", name);
  for (const name of ["secure-sent", "secure-early", "secure-notifies-received", "data-secure-received"])
    assert.equal(kindOf(name, "3"), "flow", name);
  for (const name of ["unknown-devices", "repeats", "missing-acks", "unanswered-reads", "duplicates"])
    assert.equal(kindOf(name, "3"), "oddity", name);
  for (const name of ["readings", "telegrams-sent", "packets-read", "commands", "joins"]) assert.equal(kindOf(name, "3"), "flow", name);
  for (const [name, value] of [
    ["devices", "5"],
    ["attempts", "1"],
    ["server", "127.0.0.1"],
    ["bridge", "{}"],
    ["readings", ""],
  ] as const)
    assert.equal(kindOf(name, value), "fact", name);
});

test("what arrives is the first counter that moves, what is lost the sum of all losses", () => {
  const all = counters(["readings", "0"], ["packets-read", "197"], ["bad-crc", "2"], ["dropped-readings", "3"], ["unknown-devices", "9"]);
  assert.equal(arrivalsOf(all)?.value, "197");
  assert.equal(lossesOf(all), 5);
  assert.equal(arrivalsOf(counters(["readings", "0"]))?.value, "0");
  assert.equal(arrivalsOf(new Map()), undefined);
});

test("a rate needs two samples, and begins anew when the island does", () => {
  const rates = new CounterRates();
  const readings = counter("readings", "100");
  assert.ok(Number.isNaN(rates.of(readings)));
  rates.sample([readings], 10);
  assert.ok(Number.isNaN(rates.of(readings)));
  readings.value = "120";
  rates.sample([readings], 11); // too early: what came in the second before may not have been sent
  assert.ok(Number.isNaN(rates.of(readings)));
  rates.sample([readings], 12);
  assert.equal(rates.of(readings), 10);
  readings.value = "3";
  rates.sample([readings], 13);
  assert.ok(Number.isNaN(rates.of(readings)));
  assert.ok(Number.isNaN(rates.of(undefined)));
});
