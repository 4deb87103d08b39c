const usual = 5;

/** How many seconds commands may wait for their line or device. Only the device whose page is shown may have its own choice. */
export class Patience {
  #device = "";
  #chosen = usual;

  of(device: string): number {
    return device === this.#device ? this.#chosen : usual;
  }

  choose(device: string, seconds: number): void {
    this.#device = device;
    this.#chosen = seconds;
  }

  /** The page of the device was left. */
  forget(device: string): void {
    if (device === this.#device) this.#device = "";
  }
}
