/** Work that is asked for more often than it ends: one at a time, and once more after it if it was asked for meanwhile. */
export class OneAtATime {
  #running = false;
  #again = false;
  #ended = false;

  constructor(private readonly work: () => Promise<void>) {}

  ask(): void {
    if (this.#ended) return;
    this.#again = this.#running;
    if (this.#running) return;
    this.#running = true;
    void this.work().finally(() => {
      this.#running = false;
      if (this.#again) this.ask();
    });
  }

  end(): void {
    this.#ended = true;
  }
}
