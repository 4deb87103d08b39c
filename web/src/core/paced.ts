import type { Clock } from "./clock";

/** Writes at once, then at most once in each pause; the last text is always written. */
export class Paced {
  #next = Number.NEGATIVE_INFINITY;
  #waiting: string | null = null;
  #stop = () => {};

  constructor(
    private readonly clock: Clock,
    private readonly pause: number, // milliseconds
    private readonly write: (text: string) => void,
  ) {}

  put(text: string): void {
    this.drop();
    this.#waiting = text;
    const wait = this.#next - this.clock.now();
    if (wait > 0) this.#stop = this.clock.after(wait, () => this.flush());
    else this.flush();
  }

  /** Writes now what waits. */
  flush(): void {
    const text = this.#waiting;
    this.drop();
    if (text === null) return;
    this.#next = this.clock.now() + this.pause;
    this.write(text);
  }

  /** Forgets what waits. */
  drop(): void {
    this.#stop();
    this.#waiting = null;
  }
}
