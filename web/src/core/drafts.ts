/** What was typed for a point and is not in force yet, by the path of the point. It outlives its field, which may scroll away. */
export class Drafts {
  readonly #typed = new Map<string, string>();

  of(path: string): string | null {
    return this.#typed.get(path) ?? null;
  }

  type(path: string, value: string): void {
    this.#typed.set(path, value);
  }

  discard(path: string): void {
    this.#typed.delete(path);
  }

  /** A command with this value ended well. What was typed since stays. */
  done(path: string, value: string): void {
    if (this.#typed.get(path) === value) this.#typed.delete(path);
  }
}
