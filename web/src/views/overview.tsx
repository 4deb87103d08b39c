import { useLayoutEffect, useRef, useState } from "preact/hooks";
import {
  baseFeeds,
  catalog,
  hasRoom,
  islands,
  islandsKnown,
  loadingOf,
  measuredWants,
  noIslands,
  ownerPattern,
  server,
  useFeeds,
} from "../app";
import { moved } from "../core/overview";
import { second, useFrame } from "../core/redraw";
import type { Room } from "../core/rooms";
import { hrefTo } from "../core/router";
import { MayNot } from "../parts/may_not";
import { NoIsland } from "../parts/no_island";
import { NotWritten } from "../parts/not_written";
import { Empty, Loaded } from "../parts/state";
import * as text from "../words/overview";
import { arrangeRooms, mayArrange, orderOfRooms } from "./arrangement";
import { Attention } from "./attention";
import { Islands } from "./overview_islands";
import { Pinned } from "./pinned";
import { RoomCard } from "./room_card";
import { RoomPage, useRooms } from "./room";
import type { View } from "./views";

/** Up to so many devices, controls and words of all points come along; beyond, values only, and where these are too many none. */
const fewDevices = 1000;

/** The building at a glance: what needs attention, curves, rooms with their values and controls. */
function Overview() {
  useFrame();
  void second.value;
  const [arranging, setArranging] = useState(false);
  const owner = ownerPattern();
  const state = loadingOf(baseFeeds);
  const few = state === "ready" && catalog.devices.size <= fewDevices && hasRoom(3);
  const room = hasRoom(1);
  const leaves = few ? ["description", "status", "value"] : room && islandsKnown.value ? ["value"] : [];
  useFeeds([...leaves.map((leaf) => ({ pattern: `${owner}:*.*.*.*.*.${leaf}`, min: 500 })), ...measuredWants()]);
  const rooms = useRooms(orderOfRooms());
  if (noIslands()) return <NoIsland />;
  const may = mayArrange();
  return (
    <section class="overview">
      <div class="overview-head">
        <h1>{text.title}</h1>
        {may && rooms.length > 1 && (
          <button type="button" aria-pressed={arranging} onClick={() => setArranging(!arranging)}>
            {arranging ? text.arranged : text.arrange}
          </button>
        )}
      </div>
      <Loaded state={state} empty={state === "loading" && catalog.devices.size === 0}>
        <MayNot needs="command" />
        <NotWritten owners={[...islands.value, server.value]} />
        <Attention state={state} />
        {!room && <p class="strip">{text.tooMany}</p>}
        <Pinned arranging={arranging} />
        {rooms.length === 0 && state === "ready" && (
          <Empty title={text.noDevices}>
            <p>{text.noDevicesText}</p>
          </Empty>
        )}
        <Rooms rooms={rooms} arranging={arranging && may} />
        <Islands />
      </Loaded>
    </section>
  );
}

/** Rooms first, then, below a title of their own, networks whose devices have none. */
function Rooms({ rooms, arranging }: { rooms: Room[]; arranging: boolean }) {
  const placed = rooms.filter((room) => room.placed);
  const others = rooms.filter((room) => !room.placed);
  const names = placed.map(({ id }) => id);
  return (
    <>
      {placed.length > 0 && <h2 class="spoken">{text.rooms}</h2>}
      <Columns rooms={placed} arranging={arranging} order={names} />
      {others.length > 0 && (
        <div class="overview-head">
          <h2>{text.unplaced}</h2>
          <a href={hrefTo("devices", [], { group: "place" })}>{text.giveRooms}</a>
        </div>
      )}
      <Columns rooms={others} arranging={false} order={[]} />
    </>
  );
}

const columnWidth = 330;

/** Cards in columns of nearly one height. A card stays in its column whatever it shows, so that nothing jumps below the pointer. */
function Columns({ rooms, arranging, order }: { rooms: Room[]; arranging: boolean; order: string[] }) {
  const box = useRef<HTMLDivElement>(null);
  const [count, setCount] = useState(1);
  useLayoutEffect(() => {
    const element = box.current;
    if (!element) return undefined;
    const observer = new ResizeObserver(() => setCount(Math.max(1, Math.floor(element.clientWidth / columnWidth))));
    observer.observe(element);
    return () => observer.disconnect();
  }, []);
  const columns = Array.from({ length: Math.min(count, Math.max(rooms.length, 1)) }, () => ({ height: 0, rooms: [] as Room[] }));
  for (const room of rooms) {
    const column = columns.reduce((least, other) => (other.height < least.height ? other : least));
    column.rooms.push(room);
    column.height += 2 + Math.ceil(Math.min(room.facts.length, 6) / 3) * 2 + Math.min(room.tiles.length, 5) * 2;
  }
  return (
    <div ref={box} class="room-columns">
      {columns.map((column, index) => (
        <div key={index}>
          {column.rooms.map((room) => (
            <RoomCard key={room.id} room={room}>
              {arranging && <Movers name={room.name} order={order} />}
            </RoomCard>
          ))}
        </div>
      ))}
    </div>
  );
}

function Movers({ name, order }: { name: string; order: string[] }) {
  const move = (step: number) => arrangeRooms(moved(order, name, step));
  return (
    <span class="movers">
      <button type="button" class="small" aria-label={text.earlier(name)} disabled={order[0] === name} onClick={() => move(-1)}>
        ←
      </button>
      <button type="button" class="small" aria-label={text.later(name)} disabled={order[order.length - 1] === name} onClick={() => move(1)}>
        →
      </button>
    </span>
  );
}

export const overviewView: View = {
  id: "overview",
  title: text.title,
  key: "o",
  icon: "overview",
  show: ({ parts }) => (parts[0] ? <RoomPage key={parts[0]} id={parts[0]} /> : <Overview />),
};
