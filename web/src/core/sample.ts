/** An option of a network, as its sample has it. */
export interface SampleField {
  key: string;
  /** An example, in YAML. */
  value: string;
  /** What the sample says of it. */
  about: string;
  /** The sample has it in a comment: there is a default. */
  optional: boolean;
}

/** What a form can be made of: options of one line each, and those of several lines as they are. */
export interface Sample {
  fields: SampleField[];
  blocks: string;
}

const indent = "  ";

/** `tunnel   # tunnel (UDP) or routing` or, in a comment, `3671   a fixed port`: the value and what is said of it. */
function split(text: string, commented: boolean): [value: string, about: string] {
  const found = /^("[^"]*"|\{.*?\}|\[.*?\]|\S*(?: \S+)*?)(?:\s+#\s*|\s{2,})(.*)$/.exec(text);
  if (found) return [found[1] ?? "", found[2] ?? ""];
  return commented && /^\S+ /.test(text) && !/^["[{]/.test(text) ? [text.split(" ", 1)[0] ?? "", text.replace(/^\S+ +/, "")] : [text, ""];
}

/** The sample of a type of networks: a map of one network, which the parser of the island has read. */
export function readSample(text: string): Sample {
  const fields: SampleField[] = [];
  const blocks: string[] = [];
  let block = false;
  for (const line of text.split("\n")) {
    const option = /^ {2}(# )?([a-z][\w-]*):(?:\s+(.*))?$/i.exec(line);
    if (!option) {
      const more = /^\s*#\s+(.*)$/.exec(line);
      const last = fields[fields.length - 1];
      if (block && line.startsWith(indent + indent)) blocks.push(line.slice(indent.length));
      else if (!block && more && line.startsWith(indent) && last) last.about = `${last.about} ${more[1]}`.trim();
      continue;
    }
    const [, comment = "", key = "", rest = ""] = option;
    block = comment === "" && (rest === "" || rest.startsWith("#"));
    if (block) blocks.push(line.slice(indent.length));
    else if (key !== "type") {
      const [value, about] = split(rest, comment !== "");
      fields.push({ key, value, about, optional: comment !== "" });
    }
  }
  return { fields, blocks: blocks.join("\n") };
}

/** Quoted unless YAML reads it as the same text. */
export function scalar(text: string): string {
  return /^[A-Za-z0-9_./][\w./@-]*(?::[\w./@-]+)*$/.test(text) && text !== "null" ? text : JSON.stringify(text);
}

/** The options of a network: what was typed, in the order of the fields, then further lines. */
export function optionsText(type: string, values: [key: string, value: string][], more: string): string {
  const lines = values.flatMap(([key, value]) => (value.trim() === "" ? [] : [`${key}: ${value.trim()}`]));
  return `${[`type: ${type}`, ...lines, ...(more.trim() === "" ? [] : [more.replace(/\s+$/, "")])].join("\n")}\n`;
}
