import { signal } from "@preact/signals";
import { catalog } from "../app";
import type { Device } from "../core/catalog";
import { roomNames } from "../core/rooms";
import * as text from "../words/commission";
import { giveRoom } from "./commission";

/** Devices that are being dragged. */
export const dragged = signal<Device[]>([]);

/** While devices are dragged: the rooms to drop them on. `onOther` asks for one that is not there yet. */
export function RoomTargets({ onOther }: { onOther(devices: Device[]): void }) {
  const devices = dragged.value;
  if (devices.length === 0) return null;
  const drop = (room: string | null) => (event: DragEvent) => {
    event.preventDefault();
    dragged.value = [];
    if (room === null) onOther(devices);
    else giveRoom(devices, room);
  };
  const targets: [string, string | null][] = [
    ...roomNames(catalog.devices.values()).map((room): [string, string] => [room, room]),
    [text.noRoom, ""],
    [text.newRoom, null],
  ];
  return (
    <aside class="room-targets" aria-label={text.dropHere(devices.length)}>
      <p class="muted">{text.dropHere(devices.length)}</p>
      {targets.map(([name, room]) => (
        <div
          key={name}
          class="room-target"
          onDragOver={(event) => event.preventDefault()}
          onDragEnter={(event) => event.currentTarget.classList.add("over")}
          onDragLeave={(event) => event.currentTarget.classList.remove("over")}
          onDrop={drop(room)}
        >
          {name}
        </div>
      ))}
    </aside>
  );
}
