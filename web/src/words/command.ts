// Texts of controls and outcomes of commands.

export const set = "Set";
export const unknown = "unknown";
export const commanded = (value: string) => `set to ${value}`;
export const by = (commander: string) => `by ${commander}`;
export const range = (minimum?: number, maximum?: number) =>
  minimum === undefined && maximum === undefined ? "" : `${minimum ?? "…"} to ${maximum ?? "…"}`;
export const spoken = (point: string, value: string, state: string, reason: string) =>
  `${point} set to ${value}: ${state}${reason ? `, ${reason}` : ""}`;
export const waits = "Commands wait";
export const until = (time: string) => `waits until ${time}`;
export const discard = (point: string) => `Discard what was entered for ${point}`;
export const colour = "Colour";
export const colourOf = (point: string) => `Colour of ${point}`;
export const hue = "Hue";
export const saturation = "Saturation";
export const kelvin = (kelvin: string) => `${kelvin}\u00a0K`;
export const white = "White";
export const whiteOf = (point: string) => `White light of ${point}`;
