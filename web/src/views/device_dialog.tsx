import { useState } from "preact/hooks";
import { catalog, useFeeds } from "../app";
import type { Device } from "../core/catalog";
import { roomNames } from "../core/rooms";
import { goToList } from "../core/router";
import { Dialog } from "../parts/dialog";
import { notify } from "../parts/notices";
import * as text from "../words/commission";
import * as zigbeeText from "../words/zigbee";
import { describe, dismiss, giveRoom } from "./commission";
import { changeZigbee, isZigbee } from "./zigbee_tool";

/** How a device goes: by its island, or by its network. */
type Going = "ignore" | "forget" | "remove";
const goings: Record<Going, { what: string; now(name: string): string; gone(name: string): string }> = {
  ignore: { what: text.ignoreWhat, now: text.ignoreNow, gone: text.gone.ignore },
  forget: { what: text.forgetWhat, now: text.forgetNow, gone: text.gone.forget },
  remove: { what: zigbeeText.removeWhat, now: zigbeeText.removeNow, gone: zigbeeText.removed },
};

/** A room to choose or to type. */
export function RoomField({ value, onInput }: { value: string; onInput(room: string): void }) {
  return (
    <label class="field">
      <span>{text.room}</span>
      <input
        type="text"
        list="known-rooms"
        maxLength={100}
        placeholder={text.roomHint}
        value={value}
        onInput={(event) => onInput(event.currentTarget.value)}
      />
      <datalist id="known-rooms">
        {roomNames(catalog.devices.values()).map((room) => (
          <option key={room} value={room} />
        ))}
      </datalist>
    </label>
  );
}

/** Name and room of a device, and how to be rid of it. */
export function DeviceDialog({ device, onClose }: { device: Device; onClose(): void }) {
  const [name, setName] = useState(device.name === device.id ? "" : device.name);
  const [room, setRoom] = useState(device.area);
  const [error, setError] = useState("");
  const [going, setGoing] = useState<Going | null>(null);
  useFeeds([{ pattern: `${device.owner}:${device.prefix}.${device.network}.property.bridge.value`, min: 1000 }]);
  const network = catalog.networks.get(`${device.owner}/${device.network}`);
  const save = (event: Event) => {
    event.preventDefault();
    const change = { ...(name.trim() !== device.name && { name: name.trim() }), ...(room.trim() !== device.area && { area: room.trim() }) };
    if (Object.keys(change).length === 0) return onClose();
    describe(device, change, (answer) => {
      if (answer.error) return setError(answer.error.text);
      notify(text.saved(name.trim() || device.id), "good");
      onClose();
    });
  };
  const left = (how: Going, why: string | undefined) => {
    if (why !== undefined) return setError(why);
    notify(goings[how].gone(device.name), "good");
    onClose();
    goToList("devices");
  };
  const leave = (how: Going) => {
    if (how !== "remove") return dismiss(device, how, ({ error }) => left(how, error?.text));
    const address = String(device.description?.json.address ?? device.id);
    const request = { do: "remove", device: address };
    if (network) changeZigbee(network, request, (reply) => left(how, reply.ok === true ? undefined : String(reply.why ?? "")));
  };
  return (
    <Dialog title={text.editDevice(device.name)} onClose={onClose}>
      <form class="form-grid" onSubmit={save}>
        <label class="field">
          <span>{text.name}</span>
          <input
            type="text"
            autofocus
            maxLength={100}
            placeholder={text.nameHint}
            value={name}
            onInput={(event) => setName(event.currentTarget.value)}
          />
        </label>
        <RoomField value={room} onInput={setRoom} />
        <p role="alert" class="error">
          {error}
        </p>
        {going ? (
          <>
            <p>{goings[going].what}</p>
            <div class="actions">
              <button type="button" class="primary" onClick={() => leave(going)}>
                {goings[going].now(device.name)}
              </button>
              <button type="button" onClick={() => setGoing(null)}>
                {text.cancel}
              </button>
            </div>
          </>
        ) : (
          <div class="actions">
            <button type="submit" class="primary">
              {text.save}
            </button>
            <span class="space" />
            {isZigbee(network) && (
              <button type="button" onClick={() => setGoing("remove")}>
                {zigbeeText.remove}
              </button>
            )}
            <button type="button" onClick={() => setGoing("ignore")}>
              {text.ignore}
            </button>
            <button type="button" onClick={() => setGoing("forget")}>
              {text.forget}
            </button>
          </div>
        )}
      </form>
    </Dialog>
  );
}

/** One room for several devices. */
export function RoomDialog({ devices, onClose }: { devices: Device[]; onClose(): void }) {
  const [room, setRoom] = useState("");
  const give = (event: Event) => {
    event.preventDefault();
    giveRoom(devices, room.trim());
    onClose();
  };
  return (
    <Dialog title={text.giveRoomTitle(devices.length)} onClose={onClose}>
      <form class="form-grid" onSubmit={give}>
        <RoomField value={room} onInput={setRoom} />
        <p class="muted">{devices.map(({ name }) => name).join(", ")}</p>
        <div class="actions">
          <button type="submit" class="primary">
            {text.give}
          </button>
        </div>
      </form>
    </Dialog>
  );
}
