/** Where the rows of a list are, in pixels. */
export interface Layout {
  readonly count: number;
  readonly total: number;
  /** Browsers clip very high elements: the element is at most this high, and scrolling is scaled. */
  readonly drawnTotal: number;
  offset(index: number): number;
  height(index: number): number;
  indexAt(pixel: number): number;
  /** The scroll position at which this offset is at the top. */
  scrollOf(offset: number): number;
}

/** Firefox clips at 17.8 million pixels, Chromium at 33.5. */
export const highest = 15_000_000;

export function layoutOf(count: number, heights: number | ((index: number) => number)): Layout {
  return typeof heights === "number" ? uniform(count, heights) : varied(count, heights);
}

function uniform(count: number, height: number): Layout {
  const total = count * height;
  const drawnTotal = Math.min(total, highest);
  return {
    count,
    total,
    drawnTotal,
    offset: (index) => index * height,
    height: () => height,
    indexAt: (pixel) => clamp(Math.floor(pixel / height), count),
    scrollOf: (offset) => (offset * drawnTotal) / Math.max(total, 1),
  };
}

function varied(count: number, heightOf: (index: number) => number): Layout {
  const offsets = new Float64Array(count + 1);
  for (let index = 0; index < count; index++) offsets[index + 1] = (offsets[index] ?? 0) + heightOf(index);
  const total = offsets[count] ?? 0;
  const offset = (index: number) => offsets[index] ?? 0;
  return {
    count,
    total,
    drawnTotal: Math.min(total, highest),
    offset,
    height: (index) => offset(index + 1) - offset(index),
    indexAt(pixel) {
      let low = 0;
      let high = count;
      while (low < high) {
        const middle = (low + high) >> 1;
        if (offset(middle + 1) <= pixel) low = middle + 1;
        else high = middle;
      }
      return clamp(low, count);
    },
    scrollOf: (at) => (at * Math.min(total, highest)) / Math.max(total, 1),
  };
}

function clamp(index: number, count: number): number {
  return Math.max(0, Math.min(index, count - 1));
}

/** Rows drawn beyond the window, above and below. */
export const margin = 8;

/** The rows to draw at a scroll position, and by how much they are moved because scrolling is scaled. */
export function shownRows(layout: Layout, scrollTop: number, height: number): { first: number; end: number; shift: number } {
  if (layout.count === 0) return { first: 0, end: 0, shift: 0 };
  const room = Math.max(layout.drawnTotal - height, 1);
  const scaled = layout.drawnTotal === layout.total ? scrollTop : (Math.min(scrollTop, room) / room) * (layout.total - height);
  const first = Math.max(0, layout.indexAt(scaled) - margin);
  const end = Math.min(layout.count, layout.indexAt(scaled + height) + 1 + margin);
  return { first, end, shift: scrollTop - scaled };
}
