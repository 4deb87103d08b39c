/** What an address of an upload becomes (docs/api.md, "Import"). */
export interface ImportPoint {
  address: string;
  state: string;
  name: string;
  room: string;
  /** `9.001`, `9.*` or empty. */
  dpt: string;
  kind: "sensor" | "actuator";
  /** Its key behind the network. */
  point: string;
  unit: string;
  notes?: string[];
}

export interface ImportFinding {
  level: "warning" | "error";
  line: number;
  address: string;
  text: string;
}

export interface DataPointType {
  dpt: string;
  meaning: string;
  unit: string;
}

export interface ImportPreview {
  form: string;
  merged: boolean;
  counts: Record<string, number>;
  findings: ImportFinding[];
  points: ImportPoint[];
  /** The group file. */
  groups: string;
  types?: DataPointType[];
}

/** What the user chose for an address. */
export interface ImportChoice {
  dpt?: string;
  kind?: "sensor" | "actuator";
  leave?: true;
}

export type ImportChoices = Record<string, ImportChoice>;

/** The island guessed, or knows no type. */
export function isUncertain({ dpt, notes }: ImportPoint): boolean {
  return dpt === "" || dpt.endsWith(".*") || (notes?.length ?? 0) > 0;
}

/** With another choice for one address; what equals the file is no choice. */
export function chosen(choices: ImportChoices, { address, dpt, kind }: ImportPoint, change: ImportChoice): ImportChoices {
  const next: ImportChoice = { ...choices[address], ...change };
  if (next.dpt === dpt || next.dpt === "") delete next.dpt;
  if (next.kind === kind) delete next.kind;
  if (!next.leave) delete next.leave;
  const { [address]: _, ...rest } = choices;
  return Object.keys(next).length === 0 ? rest : { ...rest, [address]: next };
}

/** The rows of a preview as they are after the choices: those that are left out stay as rows. */
export function withChoices(points: ImportPoint[], changed: ImportPoint[] | null): ImportPoint[] {
  if (!changed) return points;
  const now = new Map(changed.map((point) => [point.address, point]));
  return points.map((point) => {
    const next = now.get(point.address);
    return next ? { ...next, notes: point.notes } : point;
  });
}
