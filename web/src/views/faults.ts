import { number, text as textOf } from "../core/catalog";

/** An error that an island found in its file. */
export interface Fault {
  file: string;
  line: number;
  column: number;
  text: string;
}

export function faultsOf(status: Record<string, unknown>): Fault[] {
  if (!Array.isArray(status.errors)) return [];
  return status.errors.flatMap((error: unknown) => {
    if (typeof error !== "object" || error === null) return [];
    const member = error as Record<string, unknown>;
    return [{ file: textOf(member.file), line: number(member.line), column: number(member.column), text: textOf(member.text) }];
  });
}

export function placeOf({ file, line, column }: Fault): string {
  return [file, ...(line > 0 ? [line, column] : [])].filter((part) => part !== "").join(":");
}
