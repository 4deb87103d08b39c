import assert from "node:assert/strict";
import { test } from "node:test";
import { IgnoredDevices } from "../src/core/ignored";

const listOf = (...devices: unknown[]) => JSON.stringify({ count: devices.length, devices });
const mote = { key: "wsn-hall.seven", network: "wsn-hall", address: "7", by: "user" };

test("ignored devices are named by their address, as a decision names them", () => {
  const found = new IgnoredDevices().read([{ inbox: "6541:proxy.inbox", value: listOf(mote) }]);
  assert.deepEqual(
    found.map(({ id, owner, key, json }) => [id, owner, key, json]),
    [["6541:proxy.inbox.wsn-hall.7", 6541, "proxy.inbox.wsn-hall.7", mote]],
  );
});

test("a device that stays ignored stays the same row", () => {
  const devices = new IgnoredDevices();
  const read = (...lists: string[]) => devices.read(lists.map((value, index) => ({ inbox: `${index}:proxy.inbox`, value })));
  const [before] = read(listOf(mote), listOf(mote));
  const after = read(listOf({ network: "wsn-hall", address: "8" }, { ...mote, name: "Lamp" }));
  assert.equal(after.length, 2);
  assert.equal(after[1], before);
  assert.equal(before?.json.name, "Lamp");
});

test("a list that is none has no devices", () => {
  for (const value of ["", "7", "[1]", '{"devices":{}}', '{"devices":[1,null,"x"]}'])
    assert.deepEqual(new IgnoredDevices().read([{ inbox: "1:proxy.inbox", value }]), []);
});
