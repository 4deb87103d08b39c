/** Strokes on a field of 20 by 20. */
const paths: Record<string, string> = {
  overview: "M3 3h6v6H3zM11 3h6v6h-6zM3 11h6v6H3zM11 11h6v6h-6z",
  devices: "M4 5h12M4 10h12M4 15h12M2 5h.01M2 10h.01M2 15h.01",
  tuples: "M4 3v12h5M4 8h5M12 6h5M12 8h5v0M9 8h.01M12 14h5",
  plots: "M3 3v14h14M5 13l3-5 3 3 5-7",
  inbox: "M3 11l2-7h10l2 7v5H3zM3 11h4l1 2h4l1-2h4",
  networks: "M10 3v4M10 7H5v4M10 7h5v4M3 11h4v4H3zM13 11h4v4h-4zM8 3h4",
  traffic: "M3 7h12l-3-3M17 13H5l3 3",
  recordings: "M10 17a7 7 0 1 0 0-14 7 7 0 0 0 0 14zM10 12a2 2 0 1 0 0-4 2 2 0 0 0 0 4z",
  log: "M4 4h12M4 8h8M4 12h12M4 16h6",
  settings: "M3 6h8M15 6h2M13 4v4M3 14h2M9 14h8M7 12v4",
  search: "M9 15A6 6 0 1 0 9 3a6 6 0 0 0 0 12zM13.5 13.5L17 17",
  pin: "M7 3h6l-1 6 3 3H5l3-3zM10 12v5",
  more: "M4 10h.01M10 10h.01M16 10h.01",
  back: "M12 4l-6 6 6 6",
  help: "M7.5 7.5a2.5 2.5 0 1 1 3.5 2.3c-.7.4-1 .9-1 1.7M10 14.5h.01",
  logout: "M12 5V3H4v14h8v-2M8 10h9M14 7l3 3-3 3",
  theme: "M10 3a7 7 0 1 0 0 14zM10 3a7 7 0 0 1 0 14",
};

export function Icon({ name, size = 20 }: { name: string; size?: number }) {
  return (
    <svg class="icon" viewBox="0 0 20 20" width={size} height={size} aria-hidden="true">
      <path d={paths[name] ?? ""} />
    </svg>
  );
}
