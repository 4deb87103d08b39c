import { baseFeeds, catalog, chosenIsland, loadingOf, measuredWants, useFeeds } from "../app";
import type { Device } from "../core/catalog";
import { usePaced } from "../core/hooks";
import { useFrame } from "../core/redraw";
import { type Room, roomsOf } from "../core/rooms";
import { hrefTo } from "../core/router";
import { Icon } from "../parts/icons";
import { MayNot } from "../parts/may_not";
import { Empty, Loaded, State } from "../parts/state";
import { Value } from "../parts/value";
import * as text from "../words/overview";
import { Curves } from "./pinned";
import { Facts } from "./room_card";
import { TileRow } from "./tile";

/** Each device is a subscription here; a connection has 256. */
const mostWants = 120;

/** The rooms of the island that the user chose, or of all; made again when devices and points change. */
export function useRooms(order: string[]): Room[] {
  const island = chosenIsland();
  const name = `${order.join()} ${island}`;
  const devices = () => [...catalog.devices.values()].filter(({ owner }) => !island || owner === island);
  return usePaced(`${catalog.structure} ${catalog.points}`, () => roomsOf(devices(), order), name);
}

/** One room: all that it measures, all that can be operated, its devices. */
export function RoomPage({ id }: { id: string }) {
  useFrame();
  const room = useRooms([]).find((one) => one.id === id);
  const devices = room?.devices ?? [];
  const wants = devices
    .slice(0, mostWants)
    .map(({ owner, prefix, network, id }) => ({ pattern: `${owner}:${prefix}.${network}.${id}.*.*.*` }));
  const feeds = useFeeds([...wants, ...measuredWants()]);
  const state = loadingOf([...baseFeeds, ...feeds]);
  return (
    <section class="overview room-page">
      <div class="overview-head">
        <a class="button plain" href={hrefTo("overview")} aria-label={text.title}>
          <Icon name="back" size={16} />
        </a>
        <h1>{room?.name ?? id}</h1>
      </div>
      <Loaded state={state} empty={!room && <Empty title={text.noRoom(id)} />}>
        <MayNot needs="command" />
        {room && room.facts.length > 0 && (
          <div class="card">
            <Facts room={room} facts={room.facts} />
          </div>
        )}
        {room && room.tiles.length > 0 && (
          <ul class="tiles tiles-wide">
            {room.tiles.map((tile) => (
              <TileRow key={`${tile.device.path} ${tile.kind} ${tile.instance}`} tile={tile} room={room.name} />
            ))}
          </ul>
        )}
        {room && <Curves points={room.facts.flatMap(({ points }) => points)} />}
        <h2>{text.roomDevices}</h2>
        <ul class="room-devices">
          {devices.map((device) => (
            <DeviceRow key={device.path} device={device} />
          ))}
        </ul>
      </Loaded>
    </section>
  );
}

function DeviceRow({ device }: { device: Device }) {
  return (
    <li>
      <a href={hrefTo("devices", device.path.split("/"))}>{device.name}</a>
      <State word={device.state} title={device.reason} />
      <span class="muted">{device.model}</span>
      <Value point={device.first} />
    </li>
  );
}
