/** Time as the page's classes see it; tests replace it. */
export interface Clock {
  now(): number; // milliseconds
  after(milliseconds: number, call: () => void): () => void;
}

export const browserClock: Clock = {
  now: () => performance.now(),
  after(milliseconds, call) {
    const timer = setTimeout(call, milliseconds);
    return () => clearTimeout(timer);
  },
};
