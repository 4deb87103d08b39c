// Texts of what changes the file of the configuration: networks that are added, KNX files that are imported.
import { many } from "../core/text";

export const add = "Add a network …";
export const addTitle = "Add a network";
export const importKnx = "Import KNX …";
export const importTitle = "Import KNX";
export const type = "Kind of network";
export const network = "Its id";
export const networkHint = "as in keys: knx-hall";
export const more = "More options, in YAML";
export const blocks = "Insert those of the sample";
export const sample = "Sample with all options";
export const further = (count: number) => many(count, "more option");
export const check = "Check …";
export const checking = "The island reads the new file …";
export const noTypes = "This island has another release: it does not tell its kinds of networks.";

export const file = "Project or export of ETS";
export const fileHint = ".knxproj, .csv, .xml, .esf; at most 32 MB";
export const password = "Password of the project";
export const passwordHint = "of protected projects";
export const into = "Into";
export const aNew = "a new network";
export const via = "Connection";
export const host = "Address of the KNX interface";
export const names = "Names decide where types do not";
export const preview = "Show what it becomes";
export const reading = "The island reads the file …";
export const tooLarge = (size: number) =>
  `The file has ${Math.ceil(size / 2 ** 20)} MB, more than 32: import it on the host with \`rubicon knx import\`.`;
export const tooMany = (size: number) =>
  `The group file has ${(size / 1e6).toFixed(1)} MB, more than the 0.9 that can be set here. On the host of the island: \`rubicon knx import FILE --output hall.yaml\`, then \`import: hall.yaml\` in the configuration.`;
export const noNetwork = "Give the network an id.";
export const noHost = "Name the address of the KNX interface.";
export const counts = ({ taken = 0, paired = 0, secured = 0, errors = 0, warnings = 0 }: Record<string, number>) =>
  [
    many(taken, "address", "addresses"),
    ...(paired ? [`${many(paired, "state address", "state addresses")} found`] : []),
    ...(secured ? [`${secured.toLocaleString()} secured`] : []),
    ...(warnings ? [many(warnings, "warning")] : []),
    ...(errors ? [`${many(errors, "error")}: not imported`] : []),
  ].join(", ");
export const merged = "Ids, types and kinds of the group file that the network has are kept.";
export const findings = (count: number) => many(count, "finding");
export const uncertain = (count: number) => `Only the ${count.toLocaleString()} uncertain`;
export const filtered = "No address matches.";
export const address = "Address";
export const name = "Name";
export const becomes = "Becomes";
export const dpt = "Type";
export const noDpt = "none: hex";
export const kind = "Kind";
export const kinds = { sensor: "sensor", actuator: "actuator" };
export const take = "Import";
export const takeOf = (address: string) => `Import ${address}`;
export const dptOf = (address: string) => `Type of ${address}`;
export const kindOf = (address: string) => `Kind of ${address}`;
export const why = "Why";
export const leftOut = "left out";
export const state = (address: string) => `state ${address}`;
export const noType = "it has no type: its values are shown as hex";
export const mainOnly = "only the main type is known";
export const line = (line: number, text: string) => (line > 0 ? `line ${line}: ${text}` : text);

export const changeTitle = {
  add: (network: string) => `Add ${network}`,
  import: (network: string) => `Import into ${network}`,
  undo: () => "Return to the previous file",
};
export const wouldDo = (count: number) => (count === 0 ? "Nothing would change." : `${many(count, "change")} of the running island:`);
export const faults = (count: number) => `${many(count, "error")}: nothing was changed.`;
export const patch = (file: string) => `What is inserted into ${file}:`;
export const fixed = (file: string, why: string) =>
  `The island cannot write ${file} (${why}). Insert this yourself, then reload on the view Settings:`;
export const groupFile = "Save the group file";
export const apply = (file: string) => `Write ${file} and reload`;
export const applying = "The island takes the new file …";
export const back = "Back";
export const done = { add: "The network is there.", import: "The addresses are there.", undo: "The previous file is in force again." };
export const undo = "Undo";
export const previous = "Previous file …";
export const previousTitle = "Shows first what going back to the file before the last change would do.";
export const noOutcome = "The island does not say what came of it.";
