export interface NumberedLine {
  number: number;
  text: string;
}

/** The lines that contain the text, with those above them that say where they belong: the less indented ones. */
export function findLines(whole: string, search: string): NumberedLine[] {
  const lines = whole
    .replace(/\n$/, "")
    .split("\n")
    .map((text, index) => ({ number: index + 1, text }));
  if (search.trim() === "") return lines;
  const wanted = search.toLowerCase();
  const shown = new Set<NumberedLine>();
  const above: NumberedLine[] = [];
  for (const line of lines) {
    if (line.text.trim() === "") continue;
    const indent = indentOf(line.text);
    while (above.length > 0 && indentOf(above[above.length - 1]?.text ?? "") >= indent) above.pop();
    if (line.text.toLowerCase().includes(wanted)) for (const one of [...above, line]) shown.add(one);
    above.push(line);
  }
  return [...shown].sort((a, b) => a.number - b.number);
}

function indentOf(text: string): number {
  return text.length - text.trimStart().length;
}
