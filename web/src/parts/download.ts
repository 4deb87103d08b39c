/** Hands a text or bytes to the browser as a file. */
export function download(name: string, content: BlobPart, type: string): void {
  const address = URL.createObjectURL(new Blob([content], { type }));
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/** `rubicon-2026-11-22T12-04-31`. */
export function fileStamp(): string {
  return `rubicon-${new Date().toISOString().slice(0, 19).replaceAll(":", "-")}`;
}
