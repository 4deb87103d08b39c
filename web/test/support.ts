import type { Clock } from "../src/core/clock";
import type { Wire, WireEvents } from "../src/core/connection";

/** Time that moves only when a test says so. */
export class TestClock implements Clock {
  private time = 0;
  private timers: { at: number; call: () => void }[] = [];

  now(): number {
    return this.time;
  }

  after(milliseconds: number, call: () => void): () => void {
    const timer = { at: this.time + milliseconds, call };
    this.timers.push(timer);
    return () => {
      this.timers = this.timers.filter((other) => other !== timer);
    };
  }

  /** Time passes and no timer runs: the machine sleeps. */
  sleep(milliseconds: number): void {
    this.time += milliseconds;
  }

  advance(milliseconds: number): void {
    const end = this.time + milliseconds;
    for (;;) {
      const due = this.timers.filter(({ at }) => at <= end).sort((a, b) => a.at - b.at)[0];
      if (!due) break;
      this.timers = this.timers.filter((timer) => timer !== due);
      this.time = Math.max(this.time, due.at);
      due.call();
    }
    this.time = end;
  }
}

/** A server that a test speaks for; it has every WebSocket that was opened. */
export class TestServer {
  readonly opened: { events: WireEvents; sent: Record<string, unknown>[]; closed: boolean }[] = [];

  open = (events: WireEvents): Wire => {
    const socket = { events, sent: [] as Record<string, unknown>[], closed: false };
    this.opened.push(socket);
    return {
      send: (text) => socket.sent.push(JSON.parse(text) as Record<string, unknown>),
      close: () => {
        socket.closed = true;
      },
    };
  };

  get last() {
    const socket = this.opened[this.opened.length - 1];
    if (!socket) throw new Error("nothing was opened");
    return socket;
  }

  say(frame: unknown): void {
    this.last.events.received(JSON.stringify(frame));
  }
}
